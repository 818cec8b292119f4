//! External drivers: which errors they may make, and which results such an error must not have.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use base::signature::Keys;
use compile::{Catalog, Plan, compile};
use episode::walker::{Intercept, Random};
use episode::{Ending, Outcome, Scenario, Trace, evaluate, evaluate_observed};
use needs::needs;
use process::ProcessOpener;
use search::{TrainError, TrainingRun};
use world::av::{BrakeKeys, DrivingMode, Exit, Fault, Word};

use crate::program::falsify;

const EPISODES: u32 = 12;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// A campaign against an external driver.
fn text(command: &str, settings: &str) -> String {
    format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\nimport \"{0}/towns.scn\"\n\
         driver mine = external(command: \"{command}\", {settings})\n\
         training short = ppo(steps: 300)\n\
         episode brief {{ ticks: 80 }}\n\
         campaign outside {{ vehicle: model3 body: suicidal spawn: ahead episode: brief training: short\n\
         train {{ towns: [harbour] drivers: [blind] rewards: [r1] runs: 1 }}\n\
         evaluate {{ towns: [harbour] drivers: [mine] pedestrians: [random] episodes: {EPISODES} }} }}\n",
        folder("scenarios/lib").display()
    )
}

fn plan(command: &str, settings: &str) -> Plan {
    plan_of(text(command, settings))
}

fn plan_of(scenario: String) -> Plan {
    let root = folder("tests/external/test.scn");
    let read = |path: &Path| if path == root { Ok(scenario.clone()) } else { std::fs::read_to_string(path) };
    let catalog = Catalog::builtin().with_opener(Arc::new(ProcessOpener::default()));
    let compiled = compile(std::slice::from_ref(&root), &catalog, &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

fn scenario(command: &str, settings: &str) -> Arc<Scenario> {
    plan(command, settings).campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

/// The outcomes of the episodes against a driver of `tests/external/driver.py`.
fn outcomes(mode: &str, settings: &str) -> Vec<Outcome> {
    let scenario = scenario(&format!("python3 driver.py {mode}"), settings);
    let seed = Seed::root(5);
    evaluate(&mut Random::default(), &scenario, EPISODES, &seed, &seed.child("walker"), &mut |_| {
        ControlFlow::Continue(())
    })
}

/// An answer that begins so is no JSON.
fn not_json(text: &[u8]) -> Fault {
    Fault::NotJson { greeting: false, text: Word::new(text) }
}

#[needs(python)]
#[test]
fn encodings_company_and_the_size_of_writes_change_no_outcome() {
    let alone = outcomes("good", "worlds: 1, timeout: 60 s");
    assert_eq!(alone.len(), EPISODES as usize);
    assert!(alone.iter().all(|outcome| outcome.fault().is_none()), "{alone:?}");
    assert!(alone.iter().any(|outcome| outcome.last_mode.name() == "cruise"), "the driver tells what it does");
    let mode_free = |outcomes: Vec<Outcome>| -> Vec<u64> { outcomes.iter().map(|outcome| outcome.digest).collect() };
    let digests = mode_free(alone.clone());
    assert_eq!(outcomes("good", "worlds: 5, timeout: 60 s"), alone);
    assert_eq!(outcomes("bytewise", "worlds: 32, timeout: 60 s"), alone);
    assert_eq!(outcomes("reversed", "worlds: 3, timeout: 60 s"), alone, "answers may come in any order");
    assert_eq!(mode_free(outcomes("good binary", "worlds: 1, timeout: 60 s")), digests);
    assert_eq!(mode_free(outcomes("bytewise binary", "worlds: 7, timeout: 60 s")), digests);
    assert_eq!(mode_free(outcomes("good binary second", "worlds: 7, timeout: 60 s")), digests, "with lanes");
}

#[needs(python)]
#[test]
fn the_emergency_brake_of_a_program_is_that_of_the_kind() {
    let text = text("python3 driver.py good", "aeb: true").replace("drivers: [mine]", "drivers: [mine, aeb]");
    let plan = plan_of(text);
    let settings = |name: &str| &plan.campaigns[0].drivers.iter().find(|driver| driver.name == name).unwrap().settings;
    assert!(settings("mine").read::<bool>("aeb"), "reports name it");
    assert_eq!(BrakeKeys::read(settings("aeb")), BrakeKeys::default());
}

#[needs(python)]
#[test]
fn an_emergency_brake_in_front_of_a_program_spares_people_and_moves_nothing_else() {
    let hits = |outcomes: &[Outcome]| {
        outcomes.iter().filter(|outcome| matches!(outcome.ending, Ending::Touch { moving: true, .. })).count()
    };
    let run = |settings: &str, worlds: u32| {
        let command = "python3 follower.py";
        let scenario = scenario(command, &format!("worlds: {worlds}, timeout: 60 s{settings}"));
        let seed = Seed::root(5);
        evaluate(&mut Intercept, &scenario, 30, &seed, &seed.child("walker"), &mut |_| ControlFlow::Continue(()))
    };
    let (bare, guarded) = (run("", 4), run(", aeb: true", 4));
    assert_eq!(run(", aeb: false", 4), bare);
    assert_eq!(run(", aeb: true", 1), guarded, "each world has a brake of its own");
    assert!(hits(&bare) >= 5, "the program sees no one: {bare:?}");
    assert!(2 * hits(&guarded) < hits(&bare), "{} of {}", hits(&guarded), hits(&bare));
    let stopped = guarded.iter().any(|outcome| outcome.last_mode == DrivingMode::EmergencyStop);
    assert!(stopped, "the tables name its manoeuvre: {guarded:?}");
    let same = bare.iter().zip(&guarded).filter(|(bare, guarded)| bare.digest == guarded.digest).count();
    assert!(same > 0, "it changes nothing where no pedestrian comes near: {guarded:?}");
}

fn wrong_type(key: &'static str, found: &'static str) -> Fault {
    Fault::WrongType { greeting: false, key, found, wanted: "a number" }
}

#[needs(python)]
#[test]
fn a_fault_marks_its_own_episode_and_no_other() {
    let good = outcomes("good", "worlds: 1, timeout: 60 s");
    let cases = [
        ("crash", "timeout: 60 s", Fault::Ended(Exit::Code(3))),
        ("crash binary", "timeout: 60 s", Fault::Ended(Exit::Code(3))),
        ("half", "timeout: 60 s", Fault::Ended(Exit::Code(0))),
        ("killed", "timeout: 60 s", Fault::Ended(Exit::Signal("SIGSEGV"))),
        ("null", "timeout: 60 s", wrong_type("brake", "null")),
        ("text", "timeout: 60 s", wrong_type("throttle", "a text")),
        ("garbage", "timeout: 60 s", not_json(b"now I turn left")),
        ("endless", "timeout: 60 s", Fault::Answer("a line that does not end")),
        ("hang", "timeout: 2 s", Fault::Late { limit_ms: 2000 }),
    ];
    for (mode, timeout, fault) in cases {
        let alone = outcomes(mode, &format!("worlds: 1, {timeout}"));
        let failed = alone.iter().filter(|outcome| outcome.fault() == Some(fault)).count();
        assert!(failed > 0 && failed < alone.len() / 2, "{mode}: {alone:?}");
        for (mine, good) in alone.iter().zip(&good) {
            let same = mine.digest == good.digest && mine.ending == good.ending;
            assert!(same != (mine.fault() == Some(fault)), "{mode}: {mine:?} instead of {good:?}");
            assert!(mine.fault().is_none() || (mine.ticks == 30 && mine.reward == 0.0), "{mine:?}");
        }
        assert_eq!(outcomes(mode, &format!("worlds: 6, {timeout}")), alone, "{mode}: with six worlds at once");
    }
}

#[needs(python)]
#[test]
fn a_driver_that_never_drives_is_given_up_after_ten_episodes() {
    let cases = [
        ("version", Fault::Greeting("another protocol than falsify-av/1")),
        ("gone", Fault::Ended(Exit::Code(0))),
        ("lazy", Fault::Answer("not one action for each world")),
        (
            "nan",
            Fault::Answer("JSON has no NaN and no Infinity: give finite numbers (`json.dumps` of Python writes them)"),
        ),
        ("eager", Fault::Answer("it came before the question")),
    ];
    for (mode, fault) in cases {
        for worlds in [1, 4] {
            let outcomes = outcomes(mode, &format!("worlds: {worlds}, timeout: 60 s"));
            let faults: Vec<_> = outcomes.iter().map(Outcome::fault).collect();
            assert_eq!(faults, [Some(fault); 10], "{mode}");
        }
    }
    let silent = outcomes("silent", "start_timeout: 200 ms");
    assert_eq!(silent[0].fault(), Some(Fault::LateStart { limit_ms: 200 }));
    // The file exists, so it passes the check, but it cannot be run.
    let nobody = scenario("./driver.py --fast", "worlds: 2");
    let seed = Seed::root(5);
    let tried = evaluate(&mut Random::default(), &nobody, EPISODES, &seed, &seed, &mut |_| ControlFlow::Continue(()));
    assert_eq!(tried.iter().map(Outcome::fault).collect::<Vec<_>>(), [Some(Fault::NotStarted); 10]);
}

#[needs(python)]
#[test]
fn a_training_survives_some_faults_and_ends_with_the_cause_of_too_many() {
    let training = |mode: &str| {
        let plan = plan(&format!("python3 driver.py {mode}"), "timeout: 60 s");
        let mut config = plan.campaigns[0].nth::<compile::Training>(0).config.clone();
        config.steps = 150;
        let against = &plan.campaigns[0].nth::<compile::Evaluation>(0).scenario;
        TrainingRun::begin(std::slice::from_ref(against), 1, &config, &Seed::root(1))
            .and_then(|run| run.carry_on(&mut |_| ControlFlow::Continue(())))
    };
    assert!(training("crash").is_ok());
    assert_eq!(training("gone").err(), Some(TrainError::Driver { update: 1, fault: Fault::Ended(Exit::Code(0)) }));
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[needs(python)]
#[test]
fn nothing_is_started_unless_the_user_allows_it() {
    let place = tempfile::tempdir().unwrap();
    let mark = place.path().join("mark");
    let driver = folder("tests/external/driver.py");
    let command = format!("python3 {} good {}", driver.display(), mark.display());
    std::fs::write(place.path().join("evil.scn"), text(&command, "worlds: 4")).unwrap();
    for arguments in [&["run", "evil.scn"][..], &["check", "evil.scn"], &["run", "--list", "evil.scn"]] {
        let output = falsify(arguments, place.path());
        let (code, kind) = if arguments[0] == "check" { (0, "warning") } else { (3, "error") };
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        assert!(said(&output).contains(&format!("{kind}[external-not-allowed]")), "{}", said(&output));
    }
    for arguments in [&["check", "--allow-external", "evil.scn"][..], &["preview", "--once", "evil.scn"]] {
        falsify(arguments, place.path());
    }
    assert!(!mark.exists(), "checking and drawing start nothing");
    let output = falsify(&["run", "--smoke", "--allow-external", "evil.scn"], place.path());
    assert!(output.status.success() && mark.exists(), "{}", said(&output));
}

#[needs(python)]
#[test]
fn episodes_in_error_are_counted_apart_and_the_bytes_are_the_same_on_one_thread_and_two() {
    let place = tempfile::tempdir().unwrap();
    let command = format!("python3 {} crash", folder("tests/external/driver.py").display());
    std::fs::write(place.path().join("crash.scn"), text(&command, "timeout: 60 s")).unwrap();
    let run = |threads: &str| {
        let output =
            falsify(&["run", "--allow-external", "--threads", threads, "--out", threads, "crash.scn"], place.path());
        assert_eq!(output.status.code(), Some(5), "{}", said(&output));
        assert!(said(&output).contains("mine ended before it answered"), "{}", said(&output));
        let report =
            |file: &str| std::fs::read_to_string(place.path().join(threads).join("outside").join(file)).unwrap();
        (report("episodes.csv"), report("metrics.csv"), report("summary.md"))
    };
    let (episodes, metrics, summary) = run("1");
    assert_eq!(run("2"), (episodes.clone(), metrics.clone(), summary.clone()));
    let errors = episodes.matches("error,ended before it answered with exit code 3").count();
    assert!(errors > 0, "{episodes}");
    let names: Vec<&str> = metrics.lines().next().unwrap().split(',').collect();
    let at = |column: &str| names.iter().position(|name| *name == column).unwrap();
    let rows: Vec<Vec<&str>> = metrics.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let value = |metric: &str| {
        let row = rows.iter().find(|row| row[at("metric")] == metric).unwrap();
        row[at("value")].parse::<f64>().unwrap() as usize
    };
    assert_eq!((value("errors"), value("episodes")), (errors, EPISODES as usize - errors));
    assert!(summary.contains(&format!("In {errors} more episodes the driver or the pedestrian failed")), "{summary}");
}

#[needs(python)]
#[test]
fn a_driver_that_ends_only_while_several_episodes_run_is_named() {
    let place = tempfile::tempdir().unwrap();
    let command = format!("python3 {} crowded", folder("tests/external/driver.py").display());
    std::fs::write(place.path().join("crowded.scn"), text(&command, "timeout: 60 s")).unwrap();
    let output = falsify(&["run", "--allow-external", "--threads", "1", "crowded.scn"], place.path());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(
        said(&output).contains("programs crashed or timed out once and were started again; no episode was lost"),
        "{}",
        said(&output)
    );
}

#[needs(python)]
#[test]
fn av_check_tells_good_drivers_from_bad_ones() {
    let check = |arguments: &[&str]| {
        let command = [&["check", "--timeout", "60", "--show", "--", "python3"], arguments].concat();
        let output = falsify(&command, &folder("tests/external"));
        (output.status.code(), said(&output))
    };
    // The driver of the tests speaks the protocol well and does not follow its route.
    let lost = [
        "FAIL  stays on an empty road with a bend and a turn: the car left the road with a part of its body ",
        "FAIL  follows its lane there to the end: the car left its lane ",
    ];
    for (good, code, failures) in [(&["driver.py", "good"][..], 5, 2), (&["../../scenarios/external/my_av.py"], 0, 0)] {
        let (found, text) = check(good);
        assert_eq!(found, Some(code), "{text}");
        assert_eq!(text.matches("  ok    ").count(), 5 - failures, "{text}");
        assert_eq!(lost.map(|said| text.matches(said).count()).into_iter().sum::<usize>(), failures, "{text}");
        assert_eq!(text.matches("FAIL").count(), failures, "{text}");
        assert!(text.contains("-> {\"type\":\"hello\",\"protocol\":\"falsify-av/1\",\"tick_s\":0.05"), "{text}");
        assert!(code != 0 || text.contains(" ticks a CPU second alone, "), "{text}");
    }
    let (_, text) = check(&["driver.py", "misspelt"]);
    let said = "its greeting has a key `revison`, which is unknown and ignored; did you mean `revision`?";
    assert_eq!(text.matches(said).count(), 1, "{text}");
    for (mode, what) in [
        ("version", "it greeted wrongly: another protocol"),
        ("crash", "it ended before it answered with exit code 3"),
        ("null", "it gave a wrong answer: `brake` is null; give a number"),
        ("huge", "it gave a wrong answer: `brake` is 1e999, and the largest number is about 1.8e308"),
        ("marked", "it greeted wrongly: it begins with a byte order mark: write UTF-8 without one"),
        ("lazy", "it gave a wrong answer: not one action"),
        ("random", "when the same seeds come again"),
        ("counting", "when it is asked about 8 worlds at once"),
    ] {
        let (code, text) = check(&["driver.py", mode]);
        assert_eq!(code, Some(5), "{mode}: {text}");
        assert!(text.lines().any(|line| line.contains("FAIL") && line.contains(what)), "{mode}: {text}");
    }
}

/// Gives the same throttle and steer always.
const CONSTANT: &str = r#"
import json, sys
for line in map(json.loads, sys.stdin):
    action = {"throttle": float(sys.argv[1]), "steer": float(sys.argv[2])}
    actions = line["type"] == "step" and [{"id": world["id"], **action} for world in line["worlds"]]
    print(json.dumps({"actions": actions} if actions else {"protocol": "falsify-av/1"}), flush=True)
"#;

#[needs(python)]
#[test]
fn an_empty_road_tells_drivers_that_follow_it_from_others() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("constant.py"), CONSTANT).unwrap();
    let found = |throttle: &str, steer: &str| {
        let words = ["check", "--timeout", "60", "--", "python3", "constant.py", throttle, steer];
        let output = falsify(&words, place.path());
        assert_eq!(output.status.code(), Some(5), "{}", said(&output));
        let text = said(&output);
        let [road, lane] =
            ["stays on an empty road with a bend and a turn", "follows its lane there to the end"].map(|what| {
                let line = text.lines().find_map(|line| line.split_once(what)).unwrap_or_else(|| panic!("{text}"));
                line.1.trim_start_matches(": ").to_owned()
            });
        [road, lane]
    };
    let metres = |found: &str| {
        found
            .split_once("after ")
            .unwrap()
            .1
            .split_once("after ")
            .unwrap()
            .1
            .split(' ')
            .next()
            .unwrap()
            .parse::<f64>()
            .unwrap()
    };
    let circles = found("0.3", "0.3");
    for (found, left) in circles.iter().zip(["the road with a part of its body ", "its lane "]) {
        assert!(found.starts_with(&format!("the car left {left}")), "{found}");
        assert!(found.ends_with("m/s: the driver steers constantly 0.30 to the left"), "{found}");
    }
    let straight = found("0.3", "0");
    assert!(straight.iter().all(|found| found.ends_with("the driver does not steer")), "{straight:?}");
    // The bend begins 47.6 m after the start. Its front corner, 2.4 m ahead and 2.83 m beside the middle line, is 33.6 m from the centre of the bend after
    // 52.4 m; its centre, 1.75 m beside that line, is 34.6 m from it, 1 m beyond its lane, after 61.3 m.
    let [road, lane] = straight.map(|found| metres(&found));
    assert!((road - 52.4).abs() < 1.0 && (lane - 61.3).abs() < 1.0, "{road} and {lane}");
    assert_eq!(found("0", "0"), ["", "the car stood for 120 s"]);
}

/// Turns the front wheels by 0.05 rad at all speeds, in the form that its argument names.
const TURNED: &str = r#"
import json, struct, sys
binary = sys.argv[1] == "binary"
source, out = sys.stdin.buffer, sys.stdout.buffer
hello = json.loads(source.readline())
form = {"encoding": "binary", "control": "acceleration", "wheel_angle": True} if binary else {}
out.write(json.dumps({"protocol": "falsify-av/1", **form}).encode() + b"\n")
out.flush()
width = 14 + 8 * hello["actors"] + 3 * hello["route_points"]
while head := source.read(4) if binary else source.readline():
    if binary:
        worlds = struct.iter_unpack(f"<{width}d", source.read(struct.unpack("<I", head)[0]))
        answer = b"".join(struct.pack("<4d", world[0], 2.0, 0.0, 0.05) for world in worlds)
        out.write(struct.pack("<I", len(answer)) + answer)
    else:
        actions = [{"id": world["id"], "acceleration": 2, "wheel_angle": 0.05} for world in json.loads(head)["worlds"]]
        out.write(json.dumps({"actions": actions}).encode() + b"\n")
    out.flush()
"#;

#[needs(python)]
#[test]
fn a_wheel_angle_is_that_of_the_front_wheels_at_every_speed() {
    let place = tempfile::tempdir().unwrap();
    let program = place.path().join("turned.py");
    std::fs::write(&program, TURNED).unwrap();
    // The law of `scenarios/external/README.md`.
    let slip = libm::atan(libm::tan(0.05) / 2.0);
    for form in ["json", "binary"] {
        let scenario = scenario(&format!("python3 {} {form}", program.display()), "timeout: 60 s");
        let base = scenario.cast.ego().blueprint.wheelbase;
        let mut fastest = 0.0_f64;
        let mut note = |_: u32, outcome: &Outcome, trace: &Trace| {
            assert_eq!(outcome.fault(), None);
            for pair in trace.vehicle(0).windows(2) {
                let [before, after] = [pair[0].state, pair[1].state];
                let way = (before.speed + after.speed) / 2.0 * 0.05;
                let turned = road::geometry::wrap_angle(after.pose.yaw - before.pose.yaw);
                assert!(
                    (turned - way * libm::sin(slip) / (base / 2.0)).abs() < 1e-9,
                    "{turned} at {} m/s",
                    before.speed
                );
                fastest = fastest.max(before.speed);
            }
        };
        let (seed, go_on) = (Seed::root(5), &mut |_| ControlFlow::Continue(()));
        evaluate_observed(&mut Random::default(), &scenario, 0..3, &seed, &seed, &mut note, go_on);
        assert!(fastest > 2.0, "{form}: {fastest} m/s");
    }
}

/// Follows its route, and writes down how it is greeted and how many worlds it is asked about at once.
const GREETED: &str = r#"
import json, math, sys
log = open("greeted.jsonl", "a")
for line in map(json.loads, sys.stdin):
    if line["type"] == "hello":
        print(json.dumps(line), file=log, flush=True)
        print(json.dumps({"protocol": "falsify-av/1"}), flush=True)
        continue
    if len(line["worlds"]) > 1:
        sys.exit("one world at a time")
    actions = []
    for world in line["worlds"]:
        ego, (x, y, _) = world["ego"], (world["route"] or [(0, 0, 0)])[:4][-1]
        turn = math.remainder(math.atan2(y - ego["y"], x - ego["x"]) - ego["yaw"], math.tau)
        actions.append({"id": world["id"], "acceleration": 3 * (6 - ego["speed"]), "wheel_angle": max(-0.6, min(0.6, 0.8 * turn))})
    print(json.dumps({"actions": actions}), flush=True)
"#;

#[needs(python)]
#[test]
fn a_driver_is_tried_as_a_file_declares_it() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path();
    std::fs::create_dir(here.join("maps")).unwrap();
    std::fs::write(here.join("maps/real.xodr"), crate::straight_road::map("", "")).unwrap();
    std::fs::write(here.join("greeted.py"), GREETED).unwrap();
    let driver = "driver mine = external(command: \"python3 greeted.py\", worlds: 1, timeout: 60 s, route_points: 12, \
                  parameters: [\"gap=0.5\"], files: [\"greeted.py\"])\n";
    let campaign = "import \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        town real = opendrive(file: \"maps/real.xodr\")\n\
        spawn near { ego_speed: 0 m/s  bearing: 0 deg  distance: 20 m }\nepisode brief { ticks: 40  hold: 10 }\n\
        campaign c { vehicle: mkz  body: suicidal  spawn: near  episode: brief\n\
        evaluate { towns: [harbour, real]  drivers: [mine, blind]  pedestrians: [random]  episodes: 1 } }\n";
    std::fs::write(here.join("all.scn"), format!("edition 1\n{campaign}{driver}")).unwrap();
    std::fs::write(here.join("alone.scn"), format!("edition 1\n{driver}driver other = idm()\n")).unwrap();
    let check = |arguments: &[&str]| {
        let output = falsify(&[&["check", "--driver"], arguments].concat(), here);
        (output.status.code(), said(&output))
    };
    let greetings = || {
        let text = std::fs::read_to_string(here.join("greeted.jsonl")).unwrap_or_default();
        let _ = std::fs::remove_file(here.join("greeted.jsonl"));
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect::<Vec<serde_json::Value>>()
    };
    let (code, text) = check(&["mine", "all.scn"]);
    assert!(code == Some(3) && text.contains("error[external-not-allowed]") && greetings().is_empty(), "{text}");

    let (code, text) = check(&["mine", "--allow-external", "all.scn"]);
    assert_eq!((code, text.matches("FAIL").count()), (Some(0), 0), "{text}");
    for town in ["harbour", "real"] {
        assert!(text.contains(&format!("ok    drives 4 episodes in {town} to their end")), "{text}");
    }
    assert!(!text.contains("at once"), "{text}");
    let found = greetings();
    let towns: Vec<&str> = found.iter().map(|hello| hello["town"].as_str().unwrap()).collect();
    assert_eq!(towns, ["harbour", "harbour", "real", "real", "empty_road"]);
    for hello in &found {
        assert_eq!(
            (&hello["worlds"], &hello["route_points"], &hello["parameters"]["gap"]),
            (&1.into(), &12.into(), &0.5.into())
        );
        assert_eq!(hello["vehicle"]["length"], 2.0 * 2.450_842);
        // 0.7 of 70 degrees.
        assert!((hello["vehicle"]["greatest_wheel_angle"].as_f64().unwrap() - 0.855_211).abs() < 1e-6);
    }
    let map = std::fs::canonicalize(here.join("maps/real.xodr")).unwrap();
    let record = results::report::FileRecord::new(String::new(), &std::fs::read(&map).unwrap());
    assert_eq!(found[2]["map"], serde_json::json!({ "file": map, "blake3": record.blake3 }));
    assert!(found[0]["map"].is_null() && found[4]["map"].is_null());

    let (code, text) = check(&["mine", "--allow-external", "alone.scn"]);
    assert!(code == Some(0) && text.contains("no campaign of the files uses it"), "{text}");
    assert!(greetings().iter().all(|hello| hello["vehicle"]["length"] == 2.0 * 2.395_890));
    // A driver of ours is tried by the same path.
    let (code, text) = check(&["other", "--allow-external", "alone.scn"]);
    assert!(code == Some(0) && text.contains("ok    follows its lane there to the end"), "{text}");

    let (code, text) = check(&["mime", "all.scn", "--allow-external"]);
    assert!(code == Some(2) && text.contains("declare no driver `mime`; did you mean `mine`?"), "{text}");
    std::fs::remove_file(here.join("greeted.py")).unwrap();
    let (code, text) = check(&["mine", "--allow-external", "alone.scn"]);
    assert!(code == Some(3) && text.contains("greeted.py"), "{text}");
}

#[needs(python)]
#[test]
fn a_late_answer_in_a_later_pass_is_a_late_answer() {
    let place = tempfile::tempdir().unwrap();
    let driver = folder("tests/external/driver.py");
    let words = ["check", "--timeout", "5", "--", "python3", driver.to_str().unwrap(), "late", "starts"];
    let text = said(&falsify(&words, place.path()));
    let late = "it did not answer within 5000 ms; `--timeout` here";
    let failed = text.lines().find(|line| line.contains("FAIL")).unwrap_or_default();
    assert!(failed.contains("when the same seeds come again: in episode ") && failed.contains(late), "{text}");
}

#[needs(python)]
#[test]
fn messages_of_a_driver_command_no_terminal_and_have_an_end() {
    let text =
        said(&falsify(&["check", "--timeout", "60", "--", "python3", "driver.py", "loud"], &folder("tests/external")));
    assert!(text.contains("title \\u{1b}]0;mine\\u{7}") && !text.contains("\u{1b}]"), "{}", &text[..200]);
    assert!(text.len() < 3 << 19 && text.contains("further messages of programs are left out"), "{}", text.len());
}

#[needs(program = "c++")]
#[test]
fn the_driver_in_cpp_compiles_and_conforms() {
    let place = tempfile::tempdir().unwrap();
    let source = folder("scenarios/external/my_av.cpp");
    let compiler =
        Command::new("c++").args(["-O2", "-o", "my_av"]).arg(source).current_dir(place.path()).output().unwrap();
    assert!(compiler.status.success(), "{}", said(&compiler));
    let output = falsify(&["check", "--timeout", "60", "--", "./my_av"], place.path());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

/// With and without the Python package the name is unknown: the sentence says what to do, and no driver is started.
#[test]
fn a_driver_of_others_that_is_not_there_is_reported_with_what_installs_it() {
    let place = tempfile::tempdir().unwrap();
    let output = falsify(&["check", "--driver", "somo"], place.path());
    let text = said(&output);
    assert_eq!(output.status.code(), Some(5), "{text}");
    let reasons = ["pip install './python[somo]'", "'somo' is no driver of others", "cannot be started"];
    assert!(text.contains("FAIL  is installed: ") && reasons.iter().any(|reason| text.contains(reason)), "{text}");
    let both = falsify(&["check", "--driver", "sumo", "--", "python3", "my_av.py"], place.path());
    assert_eq!(both.status.code(), Some(2), "{}", said(&both));
}

/// Drives straight on and writes down where it is and which sign it is shown.
const WRITING: &str = r#"
import json, sys
with open("signs.txt", "w") as signs:
    for line in sys.stdin:
        message = json.loads(line)
        if message["type"] == "hello":
            print(json.dumps({"protocol": "falsify-av/1"}), flush=True)
            continue
        for world in message["worlds"]:
            print(world["ego"]["x"], json.dumps(world["sign"]), sep="\t", file=signs, flush=True)
        actions = [{"id": world["id"], "acceleration": 2 * (12 - world["ego"]["speed"])} for world in message["worlds"]]
        print(json.dumps({"actions": actions}), flush=True)
"#;

#[needs(python)]
#[test]
fn stop_and_yield_signs_on_the_way_are_in_the_messages() {
    for (kind, named) in [(206, "stop"), (205, "yield")] {
        let place = tempfile::tempdir().unwrap();
        let here = place.path();
        let sign = format!(r#"<signal id="7" s="300" t="-4" type="{kind}" orientation="+"/>"#);
        std::fs::write(here.join("real.xodr"), crate::straight_road::map("", &sign)).unwrap();
        std::fs::write(here.join("writing.py"), WRITING).unwrap();
        let scenario = "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\ntown real = opendrive(file: \"real.xodr\")\n\
            driver mine = external(command: \"python3 writing.py\", worlds: 1, timeout: 60 s)\n\
            spawn here { ego_poses: [(150 m, -1.75 m, 0 deg)]  bearing: 180 deg  distance: 60 m }\n\
            episode brief { ticks: 400  hold: 10 }\n\
            campaign c { vehicle: model3  body: suicidal  spawn: here  episode: brief\n\
            evaluate { towns: [real]  drivers: [mine]  pedestrians: [intercept]  episodes: 1 } }\n";
        std::fs::write(here.join("signs.scn"), scenario).unwrap();
        let output = falsify(&["run", "--allow-external", "signs.scn"], here);
        assert!(output.status.success(), "{}", said(&output));
        let text = std::fs::read_to_string(here.join("signs.txt")).unwrap();
        let seen: Vec<(f64, serde_json::Value)> = text
            .lines()
            .map(|line| {
                let (x, sign) = line.split_once('\t').unwrap();
                (x.parse().unwrap(), serde_json::from_str(sign).unwrap())
            })
            .collect();
        let shown = |from: f64, to: f64| seen.iter().filter(move |(x, _)| (from..to).contains(x));
        assert!(shown(220.0, 295.0).count() > 10 && shown(301.0, 320.0).count() > 3, "{text}");
        for (x, sign) in shown(220.0, 295.0) {
            let distance = sign["distance"].as_f64().unwrap();
            assert!(sign["kind"] == named && (x + distance - 300.0).abs() < 1.0, "at {x} m: {sign}");
        }
        assert!(shown(0.0, 205.0).chain(shown(301.0, 400.0)).all(|(_, sign)| sign.is_null()), "{text}");
    }
}
