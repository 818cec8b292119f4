//! Hardening: a driver with a bad key is repaired within the limits, with the same result at any number of threads.

use std::path::{Path, PathBuf};

use base::seed::Seed;
use compile::{Campaign, Catalog, Harden, compile};
use results::campaign::{NoStore, Silent, run};
use results::jobs::Measured;
use search::hardening::Hardened;

fn compiled(block: &str) -> Result<Campaign, String> {
    let text = format!(
        "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/rewards.scn\"\nimport \"std/towns.scn\"\n\
         driver late = aeb(full: 0.3 s, partial: 0.4 s)\n\
         spawn near {{ ego_speed: 20 km/h .. 50 km/h bearing: -60 deg .. 60 deg distance: 7 m .. 40 m }}\n\
         episode short {{ ticks: 240 hold: 10 end_when: ahead < -6 m }}\n\
         method crossings = archive(reward: fault)\n\
         method meet = intercept()\n\
         campaign c {{ vehicle: model3 body: plausible spawn: near episode: short\n{block} }}"
    );
    let root = crate::repository().join("scenarios/test_of_hardening.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let files: [PathBuf; 1] = [root.clone()];
    let compiled = compile(&files, &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let messages: Vec<String> = compiled.diagnostics.iter().map(|each| format!("{each:?}")).collect();
    compiled.plan.map(|plan| plan.campaigns[0].clone()).ok_or_else(|| messages.join("\n"))
}

const SMALL: &str = "towns: [harbour] test_towns: [village] methods: [crossings] rivals: [meet] budget: 12_000 rounds: 2 \
                     candidates: 14 lessons: 5 traffic: 15 episodes: 60 runs: 1";

fn harden(keys: &str, threads: usize) -> Measured<Harden> {
    let campaign = compiled(&format!("harden {{ {SMALL} driver: late {keys} }}")).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let finished = pool.install(|| run(&campaign, &Seed::root(1), &NoStore, &Silent));
    finished.all::<Measured<Harden>>()[0].clone()
}

fn found(result: &Measured<Harden>) -> &Hardened {
    result.found.as_ref().unwrap()
}

#[test]
fn a_brake_that_is_too_late_becomes_an_earlier_one_at_any_number_of_threads() {
    let range = "from: aeb(full: 0.3 s, partial: 0.4 s) to: aeb(full: 1.4 s, partial: 1.5 s) progress: 50 percent comfort: 100 percent";
    let (one, two) = (harden(range, 1), harden(range, 2));
    assert_eq!(one.found, two.found);
    let hardened = found(&one);
    assert_eq!(hardened.rounds.len(), 2);
    let last = hardened.rounds.last().unwrap();
    assert!(last.faults_before >= 5 && 2 * last.faults_after <= last.faults_before, "{last:?}");
    // The emergency brake may not act later than the partial one.
    assert!(hardened.values[0] <= hardened.values[1] && hardened.values[1] > 0.4, "{:?}", hardened.values);
    let line = one.job.written.line(&hardened.values);
    assert!(line.starts_with("driver late_hardened = aeb(full: ") && line.ends_with(" s)"), "{line}");
    let again = compiled(&format!(
        "search {{ towns: [harbour] drivers: [idm] methods: [meet] }} }}\n{line}\nspawn other {{ bearing: 0 deg distance: 20 m"
    ));
    assert!(again.is_ok(), "{again:?}");
    assert_eq!(hardened.tests.len(), 2);
    assert!(hardened.tests.iter().all(|test| test.town == "village" && test.starts > 10 && test.new <= test.after));
}

#[test]
fn a_limit_without_slack_leaves_a_driver_that_can_only_slow_down_as_it_is() {
    // Less of the limit costs progress, and none may be lost.
    let result = harden("from: aeb(limit_share: 0.1) to: aeb(limit_share: 0.5) progress: 0 percent", 1);
    let hardened = found(&result);
    assert_eq!(hardened.values, result.job.hardening.driver.before());
    assert!(hardened.rounds.iter().all(|round| round.within < round.candidates));
    assert!(hardened.tests.iter().all(|test| test.before == test.after && test.new == 0));
}

#[test]
fn keys_that_cannot_be_varied_are_reported() {
    let wrong = |keys: &str| compiled(&format!("harden {{ {SMALL} driver: late {keys} }}")).unwrap_err();
    for (keys, message) in [
        ("from: idm(margin: 0 m) to: idm(margin: 1 m)", "`from` is of kind `idm`, and `late` of kind `aeb`"),
        ("from: aeb(full: 0.1 s) to: aeb(full: 0.1 s)", "`from` and `to` are equal"),
        ("from: aeb(full: 0.1 s, margin: 0 m) to: aeb(full: 0.2 s)", "`from` states `margin` and `to` does not"),
        ("from: aeb(sensors: poor) to: aeb(sensors: good)", "`sensors` is not a quantity"),
    ] {
        let said = wrong(keys);
        assert!(said.contains(message), "{keys}: {said}");
    }
    let same = compiled(
        "harden { towns: [harbour] test_towns: [harbour] methods: [meet] driver: late from: aeb(full: 0.1 s) to: aeb(full: 0.2 s) }",
    );
    assert!(same.unwrap_err().contains("the driver is repaired in this town"));
}
