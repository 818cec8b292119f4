//! Estimates of how likely failures are, in towns and with drivers of the library.

use std::path::Path;
use std::slice::from_ref;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Campaign, Catalog, compile};
use episode::Criterion;
use results::campaign::{self, NoStore, Silent};
use search::likelihood::{Encounters, Estimate};
use verdict::Blame;

/// A campaign with this block.
fn campaign(block: &str) -> Campaign {
    let text = format!(
        "edition 1\nimport \"lib/drivers.scn\"\nimport \"lib/pedestrians.scn\"\nimport \"lib/sensors.scn\"\nimport \"lib/towns.scn\"\n\
         driver squinting = idm(time_headway: 1.5 s, sensors: poor)\n\
         spawn ahead_of_it {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}\n\
         episode brief {{ tick: 0.05 s  hold: 10  ticks: 240  end_when: ahead < -6 m }}\n\
         campaign c {{ vehicle: model3 body: pursuer spawn: ahead_of_it episode: brief\n{block} }}"
    );
    let root = crate::repository().join("scenarios/estimates.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable");
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

fn estimates(block: &str) -> Vec<Estimate> {
    let finished = campaign::run(&campaign(block), &Seed::root(5), &NoStore, &Silent);
    finished.found::<compile::Estimation>().map(|(_, found)| found.clone()).collect()
}

#[test]
fn what_has_a_default_may_be_left_out() {
    let plan = campaign("estimate { towns: [harbour]  drivers: [idm] }\ncover { towns: [harbour]  drivers: [idm] }");
    assert_eq!((plan.all::<compile::Estimation>().count(), plan.all::<compile::Cover>().count()), (1, 1));
}

#[test]
fn the_unbiased_probability_is_that_of_the_counted_encounters() {
    let block =
        "estimate { towns: [harbour]  drivers: [squinting]  event: failure  relative_error: 0.1  budget: 2_000_000 }";
    let found = estimates(block)[0].clone();
    let failure = found.of(Blame::Any);
    assert_eq!((failure.seen, found.short), (100, false));
    assert_eq!(failure.probability, 99.0 / (found.counted - 1) as f64);
    assert!(
        failure.low < failure.probability && failure.probability < failure.high && found.counted <= found.encounters
    );
    // Encounters do not depend on those before them.
    let plan = campaign(block);
    let estimation = plan.nth::<compile::Estimation>(0);
    let seed = estimation.drawn(&Seed::root(5));
    let new = || Encounters::new(&estimation.scenario, estimation.walker.walk_policy(), Criterion::Collision);
    let mut bed = new();
    let all: Vec<_> = (0..found.encounters).map(|number| bed.run(number, &seed.index(number))).collect();
    assert_eq!(all.iter().filter(|each| each.events[0]).count() as u64, 100);
    for number in [3, 17, 90] {
        assert_eq!(new().run(number, &seed.index(number)), all[number as usize]);
    }
}

#[test]
fn an_estimate_does_not_depend_on_threads() {
    let block = "estimate { towns: [harbour]  drivers: [idm]  event: failure  budget: 300_000 }";
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| estimates(block))
    };
    assert_eq!(of(1), of(3));
}
