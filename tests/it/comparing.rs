//! Failures are listed, and two reports or two drivers are compared start by start.

use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::program::{command, falsify};

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
param share: number = 0.2
driver slow = cruise(limit_share: 0.2)
driver changed = cruise(limit_share: share)
method home = homing()
campaign two {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour] drivers: [slow, changed] pedestrians: [random, intercept] episodes: 15 }
  search { towns: [harbour] drivers: [slow, changed] methods: [home] budget: 3_000 runs: 1 episodes: 0 }
}
"#;

fn run(here: &Path, more: &[&str]) {
    std::fs::write(here.join("two.scn"), SCENARIO).unwrap();
    let output = falsify(&[&["run", "two.scn"], more].concat(), here);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.as_slice(), &output.stderr].concat()).into_owned()
}

#[test]
fn failures_are_listed_and_their_names_are_taken_by_other_commands() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here, &[]);
    let names = |more: &[&str]| {
        let output = falsify(&[&["failures", "reports/two", "--names"], more].concat(), here);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let other = falsify(&["run", "two.scn", "--only", "three"], here);
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other).contains("no campaign is called `three`; the files have two"), "{other:?}");
    let all = names(&[]);
    let objects = falsify(&["failures", "reports", "--format", "json"], here);
    let objects: Vec<serde_json::Value> =
        text(&objects).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(objects.len(), all.lines().count());
    for found_by in ["evaluation", "search"] {
        assert!(objects.iter().any(|object| object["found_by"] == found_by), "{found_by}");
    }
    assert!(objects.iter().zip(all.lines()).all(|(object, name)| object["name"] == name));
    let table = falsify(&["failures", "--report", "reports/two", "--format", "csv"], here);
    assert_eq!(text(&table).lines().count(), objects.len() + 1);

    let of_slow = objects.iter().filter(|object| object["driver"] == "slow").count();
    assert_eq!(names(&["--driver", "slow"]).lines().count(), of_slow);
    // A word that no report has is a mistake, not an empty list.
    for (option, wrong, known) in [
        ("--found-by", "none_such", "known are: home, intercept, random"),
        ("--driver", "slwo", "no report has a driver `slwo`"),
        ("--kind", "frnt", "no report has a word of a kind `frnt`"),
    ] {
        let refused = falsify(&["failures", "reports/two", option, wrong], here);
        assert_eq!(refused.status.code(), Some(2), "{refused:?}");
        assert!(text(&refused).contains(known), "{refused:?}");
    }
    // Each start is evaluated with two pedestrians, and searched.
    let distinct = names(&["--distinct"]).lines().count();
    assert!(0 < distinct && distinct < objects.len(), "{distinct} of {}", objects.len());
    // A smoke run beside it is left out, and named.
    run(here, &["--smoke"]);
    let beside = falsify(&["failures", "reports", "--names"], here);
    assert_eq!(beside.stdout, all.as_bytes().to_vec(), "{beside:?}");
    assert!(text(&beside).contains("two-smoke"), "{beside:?}");
    std::fs::remove_dir_all(here.join("reports/two-smoke")).unwrap();
    let wrong = falsify(&["failures", "reports", "--verdict", "bad"], here);
    assert_eq!(wrong.status.code(), Some(2));

    // From another folder, by the path alone; several at once, from the input.
    let three = names(&["--top", "3"]);
    let mut replay = command();
    replay.args(["replay", "--json", "-"]).current_dir(here).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = replay.spawn().unwrap();
    child.stdin.take().unwrap().write_all(three.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output).lines().count()), (Some(0), 3), "{output:?}");

    // A file that was edited is named as such, and no bug is suspected.
    let summary = here.join("reports/two/summary.md");
    let whole = std::fs::read_to_string(&summary).unwrap();
    std::fs::write(&summary, format!("{whole}\nA remark of ours.\n")).unwrap();
    let verify = falsify(&["replay", "--all", "reports/two", "--sample", "3"], here);
    assert_eq!(verify.status.code(), Some(8), "{verify:?}");
    let said = text(&verify);
    assert!(said.contains("edited or replaced after the run: summary.md;") && !said.contains("a bug"), "{said}");
    let reasons = said.lines().filter(|line| line.starts_with("possible reason: ")).count();
    assert_eq!(reasons, 1, "{said}");
}

#[test]
fn a_changed_driver_differs_and_an_equal_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here, &["--out", "old"]);
    run(here, &["--out", "new", "--set", "share=0.9"]);
    let object = |arguments: &[&str]| -> serde_json::Value {
        let output = falsify(&[arguments, &["--format", "json"]].concat(), here);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let same = object(&["compare", "old/two", "old/two"]);
    assert!(same["notes"].to_string().contains("both sides are the same runs"), "{}", same["notes"]);
    for cell in same["cells"].as_array().unwrap() {
        assert_eq!(
            (&cell["common_starts"], &cell["collisions_new"], &cell["collisions_fixed"]),
            (&15.into(), &0.into(), &0.into())
        );
        assert_eq!(cell["collision_rate_difference"], 0.0);
    }
    let changed = object(&["compare", "old/two", "new/two"]);
    assert!(changed["notes"].to_string().contains("`share = 0.9` after"), "{}", changed["notes"]);
    let cells = changed["cells"].as_array().unwrap();
    let of = |policy: &str| cells.iter().filter(|cell| cell["driver"] == policy).collect::<Vec<_>>();
    assert!(of("slow").iter().all(|cell| cell["collisions_new"] == 0 && cell["collisions_fixed"] == 0));
    let differs = of("changed").iter().any(|cell| cell["collisions_new"] != 0 || cell["collisions_fixed"] != 0);
    assert!(differs, "{cells:?}");
    // Every change names one episode of each report, with the same start.
    for change in changed["failures"].as_array().unwrap() {
        let number = |side: &str| change[side]["name"].as_str().unwrap().split_once(':').unwrap().1.to_string();
        assert_eq!(number("before"), number("after"));
    }
    // It is faster, and so are collisions of both; some are no fault any more for that, which is no improvement.
    let changes = changed["failures"].as_array().unwrap();
    for change in changes {
        let speed = |side: &str| change[side]["collision"]["impact_speed_mps"].as_f64();
        let is_faster = speed("after").zip(speed("before")).is_some_and(|(after, before)| after >= before + 1.0);
        assert_eq!(is_faster, change["change"] == "worse", "{change}");
    }
    let single = |row: &&serde_json::Value| row["pedestrian"] != "all untrained";
    let worse: u64 = cells.iter().filter(single).map(|row| row["collisions_worse"].as_u64().unwrap()).sum();
    let listed = changes.iter().filter(|change| change["change"] == "worse").count();
    assert!(worse > 0 && worse == listed as u64, "{worse} {listed}");
    let answer = |other: &str| {
        let shown = text(&falsify(&["compare", "old/two", other], here));
        let answers = [
            "Nothing changed: ",
            "The driver after is worse than the driver before: more ",
            "No difference in faults or collisions",
        ];
        answers.into_iter().filter(|answer| shown.contains(answer)).collect::<Vec<_>>()
    };
    assert_eq!(answer("old/two"), ["Nothing changed: "]);
    assert_eq!(answer("new/two"), ["No difference in faults or collisions"], "of 15 starts");
    let shown = text(&falsify(&["compare", "old/two", "new/two"], here));
    for part in [format!(" new, {worse} worse, ").as_str(), "have a milder verdict: ", "p decides: "] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    assert!(of("slow").iter().all(|cell| cell["collisions_worse"] == 0 && cell["worse_rate_p_holm"] == 1.0));
    let drivers = object(&["compare", "new/two", "--drivers", "slow", "changed"]);
    let pairs = drivers["cells"].as_array().unwrap();
    assert!(pairs.iter().all(|cell| cell["driver"] == "slow" && cell["other_driver"] == "changed"), "{pairs:?}");

    // Searches are compared over the starts that both tried.
    let search = |object: &serde_json::Value, policy: &str| {
        let searches = object["searches"].as_array().unwrap();
        searches.iter().find(|search| search["driver"] == policy).unwrap().clone()
    };
    for policy in ["slow", "changed"] {
        let equal = search(&same, policy);
        assert!(equal["tried_starts"].as_u64().unwrap() > 3, "{equal}");
        assert!(equal["failed_starts_same"].as_u64().unwrap() > 0, "{equal}");
        assert_eq!((&equal["failed_starts_new"], &equal["failed_starts_fixed"]), (&0.into(), &0.into()), "{equal}");
    }
    assert_eq!(search(&changed, "slow")["failed_starts_new"], 0);
    let own = search(&changed, "changed");
    let number = |part: &str| own[part].as_u64().unwrap();
    assert!(number("failed_starts_new") + number("failed_starts_fixed") > 0, "{own}");
    assert_eq!(search(&drivers, "slow")["other_driver"], "changed");
    for start in changed["starts"].as_array().unwrap() {
        assert!(start["before"]["name"].is_string() || start["after"]["name"].is_string(), "{start}");
    }

    let gate =
        |condition: &str| falsify(&["compare", "old/two", "new/two", "--fail-if", condition], here).status.code();
    assert_eq!(gate("common_starts >= 15"), Some(7));
    assert_eq!(gate("common_starts > 15"), Some(0));
    assert_eq!(gate("fault_rate_p_holm < 0.05 and fault_rate_difference > 0"), Some(0), "fewer collisions are faults");
    assert_eq!(gate("collisions_worse > 0"), Some(7));
    assert_eq!(gate("collisions_worse > 0 and driver == slow"), Some(0));
    assert_eq!(gate("failed_starts_worse > 1000"), Some(0));
    assert_eq!(gate("tried_starts > 0"), Some(7));
    assert_eq!(gate("tried_starts > 1000"), Some(0));
    assert_eq!(gate("tried_starts > 0 and falsifier == none_such"), Some(2), "it speaks of nothing");
    assert_eq!(gate("common_start > 15"), Some(2), "no such column");
    assert_eq!(gate("common_starts > 15 and driver == none_such"), Some(2), "it speaks of nothing");
    let baseline = ["run", "two.scn", "--out", "new", "--set", "share=0.9", "--baseline", "old", "--fail-if"];
    let worse = "collisions_worse > 0";
    let blocked = falsify(&[&baseline[..], &[worse]].concat(), here);
    assert_eq!(blocked.status.code(), Some(7), "{blocked:?}");
    let page = falsify(&["compare", "old/two", "new/two", "--page", "diff.html"], here);
    assert_eq!(page.status.code(), Some(0), "{page:?}");
    let page = std::fs::read_to_string(here.join("diff.html")).unwrap();
    assert!(page.matches("class=\"player\"").count() >= 2 && !page.contains("src="), "both episodes can be played");
}

#[test]
fn reports_without_a_common_start_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here, &["--out", "one"]);
    run(here, &["--out", "other", "--seed", "2"]);
    let refused = falsify(&["compare", "one/two", "other/two"], here);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(text(&refused).contains("the seeds are 1 and 2"), "{refused:?}");
    let unknown = falsify(&["compare", "one/two", "--drivers", "slow", "fast"], here);
    assert!(text(&unknown).contains("no evaluated episodes of a driver `fast`; it has changed, slow"), "{unknown:?}");
}

#[test]
fn the_row_of_all_untrained_controllers_leaves_out_trained_ones() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let scenario = SCENARIO
        .replace(
            "campaign two {",
            "training short = ppo(steps: 600, environments: 2)\ncampaign two {\n  training: short",
        )
        .replace("evaluate {", "train { towns: [harbour] drivers: [slow] rewards: [r1] runs: 2 }\n  evaluate {")
        .replace("[random, intercept]", "[trained, random, intercept]");
    std::fs::write(here.join("two.scn"), scenario).unwrap();
    let output = falsify(&["run", "two.scn"], here);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let compared = ["compare", "reports/two", "--drivers", "slow", "changed", "--format", "json"];
    let object: serde_json::Value = serde_json::from_slice(&falsify(&compared, here).stdout).unwrap();
    let rows = object["cells"].as_array().unwrap();
    let sum = |key: &str, is: fn(&str) -> bool| -> u64 {
        let chosen = rows.iter().filter(|row| is(row["pedestrian"].as_str().unwrap()));
        chosen.map(|row| row[key].as_u64().unwrap()).sum()
    };
    assert!(sum("runs", |controller| controller == "trained") > 0, "{object}");
    for key in ["runs", "differing_episodes"] {
        let untrained = sum(key, |controller| ["random", "intercept"].contains(&controller));
        assert_eq!(sum(key, |controller| controller == "all untrained"), untrained, "{key}: {object}");
    }
}

#[test]
fn seeds_are_pooled_and_stop_at_the_first_report_in_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
                spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }\nepisode short { ticks: 240  hold: 10 }\n\
                campaign c {\n  vehicle: model3  body: pursuer  spawn: near  episode: short\n\
                evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random, intercept]  episodes: 40 }\n}\n";
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    let output = falsify(&["run", "c.scn", "--seeds", "1..4"], folder.path());
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{said}");
    let overview = std::fs::read_to_string(folder.path().join("reports/overview.csv")).unwrap();
    assert_eq!(overview.lines().count(), 1 + 4 * 2, "a row for each seed and controller");
    assert!(overview.lines().next().unwrap().ends_with(",seed"), "{overview}");
    // The mean of the four seeds stands in the terminal.
    let column = |name: &str| overview.lines().next().unwrap().split(',').position(|each| each == name).unwrap();
    let rows = overview.lines().filter(|line| line.contains(",intercept,"));
    let rates: Vec<f64> = rows.map(|row| row.split(',').nth(column("fault_rate")).unwrap().parse().unwrap()).collect();
    let mean = format!("{:.3}", rates.iter().sum::<f64>() / 4.0);
    let shown = said.lines().find(|line| line.contains("blind") && line.contains("intercept   ")).unwrap();
    assert!(shown.contains(&mean), "{mean} in {shown}");
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(notes.contains("seed 2, 2 of 4"), "{notes}");
    let page = std::fs::read_to_string(folder.path().join("reports/overview.html")).unwrap();
    assert!(page.contains("collision, difference"), "all figures are on the page");
    // One seed alone has the same report.
    let alone = falsify(&["run", "c.scn", "--seed", "3", "--out", "alone"], folder.path());
    assert!(alone.status.success());
    let episodes = |place: &str| std::fs::read(folder.path().join(place).join("episodes.csv")).unwrap();
    assert_eq!(episodes("reports/c-seed-3"), episodes("alone/c"));
    // The same call does nothing again, and a longer one adds seeds.
    let again = falsify(&["run", "c.scn", "--seeds", "1..5"], folder.path());
    assert!(again.status.success(), "{again:?}");
    for wrong in ["3..1", "2", "1..2000000", "a..b"] {
        assert_eq!(falsify(&["run", "c.scn", "--seeds", wrong], folder.path()).status.code(), Some(2), "{wrong}");
    }
    let text = text.replace("[blind]", "[idm]");
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    let output = falsify(&["run", "c.scn", "--seeds", "4..6"], folder.path());
    assert_eq!(output.status.code(), Some(2), "seed 4 has a report of another scenario");
    assert!(!folder.path().join("reports/c-seed-6").exists());
}

#[test]
fn fixed_cases_are_one_run_at_all_seeds() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\n\
                campaign cases {\n  vehicle: model3  body: adult_target  spawn: cpfa  episode: protocol_test\n\
                evaluate { towns: [test_track]  drivers: [blind]  pedestrians: [scripted, random]  episodes: 6 }\n}\n";
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    let output = falsify(&["run", "c.scn", "--seeds", "1..4"], folder.path());
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    let shown = said.lines().find(|line| line.contains("blind") && line.contains("scripted")).unwrap();
    assert!(!shown.contains(['±', '(']), "no spread: {shown}");
}
