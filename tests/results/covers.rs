//! Covers: how much of a box of starts can fail where the picture says that it passes.

use std::path::{Path, PathBuf};

use base::seed::Seed;
use compile::{Campaign, Catalog, Cover, compile};
use results::campaign::{NoStore, Silent, run};
use results::jobs::FoundInBox;

fn compiled(block: &str) -> Result<Campaign, String> {
    let text = format!(
        "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/ncap.scn\"\nimport \"std/towns.scn\"\n\
         spawn near {{ bearing: -60 deg .. 60 deg distance: 7 m .. 40 m }}\n\
         spawn far {{ bearing: 170 deg .. -170 deg distance: 60 m .. 70 m }}\n\
         spawn one {{ bearing: 10 deg distance: 20 m }}\n\
         spawn held = crossing_test(meeting: (0 m, -1.75 m, 0 deg), test_speeds: [30 km/h], overlaps: [50 percent], \
         approach: 75 percent .. 100 percent, headway: 8 s)\n\
         episode short {{ ticks: 300 hold: 10 }}\n\
         campaign c {{ vehicle: model3 body: layered_walker spawn: near episode: short\n{block} }}"
    );
    let root = crate::repository().join("scenarios/test_of_covers.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let files: [PathBuf; 1] = [root.clone()];
    let compiled = compile(&files, &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let messages: Vec<String> = compiled.diagnostics.iter().map(|each| format!("{each:?}")).collect();
    compiled.plan.map(|plan| plan.campaigns[0].clone()).ok_or_else(|| messages.join("\n"))
}

fn covers(block: &str, threads: usize) -> Vec<(Cover, FoundInBox)> {
    let campaign = compiled(block).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let finished = pool.install(|| run(&campaign, &Seed::root(1), &NoStore, &Silent));
    finished.found().map(|(job, found): (&Cover, &FoundInBox)| (job.clone(), found.clone())).collect()
}

#[test]
fn a_driver_that_sees_nobody_fails_all_over_the_layer_and_its_picture_says_so() {
    let block = "cover { towns: [test_track] drivers: [blind] spawn: held pedestrian: scripted failure: collision \
                 epsilon: 5 percent budget: 600 picture: [walking_speed, turn] }";
    let [(cover, found)] = &covers(block, 1)[..] else { panic!("one cover") };
    assert_eq!((cover.parameter_names(), &cover.picture), (vec!["approach", "walking_speed", "turn"], &vec![1, 2]));
    let coverage = &found.coverage;
    assert!(found.is_covered(cover) && found.errors == 0 && found.unplaced == 0, "{:?}", coverage.looks);
    assert_eq!(coverage.failures(), coverage.points.len() as u64, "without braking every point meets the car");
    assert_eq!((found.shown, found.unbraked_share()), (Some(1.0), 1.0));
}

#[test]
fn a_box_in_which_a_car_that_never_brakes_fails_nowhere_is_refused() {
    let block = |budget: u32| {
        format!(
            "cover {{ towns: [harbour] drivers: [idm] spawn: far pedestrian: intercept failure: collision epsilon: 10 percent budget: {budget} }}"
        )
    };
    assert!(covers(&block(300), 1).is_empty());
    let [(_, found)] = &covers(&block(20), 1)[..] else { panic!("too few starts to refuse it") };
    assert_eq!(found.unbraked, (0, 20));
}

#[test]
fn covers_are_equal_with_any_number_of_threads() {
    let block = "cover { towns: [harbour] drivers: [blind, idm] pedestrian: intercept failure: collision epsilon: 10 percent budget: 300 }";
    let (one, three) = (covers(block, 1), covers(block, 3));
    assert_eq!(one.len(), 2);
    assert!(one.iter().zip(&three).all(|(one, three)| one.1 == three.1));
    let [blind, idm] = &one[..] else { unreachable!() };
    assert!(blind.1.coverage.failures() > 5 * idm.1.coverage.failures(), "a driver that sees brakes");
    assert!(one.iter().all(|(_, found)| found.coverage.points.len() <= 300 && !found.coverage.looks.is_empty()));
}

#[test]
fn a_box_needs_ranges_and_a_picture_its_parameters() {
    let cover = |keys: &str| compiled(&format!("cover {{ towns: [harbour] drivers: [blind] {keys} }}")).unwrap_err();
    assert!(cover("spawn: one").contains("no box to cover"), "{}", cover("spawn: one"));
    assert!(cover("picture: [delay]").contains("bearing, distance"), "{}", cover("picture: [delay]"));
    let twice = cover("picture: [bearing, bearing]");
    assert!(twice.contains("bearing"), "{twice}");
    assert!(cover("pedestrian: scripted").contains("not a test"));
}
