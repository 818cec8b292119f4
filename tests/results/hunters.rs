//! The trained pedestrians that come with the program.

use std::ops::ControlFlow;
use std::path::Path;

use base::seed::Seed;
use compile::{Campaign, Catalog, Evaluation, compile};
use results::jobs::watch;
use verdict::judge;

fn campaign(adversary: &str, pedestrians: &str) -> Campaign {
    let text = format!(
        "edition 1
         import \"std/paper.scn\"
         import \"std/pedestrians.scn\"
         import \"std/drivers.scn\"
         import \"std/towns.scn\"
         spawn ahead_of_a_moving_car {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}
         episode until_passed {{ tick: 0.05 s  hold: 10  ticks: 240  end_when: ahead < -6 m }}
         campaign hunt {{
           vehicle: model3  body: {adversary}  spawn: ahead_of_a_moving_car  episode: until_passed
           evaluate {{ towns: [village] drivers: [behavior] pedestrians: [{pedestrians}] episodes: 400 }}
         }}"
    );
    let root = crate::repository().join("hunt.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

/// The numbers of faults of the driver and of episodes in error, for each pedestrian in turn.
fn met(campaign: &Campaign, episodes: u32) -> Vec<(usize, usize)> {
    let count = |evaluation: &Evaluation| {
        let ends = watch(
            evaluation,
            None,
            0..episodes,
            &Seed::root(1),
            &mut |outcome, trace| {
                let verdict = judge(&trace.main_pair(&evaluation.scenario));
                (verdict.is_some_and(|verdict| verdict.is_fault()), outcome.fault().is_some())
            },
            &mut |_| ControlFlow::Continue(()),
        );
        (ends.iter().filter(|end| end.0).count(), ends.iter().filter(|end| end.1).count())
    };
    campaign.all::<Evaluation>().map(count).collect()
}

#[test]
fn hunters_find_twice_the_faults_of_an_interception_without_a_training() {
    for (adversary, hunter) in [("pursuer", "hunter"), ("child_pursuer", "hunter_child")] {
        let [(hunted, 0), (met, 0)] = *met(&campaign(adversary, &format!("{hunter}, intercept")), 400) else {
            panic!("two pedestrians without errors")
        };
        assert!(hunted >= 2 * met && hunted >= 20, "{hunter}: {hunted} faults beside {met}");
    }
}

#[test]
#[should_panic(expected = "unfit-pedestrian")]
fn a_hunter_with_the_commands_of_another_adversary_is_an_error() {
    campaign("plausible", "hunter");
}

#[test]
#[should_panic(expected = "unfit-pedestrian")]
fn a_hunter_that_sees_no_road_is_an_error_though_its_input_is_as_long_as_a_state_with_the_road() {
    campaign("pursuer", "hunter_child");
}
