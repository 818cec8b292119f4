//! Other worlds: the same episodes in a simulator of equal kinematics, and the faults of a bridge, none of which is a row like others.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Compiled, Evaluation, compile};
use episode::walker::Intercept;
use episode::{Draw, Ending, ObservationSpec, Observer, Outcome, Trace, carry_out, evaluate_observed};
use needs::needs;
use process::ProcessOpener;
use road::Town;
use world::av::{Exit, Fault};

use super::repository;

const EPISODES: u32 = 12;

fn text(fault: &str, settings: &str, policies: &str, worlds: &str) -> String {
    format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\nimport \"{0}/towns.scn\"\n\
         world other = bridge(command: \"python3 world.py {fault}\", {settings})\n\
         driver theirs = native(name: \"theirs\")\ndriver unknown = native(name: \"nobody\")\n\
         spawn driving {{ bearing: -45 deg .. 45 deg distance: 15 m .. 40 m }}\n\
         campaign worlds {{ vehicle: model3 body: suicidal spawn: driving episode: thirty_seconds\n\
         evaluate {{ towns: [harbour] drivers: [{policies}] pedestrians: [intercept] episodes: {EPISODES} worlds: [{worlds}] }} }}\n",
        repository().join("scenarios/lib").display()
    )
}

fn compiled(text: &str) -> Compiled {
    let root = repository().join("tests/external/test.scn");
    let read = |path: &Path| if path == root { Ok(text.to_owned()) } else { std::fs::read_to_string(path) };
    let write = |_: &Town| Ok("<OpenDRIVE/>".to_string());
    let catalog =
        Catalog::builtin().with_opener(Arc::new(ProcessOpener::default().asking())).with_map_writer(Arc::new(write));
    compile(std::slice::from_ref(&root), &catalog, &read, &mut Sources::default()).unwrap()
}

/// The evaluations of a text, in the order of its worlds.
fn evaluations(text: &str) -> Vec<Evaluation> {
    let compiled = compiled(text);
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].all::<Evaluation>().cloned().collect()
}

fn episodes(evaluation: &Evaluation, count: u32) -> Vec<(Outcome, Trace)> {
    let seed = Seed::root(5);
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
    let go_on = &mut |_| ControlFlow::Continue(());
    evaluate_observed(&mut Intercept, &evaluation.scenario, 0..count, &seed, &seed.child("walker"), note, go_on)
}

#[needs(python)]
#[test]
fn a_world_of_our_kinematics_has_our_episodes() {
    let both = evaluations(&text("none", "timeout: 60 s", "idm", "here, other"));
    let names: Vec<&str> = both.iter().map(|evaluation| &*evaluation.world).collect();
    assert_eq!(names, ["here", "other"]);
    let [here, other] = [0, 1].map(|place| episodes(&both[place], EPISODES));
    assert!(here.iter().any(|(outcome, _)| outcome.is_collision()));
    let bumps = episodes(&evaluations(&text("bumps", "timeout: 60 s", "idm", "other"))[0], EPISODES);
    let ends = |all: &[(Outcome, Trace)]| all.iter().map(|(outcome, _)| outcome.is_collision()).collect::<Vec<_>>();
    assert_eq!(ends(&bumps), ends(&here), "a touch may push the car");
    for ((ours, our_trace), (theirs, their_trace)) in here.iter().zip(&other) {
        assert_eq!(
            (ours.start, ours.spawn, ours.run_up, ours.ticks),
            (theirs.start, theirs.spawn, theirs.run_up, theirs.ticks)
        );
        assert_eq!(ours.is_collision(), theirs.is_collision(), "{ours:?} {theirs:?}");
        let apart = our_trace
            .vehicle(0)
            .iter()
            .zip(their_trace.vehicle(0))
            .map(|(ours, theirs)| (ours.state.pose.position() - theirs.state.pose.position()).norm());
        assert!(apart.fold(0.0, f64::max) < 1e-6);
    }
}

#[needs(python)]
#[test]
fn a_pedestrian_sees_the_same_road_in_another_world() {
    let seeing = text("none", "timeout: 60 s", "idm", "here, other").replace("suicidal", "seeing");
    let both = evaluations(&(seeing + "body seeing { road: true  observation_frame: line_of_sight }\n"));
    let [here, other] = [0, 1].map(|world: usize| {
        let mut simulation = both[world].scenario.simulation();
        let (mut states, mut state) = (Vec::new(), [0.0; ObservationSpec::DIM + ObservationSpec::ROAD_DIM]);
        for episode in 0..EPISODES {
            simulation.start(Draw::new(&Seed::root(5), episode.into()));
            let mut trace = Trace::new(&both[world].scenario);
            trace.begin(&simulation.scene());
            while simulation.outcome().is_none() {
                simulation.scene().write_state(&mut state);
                states.push(state);
                let commands = [simulation.scene().intercept(0)];
                carry_out(&mut *simulation, &commands, &mut trace);
            }
        }
        states
    });
    assert!(here.len() > 50 && here.len() == other.len(), "{} and {}", here.len(), other.len());
    for (here, other) in here.iter().zip(&other) {
        assert!(here.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-5), "{here:?} {other:?}");
    }
}

#[needs(python)]
#[test]
fn a_driver_of_another_world_drives_there_from_the_same_start() {
    let native = evaluations(&text("none", "timeout: 60 s", "theirs", "other"));
    for (outcome, trace) in episodes(&native[0], 4) {
        assert_eq!(outcome.fault(), None);
        let speeds: Vec<f64> = trace.vehicle(0).iter().map(|frame| frame.state.speed).collect();
        assert!(speeds[0] > 5.0, "our driver brings it to its speed");
        assert!(speeds.windows(2).all(|pair| (pair[1] - (pair[0] - 0.25).max(0.0)).abs() < 1e-9), "theirs brakes");
        assert!(trace.vehicle(0)[1].driven.control.brake > 0.0, "what it does is in the record");
    }
}

const NOT_FINITE: &str = "JSON has no NaN and no Infinity: give finite numbers (`json.dumps` of Python writes them)";

#[needs(python)]
#[test]
fn each_fault_of_a_world_is_an_error_of_its_own() {
    let answer = Fault::Answer;
    for (fault, found) in [
        ("hang", Fault::Late { limit_ms: 2000 }),
        ("late_start", Fault::LateStart { limit_ms: 4000 }),
        ("crash", Fault::Ended(Exit::Code(3))),
        ("nan", answer(NOT_FINITE)),
        ("infinite", answer(NOT_FINITE)),
        ("elsewhere", Fault::Moved { millimetres: 20 }),
        ("late", Fault::Delayed { ticks: 1 }),
        ("ends", Fault::EndedEarly),
        ("behind", answer("another tick than it was asked for")),
        ("nobody", answer("not one place for each pedestrian")),
        ("half", answer("an object with a key that is missing or there twice")),
        ("misplaced", Fault::Placed { millimetres: 500, degrees: 0, faster: 0 }),
        ("shifted", Fault::Lanes { millimetres: 300 }),
        ("few_lanes", answer("not one place for each place on the lanes")),
    ] {
        let evaluation = &evaluations(&text(fault, "timeout: 2 s, start_timeout: 4 s", "idm", "other"))[0];
        // After a crash it is started again.
        let count = if fault == "crash" { 2 } else { 1 };
        let ended = episodes(evaluation, count);
        assert_eq!(ended.len() as u32, count, "{fault}");
        for (outcome, _) in ended {
            assert_eq!(outcome.ending, Ending::WorldError(found), "{fault}");
            assert!(!outcome.counts() && outcome.error().unwrap().starts_with("the world "), "{fault}");
        }
    }
}

#[needs(python)]
#[test]
fn a_car_that_does_not_move_by_its_speed_its_heading_and_its_control_is_an_error_of_each_episode() {
    // Some show only where the car turns.
    let late = ["degrees", "stuck_yaw"];
    let early = ["kmh", "half_tick", "double_tick", "fast", "off", "lasting", "jumps", "tenth", "weak_brake"];
    for fault in early.into_iter().chain(late) {
        let ended = episodes(&evaluations(&text(fault, "timeout: 60 s", "idm", "other"))[0], 6);
        let moves = |fault| {
            let follows = matches!(fault, Fault::Brake { .. } | Fault::Pedals { .. } | Fault::Wheel { .. });
            follows || matches!(fault, Fault::Jumped { .. } | Fault::Way { .. } | Fault::Beside { .. })
        };
        let found = ended.iter().filter(|(outcome, _)| outcome.fault().is_some_and(moves)).count();
        assert!(ended.iter().all(|(outcome, _)| outcome.fault().is_none_or(moves)), "{fault}: {ended:?}");
        assert!(if late.contains(&fault) { found > 0 } else { found == 6 }, "{fault}: {found}");
    }
}

#[needs(python)]
#[test]
fn a_brake_that_is_mildly_wrong_or_late_is_an_error_of_each_episode_of_a_short_run() {
    for (fault, driver) in
        [("mild_brake", "idm"), ("mild_brake", "blind"), ("late_control", "idm"), ("late_pedals", "idm")]
    {
        let ended = episodes(&evaluations(&text(fault, "timeout: 60 s", driver, "other"))[0], 3);
        let is_brake = |(outcome, _): &(Outcome, Trace)| matches!(outcome.fault(), Some(Fault::Brake { .. }));
        assert!(ended.len() == 3 && ended.iter().all(is_brake), "{fault} {driver}: {ended:?}");
    }
}

#[needs(python)]
#[test]
fn a_world_may_say_how_late_its_pedals_are() {
    let declared = text("declared", "timeout: 60 s", "idm", "other");
    // A tenth of a second needs no word.
    for text in [&declared, &text("soon", "timeout: 60 s", "idm", "other")] {
        let ended = episodes(&evaluations(text)[0], EPISODES);
        assert!(ended.iter().all(|(outcome, _)| outcome.fault().is_none()), "{ended:?}");
    }
    let said: Vec<String> = compiled(&declared).diagnostics.iter().map(|each| each.message.clone()).collect();
    assert!(
        said.iter().any(|said| said == "the car of `other` follows its pedals up to 0.3 s late, as it states"),
        "{said:?}"
    );
    let said = format!("{:?}", compiled(&declared.replace("declared", "tardy")).diagnostics);
    assert!(said.contains("a `pedal_delay` that is not between 0 and 0.5"), "{said}");
}

#[needs(python)]
#[test]
fn a_world_has_a_name_of_one_line_that_is_not_ours_and_drivers_that_differ() {
    for (fault, message) in [
        ("here", "a `name` that is empty, longer than 60 bytes, with control characters, or `here`, our own simulator"),
        ("nameless", "a `name` that is empty"),
        ("two_lines", "a `name` that is empty"),
        ("long_name", "a `name` that is empty"),
        ("turned", "a `name` that is empty, longer than 60 bytes, with control characters"),
        ("turned_version", "a `version` that is empty, longer than 200 bytes, or with control characters"),
        ("long_version", "a `version` that is empty, longer than 200 bytes"),
        (
            "twins",
            "`drivers` of which one is there twice, empty, longer than 60 bytes or with control characters, or more than 100",
        ),
        ("no_word", "`drivers` of which one is there twice"),
    ] {
        let said = format!("{:?}", compiled(&text(fault, "", "idm", "other")).diagnostics);
        assert!(said.contains(message), "{fault}: {said}");
    }
}

#[needs(python)]
#[test]
fn a_bridge_of_the_python_package_has_a_short_name() {
    // It refuses this option; without the package Python ends.
    let named = text("", "", "idm", "other").replace("python3 world.py ", "esmini library=");
    let said = format!("{:?}", compiled(&named).diagnostics);
    assert!(said.contains("cannot use the command `esmini library=`: it ended before it answered"), "{said}");
}

#[needs(python)]
#[test]
fn a_world_may_say_how_exactly_it_places_pedestrians() {
    let tolerant = evaluations(&text("tolerant", "timeout: 60 s", "idm", "other"));
    assert!(episodes(&tolerant[0], 2).iter().all(|(outcome, _)| outcome.fault().is_none()));
}

#[needs(python)]
#[test]
fn what_a_world_cannot_do_is_said_before_a_run() {
    let said =
        |text: &str| -> Vec<String> { compiled(text).diagnostics.iter().map(|each| each.message.clone()).collect() };
    let has = |text: &str, message: &str| {
        let said = said(text);
        assert!(said.iter().any(|other| other == message), "{said:?} lacks {message}");
    };
    has(&text("none", "", "unknown", "other"), "`other` has no driver `nobody`");
    has(
        &text("none", "", "theirs", "here, other"),
        "`theirs` is a driver of another simulator, and these episodes happen in ours",
    );
    has(&text("rails", "", "idm", "other"), "`idm` cannot drive in `other`, whose cars only its own drivers drive");
    has(&text("unseeded", "", "theirs", "other"), "the seed of an episode does not reach `theirs`: `other` takes none");
    let lights = "`theirs` does not see the traffic lights of `village`: `other` does not show them";
    has(&text("none", "", "theirs", "other").replace("harbour", "village"), lights);
    let slippery = text("none", "", "idm", "other")
        .replace("thirty_seconds", "wet")
        .replace("campaign", "episode wet { friction: 0.4 }\ncampaign");
    has(&slippery, "the episode sets the `friction` of the road, and `other` has none");
    let elsewhere = text("none", "", "theirs", "other").replace("worlds: [other]", "");
    has(&elsewhere, "`theirs` is a driver of another simulator, and these episodes happen in ours");
}
