//! Estimates of how likely failures are, in towns and with drivers of the library.

use std::path::Path;
use std::slice::from_ref;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Campaign, Catalog, compile};
use results::campaign::{self, EstimateResult, InMemory, Silent};
use world::likelihood::{Encounters, Event, Likelihood, Lot, Question, TestBed};

/// A campaign with this block.
fn campaign(block: &str) -> Campaign {
    let text = format!(
        "edition 1\nimport \"lib/drivers.scn\"\nimport \"lib/estimators.scn\"\nimport \"lib/pedestrians.scn\"\nimport \"lib/sensors.scn\"\nimport \"lib/towns.scn\"\n\
         policy squinting = idm(time_headway: 1.5 s, sensors: poor)\n\
         spawn ahead_of_it {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}\n\
         episode brief {{ tick: 0.05 s  hold: 10  ticks: 240  end_when: ahead < -6 m }}\n\
         campaign c {{ vehicle: model3 adversary: pursuer spawn: ahead_of_it episode: brief\n{block} }}"
    );
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/estimates.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable");
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

fn estimates(block: &str) -> Vec<EstimateResult> {
    campaign::run(&campaign(block), &Seed::root(5), &InMemory::default(), &Silent).estimates
}

#[test]
fn what_has_a_default_may_be_left_out() {
    let plan = campaign(
        "estimate { towns: [harbour]  policies: [idm]  estimators: [monte_carlo] }\ncover { towns: [harbour]  policies: [idm] }",
    );
    assert_eq!((plan.estimations.len(), plan.covers.len()), (1, 1));
}

#[test]
fn methods_agree_with_plain_encounters() {
    let all = estimates(
        "estimate { towns: [harbour]  policies: [squinting]  estimators: [monte_carlo]  event: failure  relative_error: 0.05  budget: 2_000_000 }\n\
         estimate { towns: [harbour]  policies: [squinting]  estimators: [splitting]  event: failure  relative_error: 0.1  budget: 2_000_000 }",
    );
    let of = |place: usize| -> &Likelihood { all[place].estimate.as_ref().unwrap().of(Event::Failure) };
    let (plain, split) = (of(0), of(1));
    assert!(plain.seen >= 200 && split.seen >= 4, "{plain:?} {split:?}");
    // The difference of two independent estimates, in their standard errors.
    let error = plain.relative_error.unwrap() * plain.probability;
    let other = split.relative_error.unwrap() * split.probability;
    let z = (plain.probability - split.probability) / (error * error + other * other).sqrt();
    assert!(z.abs() < 3.0, "{plain:?} and {split:?}, {z} deviations");
}

#[test]
fn a_branch_repeats_the_encounter_up_to_its_decision_and_the_whole_lot_repeats_the_branch() {
    let plan = campaign("estimate { towns: [harbour]  policies: [squinting]  estimators: [monte_carlo] }");
    let estimation = &plan.estimations[0];
    let new = || Encounters::new(&estimation.scenario, estimation.walker.walk_policy(), Question::Collision);
    let mut differ = 0;
    for number in 0..20 {
        let (mut bed, mut lot) = (new(), Lot::new(number, &Seed::root(9).index(number)));
        bed.begin(&mut lot);
        let mut levels = vec![bed.level()];
        let mut mark = None;
        while bed.step(&mut lot) {
            levels.push(bed.level());
            if levels.len() == 4 {
                mark = bed.mark();
            }
        }
        let whole = bed.trial();
        let Some(mark) = mark else { continue };
        // The rest is drawn anew from the state in the middle.
        let mut branch = lot.redrawn(3, &Seed::root(10).index(number));
        bed.restore(&mark, &mut branch);
        let mut branched = vec![bed.level()];
        while bed.step(&mut branch) {
            branched.push(bed.level());
        }
        let end = bed.trial();
        assert_eq!(branched[0].to_bits(), levels[3].to_bits());
        differ += u32::from(end != whole);
        // The same lot from its start, in another bed, is the same encounter.
        let mut other = new();
        other.begin(&mut branch);
        let mut again = vec![other.level()];
        while other.step(&mut branch) {
            again.push(other.level());
        }
        assert_eq!(again[3..], branched[..]);
        assert_eq!(other.trial(), end);
    }
    assert!(differ > 5, "only {differ} branches came to another end");
}

#[test]
fn an_estimate_does_not_depend_on_threads() {
    let block = "estimate { towns: [harbour]  policies: [idm]  estimators: [monte_carlo, splitting]  event: failure  budget: 300_000 }";
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = pool.install(|| estimates(block));
        all.into_iter().map(|each| each.estimate).collect::<Vec<_>>()
    };
    assert_eq!(of(1), of(3));
}
