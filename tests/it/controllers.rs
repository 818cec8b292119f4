//! Controllers of a user's own: programs and networks that walk, the errors they may make, and what such an error must not change.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Campaign, Catalog, Compiled, ControllerKind, compile};
use episode::walker::{ActionMode, Homing, TrainedWalker, WalkPolicy};
use episode::{Ending, Outcome, Scenario, evaluate};
use learn::ActorCritic;
use needs::needs;
use process::ProcessOpener;
use search::{BudgetedSimulation, TrainError};
use world::av::{Exit, Fault, Word};

use crate::beside_files::With;
use crate::program::{error, falsify, said};

const EPISODES: u32 = 12;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// A campaign of a controller `mine`. Its actions are measured from the line of sight, and it obeys at once.
fn text(controller: &str, policy: &str) -> String {
    format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         pedestrian mine = {controller}\n\
         method hunt = controlled(pedestrian: mine)\n\
         driver other = {policy}\n\
         episode brief {{ ticks: 120 }}\n\
         campaign outside {{ vehicle: model3 body: suicidal spawn: ahead episode: brief\n\
         evaluate {{ towns: [harbour] drivers: [other] pedestrians: [mine, homing] episodes: {EPISODES} }}\n\
         search {{ towns: [harbour] drivers: [other] methods: [hunt] budget: 4_000 runs: 1 episodes: 4 }} }}\n"
    )
}

const DRIVER: &str = "behavior_agent()";

fn compiled(controller: &str, policy: &str, allowed: bool) -> Compiled {
    let root = folder("tests/external/test.scn");
    let catalog = match allowed {
        true => Catalog::builtin().with_opener(Arc::new(ProcessOpener::default())),
        false => Catalog::builtin(),
    };
    compile(std::slice::from_ref(&root), &catalog, &With(text(controller, policy)), &mut Sources::default()).unwrap()
}

fn campaign(controller: &str, policy: &str) -> Campaign {
    let compiled = compiled(controller, policy, true);
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics)).campaigns.remove(0)
}

fn program(mode: &str, settings: &str) -> String {
    format!("external(command: \"python3 pedestrian.py {mode}\", {settings})")
}

fn outcomes(scenario: &Arc<Scenario>, walker: &mut dyn WalkPolicy) -> Vec<Outcome> {
    let seed = Seed::root(5);
    evaluate(walker, scenario, EPISODES, &seed, &seed.child("walker"), &mut |_| ControlFlow::Continue(()))
}

/// The outcomes of the controller `mine` of a campaign.
fn own(campaign: &Campaign) -> Vec<Outcome> {
    let evaluation = &campaign.nth::<compile::Evaluation>(0);
    let ControllerKind::Untrained(controller) = &evaluation.controller else { panic!("{:?}", evaluation.controller) };
    assert_eq!(controller.name(), "mine");
    outcomes(&evaluation.scenario, controller.walk_policy().as_mut())
}

/// An answer that begins so is no JSON.
fn not_json(text: &[u8]) -> Fault {
    Fault::NotJson { greeting: false, text: Word::new(text) }
}

#[needs(python)]
#[test]
fn a_program_walks_as_the_controller_that_it_repeats() {
    let campaign = campaign(&program("homing", "timeout: 60 s"), DRIVER);
    let outcomes_of = own(&campaign);
    assert!(outcomes_of.iter().any(Outcome::is_collision), "{outcomes_of:?}");
    assert_eq!(outcomes_of, outcomes(&campaign.nth::<compile::Evaluation>(0).scenario, &mut Homing));
}

#[needs(python)]
#[test]
fn a_fault_marks_its_own_episode_and_no_other() {
    let external = |worlds: u32| {
        format!("external(command: \"python3 ../../scenarios/external/my_av.py\", worlds: {worlds}, timeout: 60 s)")
    };
    let good = own(&campaign(&program("homing", "timeout: 60 s"), DRIVER));
    for (mode, timeout, fault) in [
        ("crash", "timeout: 60 s", Fault::Ended(Exit::Code(3))),
        ("garbage", "timeout: 60 s", not_json(b"now I walk left")),
        ("hang", "timeout: 2 s", Fault::Late { limit_ms: 2000 }),
    ] {
        let found = own(&campaign(&program(mode, timeout), DRIVER));
        let failed = found.iter().filter(|outcome| outcome.ending == Ending::ControllerError(fault)).count();
        assert!(failed > 0 && failed < found.len(), "{mode}: {found:?}");
        for (mine, good) in found.iter().zip(&good) {
            let same = mine.digest == good.digest && mine.ending == good.ending;
            assert!(same != (mine.fault() == Some(fault)), "{mode}: {mine:?} instead of {good:?}");
        }
    }
    // Drivers that drive several episodes at once change nothing.
    let alone = own(&campaign(&program("crash", "timeout: 60 s"), &external(1)));
    assert!(alone.iter().any(|outcome| outcome.fault().is_some()), "{alone:?}");
    assert_eq!(own(&campaign(&program("crash", "timeout: 60 s"), &external(5))), alone);
}

#[needs(python)]
#[test]
fn a_program_that_never_walks_is_given_up_after_ten_episodes() {
    for (mode, fault) in [
        ("version", Fault::Greeting("another protocol than falsify-pedestrian/1")),
        ("gone", Fault::Ended(Exit::Code(0))),
        ("short", Fault::Answer("not two numbers for each pedestrian")),
        ("eager", Fault::Answer("it came before the question")),
        (
            "wordy",
            Fault::WrongType {
                greeting: false,
                key: "action",
                found: "a list with other values than numbers",
                wanted: "a list of numbers",
            },
        ),
    ] {
        let campaign = campaign(&program(mode, "timeout: 60 s"), DRIVER);
        let faults: Vec<_> = own(&campaign).iter().map(Outcome::fault).collect();
        assert_eq!(faults, [Some(fault); 10], "{mode}");
        let search = &campaign.nth::<compile::Search>(0);
        let mut simulator = BudgetedSimulation::new(search.scenario.clone(), Seed::root(1), search.budget, &|| false);
        let ended = search.falsifier.search(&mut simulator, &Seed::root(2)).map(|_| ());
        assert_eq!(ended, Err(TrainError::Controller { fault }), "{mode}");
    }
}

#[test]
fn a_network_walks_as_the_policy_that_it_was_written_from() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("net.onnx");
    let bounds = [(-std::f64::consts::PI, std::f64::consts::PI), (0.0, 3.5)];
    let policy = ActorCritic::new(4, 2, &[8], 0.0, &mut Seed::root(9).stream());
    std::fs::write(&file, policy.to_onnx(&bounds, &Default::default())).unwrap();
    let campaign = campaign(&format!("onnx(model: \"{}\")", file.display()), DRIVER);
    let scenario = &campaign.nth::<compile::Evaluation>(0).scenario;
    let mut written = TrainedWalker::new(vec![policy], &scenario.cast, ActionMode::Deterministic);
    for (network, policy) in own(&campaign).iter().zip(&outcomes(scenario, &mut written)) {
        let same = std::mem::discriminant(&network.ending) == std::mem::discriminant(&policy.ending);
        assert!(same && (network.least_gap - policy.least_gap).abs() < 1e-3, "{network:?} instead of {policy:?}");
    }
}

#[test]
fn what_cannot_walk_is_an_error_with_the_remedy() {
    let place = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        std::fs::write(place.path().join(name), bytes).unwrap();
        format!("onnx(model: \"{}\")", place.path().join(name).display())
    };
    let net = |inputs: usize, outputs: usize| {
        let policy = ActorCritic::new(inputs, outputs, &[3], 0.0, &mut Seed::root(9).stream());
        policy.to_onnx(&vec![(-1.0, 1.0); outputs], &Default::default())
    };
    let driver = std::fs::read(folder("tests/reference/onnx/follow.onnx"));
    for (controller, code, text) in [
        (program("homing", ""), "external-not-allowed", "wants to start the program"),
        (file("five.onnx", &net(5, 2)), "unusable-model", "its input has 5 numbers"),
        (file("three.onnx", &net(4, 3)), "unusable-model", "its output has 3 numbers instead of 2"),
        (file("text.onnx", b"no network"), "unusable-model", "cannot use the model"),
    ] {
        let found = compiled(&controller, DRIVER, false).diagnostics;
        assert!(found.iter().any(|each| each.code == code && each.message.contains(text)), "{controller}: {found:?}");
    }
    if let Ok(bytes) = driver {
        let found = compiled(&file("driver.onnx", &bytes), DRIVER, false).diagnostics;
        assert!(found.iter().any(|each| each.code == "unusable-model"), "{found:?}");
    }
    let check = |old: &str, new: &str| {
        let scenario = text(&file("good.onnx", &net(4, 2)), DRIVER).replace(old, new);
        std::fs::write(place.path().join("a.scn"), scenario).unwrap();
        error(&falsify(&["check", "a.scn"], place.path()))
    };
    let inline = check("[mine, homing]", "[external(\"python3 a.py\")]");
    assert!(inline.contains("declare it: `pedestrian mine = external(\"python3 a.py\")`"), "{inline}");
    let typo = check("[mine, homing]", "[mime]");
    assert!(typo.contains("`mime`") && typo.contains("`mine`"), "{typo}");
    let taken = check("mine", "random");
    assert!(taken.contains("`random` is the name of a built-in `pedestrian`"), "{taken}");
}

#[needs(python)]
#[test]
fn reports_replays_and_gates_treat_a_program_as_any_controller() {
    let place = tempfile::tempdir().unwrap();
    let command = format!(
        "external(command: \"python3 {} homing\", timeout: 60 s)",
        folder("tests/external/pedestrian.py").display()
    );
    std::fs::write(place.path().join("a.scn"), text(&command, DRIVER)).unwrap();
    let refused = falsify(&["run", "a.scn"], place.path());
    assert_eq!(refused.status.code(), Some(3), "{}", error(&refused));
    let run =
        ["run", "--allow-external", "--fail-if", "collision_rate > 0 and pedestrian == mine", "--out", "out", "a.scn"];
    let output = falsify(&run, place.path());
    assert_eq!(output.status.code(), Some(7), "{}{}", said(&output), error(&output));
    let episodes = std::fs::read_to_string(place.path().join("out/outside/episodes.csv")).unwrap();
    let names: Vec<&str> = episodes.lines().next().unwrap().split(',').collect();
    let place_of = |name: &str| names.iter().position(|each| *each == name).unwrap();
    let rows: Vec<Vec<&str>> = episodes.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let digests = |controller: &str| -> Vec<&str> {
        rows.iter().filter(|row| row[place_of("pedestrian")] == controller).map(|row| row[place_of("digest")]).collect()
    };
    assert_eq!(digests("mine").len(), EPISODES as usize);
    assert_eq!(digests("mine"), digests("homing"));
    let name = format!("{}:3", rows[0][place_of("run_id")]);
    let replay = falsify(&["replay", "--allow-external", "--report", "out", &name], place.path());
    assert!(replay.status.success(), "{}{}", said(&replay), error(&replay));
}
