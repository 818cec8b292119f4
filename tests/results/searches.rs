//! Falsifiers at equal budget: what they find, what it costs, and that both are counted correctly.

use std::path::Path;

use base::seed::Seed;
use compile::{Campaign, Catalog, compile};
use results::campaign::{self, Silent};
use results::jobs::SearchResult;
use results::report;
use verdict::Blame;

const PIECES: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/rewards.scn"
import "lib/drivers.scn"
town straight { street quay { through: [(0 m, 0 m), (400 m, 0 m)] } }
episode ten_seconds { ticks: 200 }
spawn in_the_way { ego_speed: 0 m/s  ego_poses: [(20 m, -1.75 m, 0 deg)]  bearing: -2 deg .. 2 deg  distance: 7 m .. 12 m }
spawn far_aside { ego_speed: 0 m/s  ego_poses: [(20 m, -1.75 m, 0 deg)]  bearing: 20 deg .. 22 deg  distance: 28 m .. 29 m }
body slow { speed: 0 m/s .. 2 m/s  observation_frame: line_of_sight  action_frame: line_of_sight  ramp: 0 s  turning: 20 Hz }
training two = ppo(environments: 2, steps_per_update: 32)
method chance = random()
method home = homing()
method meet = intercept()
method cross = cem(tries: 1000)
method strategy = cma_es(tries: 1000)
method tree = mcts(reward: ast, tries: 1000)
method learner = ppo(reward: r1)
method pair = ppo(reward: r1, training: two)
method kinds = archive(reward: moving)
method narrow = archive(reward: moving, explore: 0, choice: 0)
method grid = exhaustive(levels: 2)
reward moving { on touch(moving) => 1 }
"#;

fn campaign(text: &str) -> Campaign {
    let root = crate::repository().join("scenarios/searches.scn");
    let text = format!("{PIECES}\n{text}");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

fn obvious(falsifiers: &str, budget: u64, runs: u32) -> Campaign {
    campaign(&format!(
        "campaign obvious {{ vehicle: model3 body: suicidal spawn: in_the_way episode: ten_seconds training: ppo_paper
         search {{ towns: [straight] drivers: [blind] methods: [{falsifiers}] budget: {budget} runs: {runs} episodes: 20 }} }}"
    ))
}

fn run(campaign: &Campaign) -> Vec<SearchResult> {
    run_seeded(campaign, 5)
}

fn run_seeded(campaign: &Campaign, seed: u64) -> Vec<SearchResult> {
    campaign::run(campaign, &Seed::root(seed), &campaign::NoStore, &Silent).all().to_vec()
}

#[test]
fn every_falsifier_finds_the_obvious_failure_within_its_budget() {
    let (budget, hold) = (20_001, 20);
    let plan = obvious("chance, home, meet, cross, strategy, tree, learner, pair, kinds, narrow, grid", budget, 1);
    for (search, result) in plan.all::<compile::Search>().zip(run(&plan)) {
        let (name, spent) = (&search.key.falsifier, &result.spent);
        assert!(spent.ticks <= budget, "{name}: {} ticks", spent.ticks);
        // Two environments have half of the budget each. The first that uses up its half ends the training.
        let idle = if name == "pair" { budget / 2 } else { hold - 1 };
        assert!(spent.ticks + idle >= budget, "{name}: {} ticks", spent.ticks);
        assert!(!spent.failures.is_empty(), "{name} found nothing");
        assert!(spent.failures.is_sorted_by_key(|failure| failure.ticks), "{name}");
        assert!(spent.failures.last().unwrap().ticks <= spent.ticks, "{name}");
        assert!(spent.failures.len() as u64 <= spent.episodes && spent.starts.count() <= spent.episodes, "{name}");
        let walks = ["chance", "home", "meet", "learner", "pair", "kinds", "narrow"].contains(&name.as_str());
        assert_eq!(result.evaluated.len(), if walks { 20 } else { 0 }, "{name}");
        for find in result.failures() {
            let again = find.repeatable(search).repeat(&Seed::root(5)).map(|repeated| repeated.judged.outcome);
            assert_eq!(again, Some(find.failure.outcome), "{name}: a failure does not repeat");
        }
    }
}

#[test]
fn ticks_are_those_of_all_episodes_up_to_the_failure() {
    let results = run(&obvious("home, cross, pair", 20_001, 1));
    let home = &results[0].spent;
    let mut used = 0;
    for failure in &home.failures {
        // Bumps lie between the failures.
        used += u64::from(failure.outcome.ticks);
        assert!(failure.ticks >= used, "{} of {used}", failure.ticks);
        used = failure.ticks;
    }
    assert!(home.failures.iter().any(|failure| failure.start > 0) && home.episodes > home.failures.len() as u64);
    for result in &results {
        let failed: u64 = result.spent.failures.iter().map(|failure| u64::from(failure.outcome.ticks)).sum();
        assert!(failed <= result.spent.ticks);
    }
    // A method that leaves a start after a failure never fails there twice.
    let mut starts: Vec<u64> = results[1].spent.failures.iter().map(|failure| failure.start).collect();
    starts.dedup();
    assert_eq!(starts.len(), results[1].spent.failures.len());
}

#[test]
fn a_budget_too_small_for_a_command_buys_nothing_and_odd_ones_are_never_exceeded() {
    for budget in [1, 19, 20, 39, 1234] {
        for result in run(&obvious("chance, home, cross, tree, learner, pair, kinds", budget, 1)) {
            assert!(result.spent.ticks <= budget, "{}: {budget}", result.key.falsifier);
            if budget < 20 {
                assert_eq!((result.spent.ticks, result.spent.episodes), (0, 0), "{}", result.key.falsifier);
            }
        }
    }
}

#[test]
fn searches_are_the_same_on_any_number_of_threads_and_differ_between_runs() {
    let plan = obvious("chance, cross, strategy, tree, learner, pair, kinds", 6_000, 2);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&plan))
    };
    let (one, four) = (on(1), on(4));
    assert_eq!(one.len(), 14);
    for (a, b) in one.iter().zip(&four) {
        assert_eq!((&a.key, &a.spent, &a.evaluated), (&b.key, &b.spent, &b.evaluated));
    }
    assert_ne!(one[0].spent.failures, one[1].spent.failures);
}

#[test]
fn starts_are_shared_and_a_second_falsifier_changes_nothing_for_the_first() {
    let (alone, both) = (run(&obvious("cross", 3_000, 1)), run(&obvious("home, cross", 3_000, 1)));
    assert_eq!(alone[0].spent, both[1].spent);
    let (home, cross) = (&both[0].spent.failures, &both[1].spent.failures);
    let met = cross.iter().filter_map(|a| home.iter().find(|b| b.start == a.start).map(|b| (a, b)));
    let pairs: Vec<_> = met.collect();
    assert!(!pairs.is_empty());
    assert!(pairs.iter().all(|(a, b)| a.outcome.spawn == b.outcome.spawn));
}

#[test]
fn searches_with_a_goal_find_what_walking_at_random_does_not() {
    let plan = campaign(
        "campaign rare { vehicle: model3 body: slow spawn: far_aside episode: ten_seconds training: ppo_paper
         search { towns: [straight] drivers: [idm] methods: [chance, home, meet, cross, strategy, tree]
                  budget: 150_000 runs: 4 episodes: 0 } }",
    );
    let results = run_seeded(&plan, 11);
    let found = |name: &str| {
        let of_name = results.iter().filter(|result| result.key.falsifier == name);
        of_name.filter(|result| !result.spent.failures.is_empty()).count()
    };
    for name in ["chance", "home", "meet"] {
        assert_eq!(found(name), 0, "{name} was not expected to find anything");
    }
    for name in ["cross", "strategy", "tree"] {
        assert!(found(name) >= 3, "{name} found something in {} of 4 runs", found(name));
    }
}

#[test]
fn the_cells_count_censored_runs() {
    use results::report::{all_of_searches, search_cells, searches};
    let plan = obvious("home", 2_000, 4);
    let mut results = run(&plan);
    for result in &mut results[2..] {
        result.spent.failures.clear();
    }
    let cell = &search_cells(&results, &all_of_searches(&results))[0];
    assert_eq!(cell.runs(), [4, 2]);
    // Half of the runs found a failure: the median is the later of the two.
    let later = results[..2].iter().map(|result| result.spent.failures[0].ticks).max().unwrap();
    assert_eq!(cell.number("first_failure_ticks_median"), Some(later as f64));
    let table = searches(&results);
    assert_eq!(table.height(), 4);
}

const CROSSING: &str = r#"
spawn ahead_of_a_moving_car {
  ego_poses: [(20 m, -1.75 m, 0 deg)]  bearing: -40 deg .. 40 deg  distance: 15 m .. 40 m  ego_speed: 6 m/s .. 8 m/s
}
episode until_passed { hold: 10  ticks: 400  end_when: ahead < -6 m }
reward faulty {
  on touch(fault) => 1
  on touch(preventable) => 0.3
  on touch(moving) => 0.1
}
"#;

#[test]
fn an_archive_finds_more_kinds_of_faults_than_an_interception_and_ends_with_a_better_controller() {
    let plan = campaign(&format!(
        "import \"lib/pedestrians.scn\"
         {CROSSING}
         campaign faults {{ vehicle: model3 body: plausible spawn: ahead_of_a_moving_car episode: until_passed training: ppo_paper
         search {{ towns: [straight] drivers: [blind] methods: [meet, faults] budget: 150_000 runs: 1 episodes: 200 }} }}
         method faults = archive(reward: faulty)"
    ));
    let results = run(&plan);
    let distinct = |result: &SearchResult| {
        let faults = result.failures().filter(|find| find.is(Blame::Fault));
        faults.map(|find| find.failure.cell).collect::<std::collections::BTreeSet<_>>().len()
    };
    let controller = |result: &SearchResult| {
        result.evaluated.iter().filter(|each| each.is(result.criterion(), Blame::Fault)).count()
    };
    let (meet, archive) = (&results[0], &results[1]);
    assert!(distinct(archive) > 2 * distinct(meet), "{} against {}", distinct(archive), distinct(meet));
    assert!(controller(archive) > controller(meet), "{} against {}", controller(archive), controller(meet));
}

#[test]
fn every_failure_of_a_search_has_a_verdict() {
    let campaign = obvious("chance, home, cross", 20_000, 2);
    let results = run(&campaign);
    let mut preventable = 0;
    for result in &results {
        for find in result.failures() {
            let (failure, verdict) = (find.failure, find.verdict().expect("the driver is deterministic"));
            assert_eq!(Some(verdict.impact_speed), failure.outcome.impact_speed());
            preventable += u64::from(verdict.is_preventable());
        }
    }
    let failures: usize = results.iter().map(|result| result.spent.failures.len()).sum();
    assert!(failures > 0);
    let table = report::searches(&results);
    let sum = |name: &str| table.column(name).unwrap().u64().unwrap().into_no_null_iter().sum::<u64>();
    assert!(sum("faults") <= preventable);
    assert_eq!(sum("failures"), failures as u64);
}
