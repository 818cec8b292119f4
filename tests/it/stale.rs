//! Results of a driver of one's own belong to its declared files: after an edit they are made again, and every command names the file.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{command, falsify};
use needs::needs;

const SCENARIO: &str = r#"edition 1
import "std/drivers.scn"
import "std/pedestrians.scn"
import "std/towns.scn"
driver mine = external(command: "COMMAND", timeout: 60 s MORE)
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
episode until_passed { hold: 10  ticks: 240  end_when: ahead < -6 m }
campaign d {
  vehicle: model3  body: plausible  spawn: near  episode: until_passed
  evaluate { towns: [harbour] drivers: [mine] pedestrians: [intercept] episodes: 12 }
}
"#;

/// Brakes for whom it sees within `params.GAP`.
const DRIVER: &str = r#"import json, sys, params
print(json.dumps({"protocol": "falsify-av/1", "name": "drv"}), flush=True)
sys.stdin.readline()
for line in sys.stdin:
    actions = []
    for world in json.loads(line)["worlds"]:
        ego = world["ego"]
        near = any((a["x"] - ego["x"]) ** 2 + (a["y"] - ego["y"]) ** 2 < params.GAP ** 2 for a in world["actors"])
        pull = 1.0 if ego["speed"] < 0.8 * world["speed_limit"] else 0.0
        actions.append({"id": world["id"], "throttle": 0.0 if near else pull, "brake": 1.0 if near else 0.0, "steer": 0.0})
    print(json.dumps({"actions": actions}), flush=True)
"#;

fn write(here: &Path, command: &str, more: &str) {
    std::fs::write(here.join("d.scn"), SCENARIO.replace("COMMAND", command).replace("MORE", more)).unwrap();
}

/// A folder with a driver, run once.
fn folder(command: &str, more: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("drv.py"), DRIVER).unwrap();
    std::fs::write(place.path().join("params.py"), "GAP = 0.0\n").unwrap();
    write(place.path(), command, more);
    run(place.path(), &[], 0);
    place
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// What the program says, with this exit code.
fn falsify_said(here: &Path, arguments: &[&str], code: i32) -> String {
    let output = falsify(arguments, here);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", said(&output));
    said(&output)
}

fn run(here: &Path, more: &[&str], code: i32) -> String {
    falsify_said(here, &[&["run", "--allow-external", "d.scn"], more].concat(), code)
}

fn reused(text: &str) -> bool {
    text.contains("tasks were there already")
}

/// The name of an episode with a collision.
fn failure(here: &Path) -> String {
    let names = falsify_said(here, &["failures", "--names", "--top", "1"], 0);
    names.lines().next().unwrap_or_else(|| panic!("it hits somebody: {names}")).to_owned()
}

#[needs(python)]
#[test]
fn every_command_names_the_file_of_a_driver_that_was_edited() {
    let place = folder("python3 drv.py", r#", files: ["drv.py", "params.py"]"#);
    let here = place.path();
    let again = run(here, &[], 0);
    assert!(
        again.contains("2 of 2 tasks were there already: same scenario, seed and build; `mine` is drv.py, params.py")
    );
    let name = failure(here);

    std::fs::write(here.join("params.py"), "GAP = 14.0\n").unwrap();
    let list = run(here, &["--list"], 0);
    assert!(list.contains("[run: `params.py` changed]"), "{list}");
    assert!(list.contains("`falsify recheck --allow-external reports/d` lets the new program meet"), "{list}");
    let refused = run(here, &[], 2);
    assert!(refused.contains("`params.py` of `mine` has changed since then"), "{refused}");
    assert!(refused.contains("`falsify recheck --allow-external reports/d` lets the new program meet"), "{refused}");
    // The report holds the files of the run: its failures are repeated, and the new program meets them beside the old one.
    let held = "the program of `mine` has changed since the report, which holds its files: they are used, and those that it does not declare as they are now";
    for arguments in [&["replay", "--allow-external", &name][..], &["replay", "--allow-external", "--all", "reports/d"]]
    {
        let text = falsify_said(here, arguments, 0);
        assert!(text.contains(held), "{arguments:?}: {text}");
    }
    falsify_said(here, &["export", "--allow-external", &name, "--as", "xosc-1.3"], 0);
    let recheck = ["recheck", "--allow-external", "--starts", "0", "reports/d", "--format", "json"];
    let recheck = falsify_said(here, &recheck, 0);
    assert!(!recheck.contains("cannot be run as it was"), "{recheck}");
    let rows: serde_json::Value =
        serde_json::from_str(recheck.lines().find(|line| line.starts_with('{')).unwrap()).unwrap();
    let number = |key: &str| rows["failures"][0][key].as_u64().unwrap();
    assert!(number("gone") > 0 && number("still_collisions") + number("gone") == number("failures"), "{recheck}");

    // A copy that is not as it was is not used.
    std::fs::write(here.join("reports/d/programs/mine/params.py"), "GAP = 3.0\n").unwrap();
    let reason =
        "possible reason: `params.py` of `mine` has changed since the report; `falsify recheck --allow-external";
    for arguments in [&["replay", "--allow-external", &name][..], &["replay", "--allow-external", "--all", "reports/d"]]
    {
        let text = falsify_said(here, arguments, 8);
        assert!(text.contains(reason) && !text.contains("drive the same way twice"), "{arguments:?}: {text}");
    }
    let recheck = falsify_said(here, &["recheck", "--allow-external", "--starts", "0", "reports/d"], 0);
    let recheck = recheck.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(recheck.contains("`params.py` of `mine` has changed since the report"), "{recheck}");
    assert!(!reused(&run(here, &["--replace"], 0)));

    // With the old file the old results are right again.
    std::fs::write(here.join("params.py"), "GAP = 0.0\n").unwrap();
    assert!(reused(&run(here, &["--replace"], 0)));
}

#[needs(python)]
#[test]
fn an_edited_driver_is_repeated_with_files_that_it_does_not_declare_and_in_its_own_folder() {
    let place = folder("python3 drv.py", r#", files: ["drv.py"]"#);
    let here = place.path();
    let name = failure(here);
    std::fs::write(here.join("drv.py"), DRIVER.replace("1.0 if near", "1.0 if True")).unwrap();
    let text = falsify_said(here, &["replay", "--allow-external", &name], 0);
    assert!(text.contains("they are used, and those that it does not declare as they are now"), "{text}");

    // Two drivers with one command, each in a folder of its own: an edit of one does not place the other.
    let two = tempfile::tempdir().unwrap();
    let here = two.path();
    for (part, gap) in [("a", "0.0"), ("b", "0.0")] {
        std::fs::create_dir(here.join(part)).unwrap();
        std::fs::write(here.join(part).join("drv.py"), DRIVER).unwrap();
        std::fs::write(here.join(part).join("params.py"), format!("GAP = {gap}\n")).unwrap();
        let policy = r#"edition 1
driver mine_PART = external(command: "python3 drv.py", timeout: 60 s, files: ["drv.py", "params.py"])
"#;
        std::fs::write(here.join(part).join("p.scn"), policy.replace("PART", part)).unwrap();
    }
    let one = "driver mine = external(command: \"COMMAND\", timeout: 60 s MORE)";
    let both = SCENARIO.replace(one, "import \"a/p.scn\"\nimport \"b/p.scn\"").replace("[mine]", "[mine_a, mine_b]");
    std::fs::write(here.join("d.scn"), both).unwrap();
    run(here, &[], 0);
    std::fs::write(here.join("b/params.py"), "GAP = 14.0\n").unwrap();
    let text = falsify_said(here, &["replay", "--allow-external", "--all", "reports/d"], 0);
    assert!(text.contains("the program of `mine_b` has changed") && !text.contains("of `mine_a` has"), "{text}");
}

#[needs(python)]
#[test]
fn files_above_the_folder_of_the_scenario_are_held_or_named() {
    let place = tempfile::tempdir().unwrap();
    let here = place.path().join("studies/first");
    std::fs::create_dir_all(&here).unwrap();
    std::fs::create_dir(place.path().join("lib")).unwrap();
    std::fs::write(place.path().join("lib/drv.py"), DRIVER).unwrap();
    let gap = |gap: &str| std::fs::write(here.join("../../lib/params.py"), format!("GAP = {gap}\n")).unwrap();
    gap("0.0");
    std::fs::write(here.join("../notes.txt"), "beside").unwrap();
    let command = "python3 ../../lib/drv.py ../notes.txt";
    write(&here, command, r#", files: ["../../lib", "../notes.txt"]"#);
    let text = run(&here, &[], 0);
    assert!(!text.contains("a replay runs"), "{text}");
    assert!(here.join("reports/d/programs/mine/above-2/lib/params.py").is_file());
    let name = failure(&here);
    gap("14.0");
    let text = falsify_said(&here, &["replay", "--allow-external", &name], 0);
    assert!(text.contains("the program of `mine` has changed since the report, which holds its files"), "{text}");

    let warned = |files: &str, why: &str| {
        write(&here, command, &format!(", files: [{files}]"));
        let text = run(&here, &["--out", why.split(' ').next_back().unwrap()], 0);
        let warning = "a replay runs `mine` as it is then, not as it was in this run: ";
        assert!(text.contains(&format!("{warning}{why}")), "{text}");
    };
    warned(r#""../../lib""#, "`../notes.txt` of its command is none of its `files`: add it");
    let absolute = here.canonicalize().unwrap().join("d.scn").display().to_string();
    warned(&format!("{absolute:?}"), &format!("`{absolute}` is not a path from the folder of the scenario"));
    std::os::unix::fs::symlink("../notes.txt", here.join("link")).unwrap();
    warned(r#""link", "../../lib""#, "`link` is a link or behind one: name the file that it leads to");
}

#[needs(python)]
#[test]
fn work_of_a_program_without_files_is_repeated_unless_the_scenario_states_its_version() {
    let place = folder("python3 drv.py", "");
    let here = place.path();
    let list = run(here, &["--list"], 0);
    assert!(list.contains("[run: `mine` declares no `files`]"), "{list}");
    let again = run(here, &[], 0);
    assert!(!reused(&again), "{again}");
    assert!(
        again.contains("2 stored tasks are run again: `mine` declares no `files`, so it may have changed"),
        "{again}"
    );

    write(here, "python3 drv.py", ", version: \"7\"");
    run(here, &["--replace"], 0);
    let again = run(here, &[], 0);
    assert!(reused(&again) && again.contains("`mine` is version 7"), "{again}");
    write(here, "python3 drv.py", ", version: \"8\"");
    assert!(!reused(&run(here, &["--replace"], 0)));
    write(here, "python3 drv.py", ", files: [\"gone.py\"]");
    assert!(run(here, &["--replace"], 3).contains("there is no file or folder `gone.py`"));
}

/// Sleeps before its answer when the file `slow` is there.
const SLEEPER: &str = "import os, time\n";

#[cfg(unix)]
#[needs(python)]
#[test]
fn ctrl_c_ends_a_run_that_waits_for_a_driver_and_keeps_what_was_stored() {
    let place = folder("python3 drv.py", r#", worlds: 1, files: ["drv.py"]"#);
    let here = place.path();
    let slow =
        DRIVER.replace("    actions = []\n", "    if os.path.exists('slow'): time.sleep(60)\n    actions = []\n");
    std::fs::write(here.join("drv.py"), SLEEPER.to_owned() + &slow).unwrap();
    let scenario = std::fs::read_to_string(here.join("d.scn")).unwrap();
    std::fs::write(here.join("d.scn"), scenario.replace("[mine]", "[idm, mine]")).unwrap();
    std::fs::write(here.join("slow"), "").unwrap();
    let mut command = command();
    command.args(["run", "--allow-external", "d.scn", "--replace", "--progress", "lines"]).current_dir(here);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_secs(3));
    let asked = Instant::now();
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let took = asked.elapsed();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(took < Duration::from_secs(30), "{took:?}: {}", said(&output));
    std::fs::remove_file(here.join("slow")).unwrap();
    let again = run(here, &["--replace"], 0);
    assert!(again.contains("2 of 4 tasks were there already"), "{again}");
    assert_eq!(std::fs::read_to_string(here.join("reports/d/episodes.csv")).unwrap().lines().count(), 25);
}
