//! The episodes of a report can be repeated to the bit, and a run can pass or fail.

use std::path::Path;
use std::process::Output;

use crate::program::falsify;

const SCENARIO: &str = r#"
edition 1
import "LIB/paper.scn"
import "LIB/drivers.scn"
import "LIB/towns.scn"
param headway: time = 1.5 s
driver near = idm(time_headway: headway)
training short = ppo(steps: 256, steps_per_update: 128)
method home = homing()
campaign again {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] drivers: [near] rewards: [r1] runs: 1 }
  evaluate { towns: [harbour] drivers: [near, behavior] pedestrians: [trained, stochastic, untrained, intercept] episodes: 6 }
  search { towns: [harbour] drivers: [near] methods: [home] budget: 3_000 runs: 1 episodes: 0 }
}
"#;

fn scenario(folder: &Path) {
    let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
    std::fs::write(folder.join("again.scn"), SCENARIO.replace("LIB", &lib.display().to_string())).unwrap();
}

fn said(output: &Output) -> String {
    [output.stdout.as_slice(), &output.stderr].concat().iter().map(|byte| char::from(*byte)).collect()
}

/// The rows of a table, each as the values of these columns.
fn rows(report: &Path, table: &str, columns: &[&str]) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(report.join(format!("{table}.csv"))).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places: Vec<usize> =
        columns.iter().map(|column| head.iter().position(|name| name == column).expect("it is a column")).collect();
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        places.iter().map(|place| values[*place].to_string()).collect()
    };
    lines.map(row).collect()
}

#[test]
fn a_report_can_be_replayed_drawn_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    scenario(here);
    let run = falsify(&["run", "--set", "headway=1 s", "again.scn"], here);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let report = here.join("reports/again");

    let all = rows(
        &report,
        "episodes",
        &["run_id", "episode", "outcome", "digest", "fault", "episode_length_s", "pedestrian"],
    );
    assert_eq!(all.len(), 48);
    let hit = all.iter().find(|row| row[2] == "collision" && row[6] == "intercept").expect("it hits somebody");
    let name = format!("{}:{}", hit[0], hit[1]);
    let touches = all.iter().filter(|row| ["collision", "bump"].contains(&row[2].as_str())).count();
    let failures = rows(&report, "failures", &["run_id", "number", "state_hashes"]);
    let of_episodes = failures.iter().filter(|row| all.iter().any(|episode| episode[..2] == row[..2]));
    assert_eq!(of_episodes.filter(|row| !row[2].is_empty()).count(), touches);

    // From another working folder, the files are found in their original folder.
    let elsewhere = tempfile::tempdir().unwrap();
    let replay = falsify(&["replay", &name, "--report", &report.display().to_string()], elsewhere.path());
    assert_eq!(replay.status.code(), Some(0), "{replay:?}");
    assert!(said(&replay).contains(&format!("digest {}: as in the report", hit[3])), "{}", said(&replay));
    let told = falsify(&["replay", &name, "--json", "--ticks", "way.csv"], here);
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    assert_eq!((told["equal"].as_bool(), told["digest"].as_str()), (Some(true), Some(hit[3].as_str())));

    let ticks = rows(here, "way", &["tick", "gap_m"]);
    let (end, length) = (0.05 * (ticks.len() - 1) as f64, hit[5].parse::<f64>().unwrap());
    assert!((end - length).abs() < 0.051, "a row for each tick: {end} and {length}");

    let searches = rows(&report, "searches", &["run_id"]);
    let mut found = rows(&report, "failures", &["run_id", "number"]);
    found.retain(|row| searches.iter().any(|search| search[0] == row[0]));
    assert!(!found.is_empty(), "the search finds something");
    let failure = falsify(&["replay", &format!("{}:{}", found[0][0], found[0][1])], here);
    assert_eq!(failure.status.code(), Some(0), "{failure:?}");

    for (arguments, moves) in
        [(vec!["export", &name, "--as", "svg"], false), (vec!["export", &name, "--as", "animation"], true)]
    {
        let drawn = falsify(&arguments, here);
        assert_eq!(drawn.status.code(), Some(0), "{drawn:?}");
        let path = here.join(String::from_utf8(drawn.stdout).unwrap().split_whitespace().last().unwrap());
        let page = std::fs::read_to_string(path).unwrap();
        roxmltree::Document::parse(&page).unwrap();
        assert_eq!(page.contains("<animateTransform"), moves);
        assert!(page.contains("class=\"lane\"") && page.contains(&name) && !page.contains("<script"));
    }

    let verify = falsify(&["replay", "--all", "reports/again", "--trainings"], here);
    assert_eq!(verify.status.code(), Some(0), "{verify:?}");
    let count = 48 + found.len();
    assert!(said(&verify).contains(&format!("{count} repeated, {count} equal")), "{}", said(&verify));
    assert!(said(&verify).contains("trainings: 1 repeated, 1 equal"), "{}", said(&verify));

    differences_are_found(here, &report, &name);
}

/// A changed scenario file, a changed pedestrian and a changed row are each noticed.
fn differences_are_found(here: &Path, report: &Path, name: &str) {
    let manifest = std::fs::read_to_string(report.join("manifest.toml")).unwrap();
    std::fs::write(report.join("manifest.toml"), manifest.replace("\nseed = 1\n", "\nseed = 2\n")).unwrap();
    let other = falsify(&["replay", name], here);
    assert_eq!(other.status.code(), Some(8), "{other:?}");
    assert!(said(&other).contains("it diverges between tick 1 and tick 20 "), "{}", said(&other));
    assert_eq!(falsify(&["replay", "--all", "reports/again"], here).status.code(), Some(8));
    std::fs::write(report.join("manifest.toml"), &manifest).unwrap();
    assert_eq!(falsify(&["replay", name], here).status.code(), Some(0));

    let pedestrian = report.join("pedestrians/r1-harbour-near-0.safetensors");
    let whole = std::fs::read(&pedestrian).unwrap();
    let mut bytes = whole.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&pedestrian, bytes).unwrap();
    let verify = falsify(&["replay", "--all", "reports/again", "--sample", "1", "--trainings"], here);
    assert_eq!(verify.status.code(), Some(8), "{verify:?}");
    let refused = falsify(&["replay", name], here);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(said(&refused).contains("near-0.safetensors` is not as it was written"), "{}", said(&refused));
    std::fs::write(&pedestrian, whole).unwrap();

    let file = here.join("again.scn");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("episodes: 6", "episodes: 7")).unwrap();
    let held = falsify(&["replay", name], here);
    assert_eq!(held.status.code(), Some(0), "the report holds what was run: {held:?}");
    let changed = falsify(&["replay", name, "--files", "."], here);
    assert_eq!(changed.status.code(), Some(8), "{changed:?}");
    assert!(said(&changed).contains("again.scn` has changed since then"), "{}", said(&changed));
    let anyway = falsify(&["replay", name, "--files", ".", "--anyway"], here);
    assert_eq!(anyway.status.code(), Some(0), "the episode itself is the same: {anyway:?}");

    for (wrong, wanted) in [("deadbeef:0", "has a run `deadbeef`"), ("deadbeef", "write RUN:EPISODE")] {
        let output = falsify(&["replay", wrong], here);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(said(&output).contains(wanted), "{}", said(&output));
    }
}

/// A scenario with a file beside it and a map, as they stand in a folder.
fn scenario_of_several_files(folder: &Path) {
    std::fs::create_dir_all(folder.join("lib")).unwrap();
    std::fs::create_dir_all(folder.join("maps")).unwrap();
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/files/odd.xodr");
    std::fs::copy(map, folder.join("maps/odd.xodr")).unwrap();
    let driver = "edition 1\nparam share: number = 0.5\ndriver mild = cruise(limit_share: share)\n";
    std::fs::write(folder.join("lib/driver.scn"), driver).unwrap();
    let text = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "lib/driver.scn"
town odd = opendrive(file: "maps/odd.xodr")
spawn near { distance: 7 m .. 9 m }
campaign parcel {
  vehicle: model3  body: suicidal  spawn: near  episode: thirty_seconds
  evaluate { towns: [odd] drivers: [mild] pedestrians: [intercept] episodes: 4 }
}
"#;
    std::fs::write(folder.join("parcel.scn"), text).unwrap();
}

#[test]
fn a_report_is_repeated_without_the_folder_it_came_from() {
    let (home, away) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    scenario_of_several_files(home.path());
    let run = falsify(&["run", "--set", "share=0.7", "parcel.scn"], home.path());
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let report = away.path().join("mailed");
    std::fs::rename(home.path().join("reports/parcel"), &report).unwrap();
    for held in ["parcel.scn", "lib/driver.scn", "maps/odd.xodr"] {
        let original = std::fs::read(home.path().join(held)).unwrap();
        assert_eq!(std::fs::read(report.join("scenario").join(held)).unwrap(), original, "{held}");
    }
    drop(home);
    let verify = falsify(&["replay", "--all", "mailed"], away.path());
    assert_eq!(verify.status.code(), Some(0), "{verify:?}");
    assert!(said(&verify).contains("4 repeated, 4 equal"), "{verify:?}");

    // A held file is part of the report, so a change of it is noticed.
    let driver = report.join("scenario/lib/driver.scn");
    let text = std::fs::read_to_string(&driver).unwrap();
    std::fs::write(&driver, text.replace("0.5", "0.6")).unwrap();
    let verify = falsify(&["replay", "--all", "mailed"], away.path());
    assert_eq!(verify.status.code(), Some(8), "{verify:?}");
    assert!(said(&verify).contains("driver.scn` has changed since then"), "{verify:?}");
    std::fs::write(&driver, text).unwrap();

    // Without a file that it does not hold, the message names it.
    std::fs::remove_dir_all(report.join("scenario/maps")).unwrap();
    let manifest = std::fs::read_to_string(report.join("manifest.toml")).unwrap();
    std::fs::write(report.join("manifest.toml"), manifest.replace("held = \"scenario/maps/odd.xodr\"\n", "")).unwrap();
    let gone = falsify(&["replay", "--all", "mailed"], away.path());
    assert_eq!(gone.status.code(), Some(2), "{gone:?}");
    assert!(said(&gone).contains("does not hold `maps/odd.xodr`") && said(&gone).contains("--files"), "{gone:?}");
}

#[test]
fn a_finished_report_is_not_replaced_by_one_of_something_else() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    scenario_of_several_files(here);
    let run = |more: &[&str]| falsify(&[&["run", "parcel.scn"], more].concat(), here);
    let names = || rows(&here.join("reports/parcel"), "episodes", &["run_id", "episode", "digest"]);
    assert_eq!(run(&[]).status.code(), Some(0));
    let first = names();
    assert_eq!(run(&[]).status.code(), Some(0), "the same again");
    assert_eq!(names(), first);

    for (more, reason) in [
        (["--set", "share=0.7"], "its settings are none, these are `share = 0.7`"),
        (["--seed", "2"], "its seed is 1, this one is 2"),
    ] {
        let other = run(&more);
        assert_eq!(other.status.code(), Some(2), "{other:?}");
        assert!(said(&other).contains(reason) && said(&other).contains("--replace"), "{}", said(&other));
        assert_eq!(names(), first, "it is as it was");
    }
    let file = here.join("parcel.scn");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("7 m .. 9 m", "7 m .. 8 m")).unwrap();
    let other = run(&[]);
    assert_eq!(other.status.code(), Some(2), "{other:?}");
    assert!(said(&other).contains("`parcel.scn` has changed since then"), "{}", said(&other));

    // More episodes are the same runs, longer. Fewer would lose some.
    std::fs::write(&file, format!("// a comment\n{}", text.replace("episodes: 4", "episodes: 6"))).unwrap();
    assert_eq!(run(&[]).status.code(), Some(0));
    assert_eq!(names()[..4], first);
    std::fs::write(&file, &text).unwrap();
    assert_eq!(run(&[]).status.code(), Some(2), "two episodes would be lost");

    assert_eq!(run(&["--set", "share=0.7", "--replace"]).status.code(), Some(0));
    let other = names();
    assert!(other.iter().all(|row| row[0] != first[0][0]), "another setting is another run: {other:?}");
}

/// The elements of `junit-10.xsd` of Jenkins' xUnit plug-in that are written: element, parent, required attributes, other attributes.
const SCHEMA: [(&str, &str, &[&str], &[&str]); 7] = [
    ("testsuites", "", &[], &["name", "time", "tests", "failures", "errors"]),
    ("testsuite", "testsuites", &["name", "tests", "failures", "errors"], &["time", "skipped"]),
    ("properties", "testsuite", &[], &[]),
    ("property", "properties", &["name", "value"], &[]),
    ("testcase", "testsuite", &["name"], &["classname"]),
    ("failure", "testcase", &[], &["type", "message"]),
    ("skipped", "testcase", &[], &["type", "message"]),
];

fn follows_the_schema(node: roxmltree::Node<'_, '_>) {
    let name = node.tag_name().name();
    let parent = node.parent_element().map_or("", |parent| parent.tag_name().name());
    let known = SCHEMA.iter().find(|(element, ..)| *element == name);
    let (_, above, must, may) = known.unwrap_or_else(|| panic!("the schema has no `{name}`"));
    assert_eq!(*above, parent, "{name}");
    assert!(must.iter().all(|attribute| node.has_attribute(*attribute)), "{node:?}");
    let mut attributes = node.attributes();
    assert!(
        attributes.all(|attribute| must.contains(&attribute.name()) || may.contains(&attribute.name())),
        "{node:?}"
    );
}

#[test]
fn a_broken_gate_is_said_in_the_exit_code_and_in_junit() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    scenario(here);
    let typo = falsify(&["run", "--fail-if", "colision_rate > 0.5", "again.scn"], here);
    assert_eq!(typo.status.code(), Some(2));
    assert!(said(&typo).contains("did you mean `collision_rate") && !here.join("reports").exists(), "{typo:?}");
    let nothing = falsify(&["run", "--fail-if", "collision_rate > 0.5 and pedestrian == intercpt", "again.scn"], here);
    assert_eq!(nothing.status.code(), Some(2), "{nothing:?}");
    assert!(said(&nothing).contains("`pedestrian` can be: "), "{nothing:?}");
    assert!(!here.join("reports").exists(), "it is known before the run");

    let gates =
        ["--fail-if", "collision_rate >= 0.5 and pedestrian == intercept", "--fail-if", "front_rate == 0.123456"];
    let run = [&["run", "--junit", "out/results.xml"], &gates[..], &["again.scn"]].concat();
    let run = falsify(&run, here);
    assert_eq!(run.status.code(), Some(7), "{run:?}");
    let (gate, why) = (said(&run).find("--fail-if collision_rate >= 0.5"), said(&run).find(": The driver "));
    assert!(gate.is_some() && why > gate, "{run:?}");
    let page = std::fs::read_to_string(here.join("out/results.xml")).unwrap();
    let page = roxmltree::Document::parse(&page).unwrap();
    let suites = page.root_element();
    let suite = suites.first_element_child().unwrap();
    assert_eq!((suites.tag_name().name(), suite.tag_name().name()), ("testsuites", "testsuite"));
    let report = here.join("reports/again");
    let cells = rows(&report, "results", &["collision_rate", "pedestrian", "driver"]);
    let episodes = rows(&report, "episodes", &["outcome", "pedestrian", "driver"]);
    // A cell without a touch has no share of touches in front.
    let is_touched = |cell: &[String]| {
        episodes.iter().any(|row| ["collision", "bump"].contains(&row[0].as_str()) && row[1..] == cell[1..])
    };
    let mut wanted: Vec<&str> = cells
        .iter()
        .map(|cell| match cell[0].parse::<f64>().unwrap() {
            rate if rate >= 0.5 && cell[1] == "intercept" => "failure",
            _ if !is_touched(cell) => "skipped",
            _ => "",
        })
        .collect();
    // The search has a case, too; no gate is about it.
    wanted.push("");
    let cases: Vec<_> = suite.children().filter(|node| node.has_tag_name("testcase")).collect();
    let got: Vec<&str> =
        cases.iter().map(|case| case.first_element_child().map_or("", |child| child.tag_name().name())).collect();
    assert_eq!(got, wanted);
    assert!(wanted.contains(&"failure"), "{cells:?}");
    let count = |name: &str| wanted.iter().filter(|kind| **kind == name).count().to_string();
    assert_eq!(suite.attribute("tests"), Some(wanted.len().to_string().as_str()));
    assert_eq!(suite.attribute("failures"), Some(count("failure").as_str()));
    assert_eq!(suite.attribute("skipped"), Some(count("skipped").as_str()));
    page.descendants().filter(roxmltree::Node::is_element).for_each(follows_the_schema);

    let passing = falsify(&["run", "--fail-if", "errors > 1000", "again.scn"], here);
    assert_eq!(passing.status.code(), Some(0), "{passing:?}");
}
