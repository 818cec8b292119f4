//! Exit codes and messages: bad input gets one clear message and loses no data.

use std::path::Path;

use crate::program::{command, error, falsify};
use needs::needs;

/// A campaign that runs in a fraction of a second.
fn campaign() -> String {
    let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
    format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\nimport \"{0}/towns.scn\"\n\
         campaign tiny {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: ppo_paper\n\
         train {{ towns: [harbour] drivers: [behavior] rewards: [r1] runs: 2 }}\n\
         evaluate {{ towns: [village] drivers: [blind] episodes: 10 }} }}\n",
        lib.display()
    )
}

#[test]
fn untrained_controllers_are_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        campaign naive { vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds\n\
        evaluate { towns: [harbour] drivers: [blind] pedestrians: [random, homing, intercept] episodes: 10 } }\n";
    std::fs::write(folder.path().join("naive.scn"), text).unwrap();
    let output = falsify(&["run", "naive.scn", "--out", "out"], folder.path());
    assert!(output.status.success(), "{}", error(&output));
    let results = std::fs::read_to_string(folder.path().join("out/naive/results.csv")).unwrap();
    let who = |row: &str| row.split(',').take(4).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = results.lines().skip(1).map(who).collect();
    assert_eq!(rows, ["random,none,\"\",\"\"", "homing,none,\"\",\"\"", "intercept,none,\"\",\"\""]);
    let summary = std::fs::read_to_string(folder.path().join("out/naive/summary.md")).unwrap();
    assert!(!summary.contains("other trainings show"), "{summary}");
}

/// An import by a path from the root and one beside it name one file, and so does a link.
#[test]
fn a_file_by_two_paths_is_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let whole = folder.path().join("a.scn");
    write("a.scn", "edition 1\nparam x: length = 1 m\n".into());
    write("b.scn", "edition 1\nimport \"a.scn\"\nparam y: length = x\n".into());
    let import = |path: &str| format!("edition 1\nimport \"{path}\"\nimport \"b.scn\"\nparam z: length = x + y\n");
    write("c.scn", import(&whole.display().to_string()));
    let checked = falsify(&["check", "c.scn"], folder.path());
    assert!(checked.status.success(), "{}", error(&checked));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&whole, folder.path().join("link.scn")).unwrap();
        write("d.scn", import("link.scn"));
        let checked = falsify(&["check", "d.scn"], folder.path());
        assert!(checked.status.success(), "{}", error(&checked));
    }
}

/// A setting may name a key that the file gives, so that is what a typo of it means.
#[test]
fn a_typo_in_a_setting_is_compared_with_keys_that_are_given() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.scn"), "edition 1\ntraining short = ppo(steps: 200)\n").unwrap();
    let checked = falsify(&["check", "a.scn", "--set", "short.step=3"], folder.path());
    assert!(error(&checked).contains("did you mean `steps`?"), "{}", error(&checked));
}

#[test]
fn no_arguments_show_the_usage() {
    let folder = tempfile::tempdir().unwrap();
    let output = falsify(&[], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("Usage"));
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["run", "check"] {
        let output = falsify(&[command, "nowhere.scn"], folder.path());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert_eq!(error(&output), "error: cannot read `nowhere.scn`: there is no such file\n");
    }
    // All missing files are named, and the errors in the other files are reported.
    std::fs::write(folder.path().join("bad.scn"), "edition 1\nrewrd r {}\n").unwrap();
    let output = falsify(&["check", "nowhere.scn", "bad.scn", "gone.scn"], folder.path());
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    for part in ["cannot read `nowhere.scn`", "cannot read `gone.scn`", "error[unknown-form]"] {
        assert!(error(&output).contains(part), "{}", error(&output));
    }
}

#[test]
fn a_folder_for_exports_that_is_named_like_a_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for out in ["mine.svg", "deep/mine.XOSC"] {
        let output = falsify(&["export", "1a2b3c4d:17", "--as", "svg", "--out", out], folder.path());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(
            error(&output).contains(&format!("--out names a folder, and `{out}` is named like a file")),
            "{output:?}"
        );
        assert!(!folder.path().join(out).exists());
    }
    // A folder that is there may have any name.
    std::fs::create_dir(folder.path().join("mine.svg")).unwrap();
    let output = falsify(&["export", "1a2b3c4d:17", "--as", "svg", "--out", "mine.svg"], folder.path());
    assert!(!error(&output).contains("--out"), "{output:?}");
}

#[test]
fn errors_in_a_scenario_are_all_shown_and_nothing_runs() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign().replace("runs: 2", "rnus: 2").replace("episodes: 10", "episodes: 10 s");
    std::fs::write(folder.path().join("bad.scn"), text).unwrap();
    let output = falsify(&["run", "bad.scn"], folder.path());
    assert_eq!(output.status.code(), Some(3));
    let said = error(&output);
    assert!(said.contains("error[unknown-key]") && said.contains("did you mean `runs`?"), "{said}");
    assert!(said.contains("error[wrong-unit]") && said.contains("2 errors found"), "{said}");
    assert!(!folder.path().join("reports").exists(), "nothing is written");
}

#[test]
fn a_map_that_is_no_map_is_an_error_of_the_scenario() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.xodr"), "<OpenDRIVE><road").unwrap();
    let text = "edition 1\ntown a = opendrive(file: \"broken.xodr\")\ntown b = opendrive(file: \"none.xodr\")\n";
    std::fs::write(folder.path().join("maps.scn"), text).unwrap();
    let output = falsify(&["check", "maps.scn"], folder.path());
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(error(&output).matches("error[unusable-map]").count(), 2, "{}", error(&output));
}

/// A scenario on `map.xodr`.
const ON_A_MAP: &str = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
town t = opendrive(file: "map.xodr")
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
episode brief { ticks: 100  hold: 10 }
campaign c {
  vehicle: model3  body: plausible  spawn: near  episode: brief
  evaluate { towns: [t]  drivers: [idm]  pedestrians: [intercept]  episodes: 4 }
}
"#;

/// A road of 400 m whose outer lane has this type and these widths.
fn map_with_lane(kind: &str, width: &str) -> String {
    format!(
        r#"<OpenDRIVE><road id="1" length="400" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="400"><line/></geometry></planView><lanes><laneSection s="0"><right><lane id="-1" type="{kind}">{width}</lane></right></laneSection></lanes></road></OpenDRIVE>"#
    )
}

#[test]
fn a_map_on_which_no_car_can_start_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drive.scn"), ON_A_MAP).unwrap();
    let road = map_with_lane("driving", r#"<width a="3.5"/>"#);
    let none = "no episode can start in `t`: the town has no driving lane outside junctions";
    for (map, reason) in [
        (map_with_lane("biking", r#"<width a="3.5"/>"#), none),
        (road.replace(r#"junction="-1""#, r#"junction="9""#), none),
        (road.replace("3.5", "1.2"), "the constraint that fails most is `lane as wide as the car`, which 0 satisfy"),
        (road.replace("3.5", "3,5"), "lane as wide as the car"),
    ] {
        std::fs::write(folder.path().join("map.xodr"), map).unwrap();
        for command in [&["check", "drive.scn"][..], &["run", "drive.scn"], &["preview", "--once", "drive.scn"]] {
            let output = falsify(command, folder.path());
            let said = error(&output) + &String::from_utf8_lossy(&output.stdout);
            assert_eq!(output.status.code(), Some(3), "{command:?}: {said}");
            assert!(said.contains(reason), "{command:?}: {said}");
        }
    }
}

#[test]
fn no_car_starts_where_its_lane_is_narrower_than_it_is() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drive.scn"), ON_A_MAP).unwrap();
    let widths = r#"<width sOffset="0" a="0"/><width sOffset="200" a="0" b="0.035"/><width sOffset="300" a="3.5"/>"#;
    std::fs::write(folder.path().join("map.xodr"), map_with_lane("driving", widths)).unwrap();
    let output = falsify(&["check", "--sample", "2000", "drive.scn"], folder.path());
    let said = String::from_utf8_lossy(&output.stdout);
    // Of 400 m the first 200 m and the 62 m in which the lane is narrower than 2.16 m have no room.
    let share = said.lines().find(|line| line.ends_with("lane as wide as the car")).expect("a share");
    let share: f64 = share.split('%').next().unwrap().trim().parse().unwrap();
    assert!((share - 34.6).abs() < 3.0, "{said}");
    let output = falsify(&["run", "drive.scn"], folder.path());
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && !said.contains("left the road"), "{said}");
}

#[test]
fn who_could_only_start_on_a_footbridge_does_not_start() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = ON_A_MAP.replace("distance: 7 m .. 40 m", "distance: 7 m .. 40 m  ground: sidewalk");
    std::fs::write(folder.path().join("drive.scn"), scenario).unwrap();
    let with_bridge = |height: &str| {
        let bridge = format!(
            r#"<road id="2" length="60" junction="-1"><planView><geometry s="0" x="150" y="-30" hdg="1.5707963267948966" length="60"><line/></geometry></planView><elevationProfile><elevation s="0" a="{height}" b="0" c="0" d="0"/></elevationProfile><lanes><laneSection s="0"><left><lane id="1" type="sidewalk"><width a="20"/></lane></left></laneSection></lanes></road></OpenDRIVE>"#
        );
        let street = map_with_lane("driving", r#"<width a="3.5"/>"#);
        std::fs::write(folder.path().join("map.xodr"), street.replace("</OpenDRIVE>", &bridge)).unwrap();
        let preview = falsify(&["preview", "map.xodr"], folder.path());
        (falsify(&["check", "drive.scn"], folder.path()), String::from_utf8_lossy(&preview.stdout).into_owned())
    };
    let (level, described) = with_bridge("0");
    assert!(level.status.success() && !described.contains("above others"), "{level:?} {described}");
    let (above, described) = with_bridge("6");
    assert_eq!(above.status.code(), Some(3), "{above:?}");
    assert!(error(&above).contains("pedestrian on the level of the car"), "{above:?}");
    assert!(described.contains("above others    1 place"), "{described}");
}

#[test]
fn what_is_about_parts_that_a_town_lacks_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let lane = map_with_lane("driving", r#"<width a="3.5"/>"#);
    let about = ON_A_MAP
        .replace("\ntown t", "\nimport \"std/requirements.scn\"\ndriver careful = aeb(crosswalks: yield)\ntown t")
        .replace("spawn: near", "spawn: near  requirements: [keeps_lane, yields_at_crosswalk, stops_at_red]")
        .replace("[idm]", "[idm, careful]");
    std::fs::write(folder.path().join("drive.scn"), about).unwrap();
    let named = |map: &str| {
        std::fs::write(folder.path().join("map.xodr"), map).unwrap();
        let output = falsify(&["check", "drive.scn"], folder.path());
        assert!(output.status.success(), "{output:?}");
        let said = error(&output);
        let of = |name: &str, part: &str| {
            said.contains(&format!("warning[never-applies]: `{name}` is about {part}, and there are none in `t`"))
        };
        [
            of("yields_at_crosswalk", "crosswalks"),
            of("careful", "crosswalks"),
            of("stops_at_red", "traffic lights"),
            of("keeps_lane", ""),
        ]
    };
    assert_eq!(named(&lane), [true, true, true, false]);
    // A marking makes no crosswalk, and both commands say so.
    let marking = r#"</lanes><signals><signal id="1" type="1000003" s="50" t="0"/></signals>"#;
    assert_eq!(named(&lane.replace("</lanes>", marking)), [true, true, true, false]);
    let [check, preview] = [["check", "drive.scn"], ["preview", "map.xodr"]].map(|args| falsify(&args, folder.path()));
    let said = "not used: 1 × crosswalk marking (signal type 1000003)";
    assert!(error(&check).contains(said) && String::from_utf8_lossy(&preview.stdout).contains(said), "{check:?}");
    let walk = r#"</lanes><objects><object id="1" type="crosswalk" s="50" t="-2" length="3" width="4"/></objects>"#;
    assert_eq!(named(&lane.replace("</lanes>", walk)), [false, false, true, false]);
    let light =
        r#"</lanes><signals><signal id="1" type="1000001" dynamic="yes" s="390" t="-4" orientation="+"/></signals>"#;
    assert_eq!(named(&lane.replace("</lanes>", light)), [true, true, false, false]);
}

#[test]
fn a_map_in_another_encoding_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let map = map_with_lane("driving", r#"<width a="3.5"/>"#);
    let utf_16: Vec<u8> = std::iter::once(0xfeff).chain(map.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    std::fs::write(folder.path().join("map.xodr"), utf_16).unwrap();
    let said = error(&falsify(&["preview", "map.xodr"], folder.path()));
    assert!(said.contains("cannot use the map `map.xodr`: it is UTF-16 text: save it as UTF-8"), "{said}");
}

#[test]
fn a_file_without_a_campaign_runs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("empty.scn"), "edition 1\n").unwrap();
    assert_eq!(falsify(&["run", "empty.scn"], folder.path()).status.code(), Some(4));
    assert_eq!(falsify(&["check", "empty.scn"], folder.path()).status.code(), Some(0));
}

#[test]
fn a_list_names_every_training_and_evaluation_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.scn"), campaign()).unwrap();
    let output = falsify(&["run", "--list", "tiny.scn"], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((text.matches("  train ").count(), text.matches("  evaluate ").count()), (2, 4), "{text}");
    assert!(!folder.path().join("reports").exists());
}

#[test]
fn a_folder_that_cannot_be_written_to_is_found_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.scn"), campaign()).unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let output = falsify(&["run", "tiny.scn", "--out", "file/reports"], folder.path());
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    assert!(error(&output).contains("cannot write to the folder `file/reports`"), "{}", error(&output));
    assert!(!error(&output).contains("trained"), "no training was begun");
}

#[test]
fn foreign_files_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.scn"), campaign()).unwrap();
    let precious = folder.path().join("reports/tiny-smoke/thesis.txt");
    std::fs::create_dir_all(precious.parent().unwrap()).unwrap();
    std::fs::write(&precious, "years of work").unwrap();
    let output = falsify(&["run", "--smoke", "tiny.scn"], folder.path());
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    assert_eq!(std::fs::read_to_string(&precious).unwrap(), "years of work");
}

#[test]
fn a_second_run_replaces_the_report_of_the_first_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.scn"), campaign()).unwrap();
    for seed in ["1", "2"] {
        let output = falsify(&["run", "--smoke", "--seed", seed, "tiny.scn"], folder.path());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
    let manifest = std::fs::read_to_string(folder.path().join("reports/tiny-smoke/manifest.toml")).unwrap();
    assert!(manifest.contains("seed = 2") && manifest.contains("complete = true"), "{manifest}");
    let names: Vec<String> = std::fs::read_dir(folder.path().join("reports"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != ".falsify")
        .collect();
    assert_eq!(names, ["tiny-smoke"]);
}

#[test]
fn a_smoke_run_leaves_the_real_report_alone_and_a_bad_file_name_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("tiny.scn"),
        campaign().replace("ppo_paper", "quick").replace("campaign", "training quick = ppo(steps: 150)\ncampaign"),
    )
    .unwrap();
    assert_eq!(falsify(&["run", "tiny.scn"], folder.path()).status.code(), Some(0));
    let summary = folder.path().join("reports/tiny/summary.md");
    let before = std::fs::read(&summary).unwrap();
    assert_eq!(falsify(&["run", "--smoke", "--seed", "9", "tiny.scn"], folder.path()).status.code(), Some(0));
    assert_eq!(std::fs::read(&summary).unwrap(), before);
    let notes = folder.path().join("reports/tiny/notes.txt");
    std::fs::write(&notes, "mine").unwrap();
    let output = falsify(&["run", "tiny.scn"], folder.path());
    assert_eq!(output.status.code(), Some(6));
    assert!(error(&output).contains("reports/tiny/notes.txt") && notes.exists(), "{}", error(&output));
}

#[test]
fn a_reward_that_may_be_no_number_is_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign()
        .replace("rewards: [r1]", "rewards: [q]")
        .replace("campaign", "reward q { on timeout => (distance - distance) / (distance - distance) }\ntraining quick = ppo(steps: 150)\ncampaign")
        .replace("ppo_paper", "quick");
    std::fs::write(folder.path().join("tiny.scn"), text).unwrap();
    let output = falsify(&["run", "tiny.scn"], folder.path());
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(error(&output).contains("error[no-value]"), "{}", error(&output));
    assert!(!folder.path().join("reports/tiny").exists(), "no finished report");
}

#[test]
fn a_byte_order_mark_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.scn"), format!("\u{feff}{}", campaign())).unwrap();
    assert_eq!(falsify(&["check", "tiny.scn"], folder.path()).status.code(), Some(0));
}

#[test]
fn a_map_takes_the_place_of_a_town() {
    let folder = tempfile::tempdir().unwrap();
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/files/odd.xodr");
    std::fs::write(folder.path().join("tiny.scn"), campaign()).unwrap();
    let village = format!("village={}", map.display());
    let output = falsify(&["check", "tiny.scn", "--map", &village], folder.path());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(error(&output).contains("warning[map-warning]"), "{}", error(&output));
    for (wrong, said) in
        [("vilage=a.xodr", "nothing uses"), ("village", "write TOWN=FILE"), ("village=no.xodr", "unusable-map")]
    {
        let output = falsify(&["check", "tiny.scn", "--map", wrong], folder.path());
        assert_ne!(output.status.code(), Some(0));
        assert!(error(&output).contains(said), "{wrong}: {}", error(&output));
    }
}

#[test]
fn colour_is_off_unless_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.scn"), "edition 1\nrewrd a {}\n").unwrap();
    assert!(!error(&falsify(&["check", "bad.scn"], folder.path())).contains('\u{1b}'));
    assert!(error(&falsify(&["check", "--color", "always", "bad.scn"], folder.path())).contains('\u{1b}'));
}

#[test]
fn completions_know_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let output = falsify(&["completions", shell], folder.path());
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && text.contains("check") && text.contains("smoke"), "{shell}");
        // Between quotes of a description others would end it.
        let is_told = shell == "bash" || text.contains("The experiment of the paper");
        assert!(is_told && !text.contains("\"Suicidal"), "{shell}");
    }
}

#[needs(program = "fish")]
#[test]
fn completions_of_fish_list_templates() {
    let folder = tempfile::tempdir().unwrap();
    let script = falsify(&["completions", "fish"], folder.path()).stdout;
    std::fs::write(folder.path().join("falsify.fish"), script).unwrap();
    let ask = "source falsify.fish; complete -C 'falsify new --template '";
    let output = std::process::Command::new("fish").args(["-c", ask]).current_dir(folder.path()).output().unwrap();
    let listed = String::from_utf8(output.stdout).unwrap();
    assert!(output.stderr.is_empty() && listed.contains("paper\tThe experiment of the paper"), "{listed}");
}

#[test]
fn settings_change_values_and_reach_the_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign().replace("runs: 2", "runs: tries").replace(
        "campaign tiny",
        "/// How often.\nparam tries: integer = 2\n/// Who is asked?\nparam idle: integer = 2\ncampaign tiny",
    );
    std::fs::write(folder.path().join("tiny.scn"), text).unwrap();
    let listed = falsify(&["run", "--list", "--set", "tiny.train.runs=1", "tiny.scn"], folder.path());
    let text = String::from_utf8(listed.stdout).unwrap();
    assert_eq!(text.matches("  train    r1").count(), 1, "{text}");
    let output = falsify(&["run", "--smoke", "--set", "ahead.distance = 8 m .. 9 m", "tiny.scn"], folder.path());
    assert!(output.status.success(), "{output:?}");
    let manifest = std::fs::read_to_string(folder.path().join("reports/tiny-smoke/manifest.toml")).unwrap();
    assert!(manifest.contains("settings = [\"ahead.distance = 8 m .. 9 m\"]"), "{manifest}");
    let summary = std::fs::read_to_string(folder.path().join("reports/tiny-smoke/summary.md")).unwrap();
    assert!(summary.contains("- reward **r1**: Equation R1: any hit pays."), "{summary}");
    assert!(summary.contains("- param **tries**: How often."), "{summary}");
    assert!(!summary.contains("**r2**") && !summary.contains("**idle**"), "what is not used is not spoken of");
    let wrong = falsify(&["check", "--set", "ahead.distance=8 .. 9 m", "tiny.scn"], folder.path());
    assert_eq!(wrong.status.code(), Some(3));
    assert!(error(&wrong).contains("a length needs a unit"), "{}", error(&wrong));
}

#[test]
fn a_matrix_makes_a_report_of_every_combination() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign()
        .replace("training: ppo_paper\n", "training: ppo_paper matrix { far: [10 m, 20 m] }\n")
        .replace("campaign tiny", "param far: length = 30 m\nspawn short { distance: 7 m .. far }\ncampaign tiny");
    std::fs::write(folder.path().join("tiny.scn"), text.replace("spawn: ahead", "spawn: short")).unwrap();
    let output = falsify(&["run", "--list", "tiny.scn"], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("campaign tiny-far=10m\n") && text.contains("campaign tiny-far=20m\n"), "{text}");
}

#[test]
fn a_sample_of_starts_tells_what_each_constraint_rejects() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign().replace(
        "campaign tiny",
        "spawn picky { sight: visible require: aside > 5 m or distance < 9 m }\ncampaign tiny",
    );
    std::fs::write(folder.path().join("tiny.scn"), text.replace("spawn: ahead", "spawn: picky")).unwrap();
    let output = falsify(&["check", "--sample", "200", "tiny.scn"], folder.path());
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    for part in
        ["picky in harbour: ", " of 200 starts accepted", "clearance: 0.5 m", "require: aside > 5 m or distance < 9 m"]
    {
        assert!(text.contains(part), "{text}");
    }
    let picture = std::fs::read_to_string(folder.path().join("spawn-tiny-picky-village.svg")).unwrap();
    assert!(picture.matches("class=\"pedestrian\"").count() > 20);
}

#[test]
fn a_setting_takes_the_place_of_a_matrix() {
    let folder = tempfile::tempdir().unwrap();
    let text = campaign()
        .replace("training: ppo_paper\n", "training: ppo_paper matrix { far: [10 m, 20 m] }\n")
        .replace("campaign tiny", "param far: length = 30 m\nspawn short { distance: 7 m .. far }\ncampaign tiny");
    std::fs::write(folder.path().join("tiny.scn"), text.replace("spawn: ahead", "spawn: short")).unwrap();
    let output = falsify(&["run", "--list", "--set", "far=15 m", "tiny.scn"], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("campaign tiny\n") && !text.contains("campaign tiny-"), "{text}");
}

#[test]
#[cfg(target_os = "linux")]
fn output_that_is_lost_is_noticed() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = command();
    let output = command.args(["explain", "driver"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(6), "{output:?}");
}

#[test]
fn check_fix_applies_repairs_without_an_alternative() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("typo.scn");
    let text =
        "edition 1\ndriver p = idm(time_hedway: 2 s)\nepisode e { tiks: 600 }\nspawn s { distance: 7 .. 30 m }\n";
    std::fs::write(&file, text).unwrap();
    let output = falsify(&["check", "--fix", "typo.scn"], folder.path());
    let repaired = std::fs::read_to_string(&file).unwrap();
    assert!(repaired.contains("idm(time_headway: 2 s)"), "{repaired}");
    assert!(repaired.contains("ticks: 600") && repaired.contains("distance: 7 .. 30 m"), "{repaired}");
    assert!(error(&output).contains("repaired in typo.scn"), "{output:?}");
    // What is right stays as it is.
    let before = std::fs::read(&file).unwrap();
    falsify(&["check", "--fix", "typo.scn"], folder.path());
    assert_eq!(std::fs::read(&file).unwrap(), before);
}

#[test]
fn rewards_that_pay_nothing_and_speeds_that_no_car_reaches_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let warns = |requirement: &str, limit: &str, start: &str, pay: &str| {
        let text = format!(
            "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/paper.scn\"\n\
             town t {{ street a {{ through: [(0 m, 0 m), (400 m, 0 m)]  {limit} }} }}\n\
             spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m  {start} }}\nepisode brief {{ ticks: 100  hold: 10 }}\n\
             requirement slow = {requirement}\nreward mine {{ {pay} }}\n\
             campaign c {{ vehicle: model3  body: suicidal  spawn: near  episode: brief  training: ppo_paper  requirements: [slow]\n\
             train {{ towns: [t]  drivers: [idm]  rewards: [mine]  runs: 1 }} }}\n"
        );
        std::fs::write(folder.path().join("my.scn"), text).unwrap();
        let output = falsify(&["check", "my.scn"], folder.path());
        assert!(output.status.success(), "{output:?}");
        let said = error(&output);
        ["warning[unreachable-speed]", "warning[never-positive]"].map(|code| said.contains(code))
    };
    let pays = "on touch => 1  on step => -0.01 * distance / 1 m";
    assert_eq!(warns("always(gap < 1 m implies ego_speed < 20 m/s)", "", "", pays), [true, false]);
    assert_eq!(warns("always(gap < 1 m implies ego_speed < 20 km/h)", "", "", pays), [false, false]);
    assert_eq!(warns("always(gap < 1 m implies ego_speed < 20 m/s)", "speed_limit: 60 km/h", "", pays), [false, false]);
    assert_eq!(
        warns("always(gap < 1 m implies ego_speed < 20 m/s)", "", "ego_speed: 18 m/s .. 20 m/s", pays),
        [false, false]
    );
    let never = "on touch(fault) => 0  on touch => -1  on step => -0.01 * distance / 1 m";
    assert_eq!(warns("always(gap > 0.5 m)", "", "", never), [false, true]);
    assert_eq!(
        warns("always(gap > 0.5 m)", "", "", "on step => -1  on timeout => min(3, distance / 1 m)"),
        [false, false]
    );
}

/// Methods of a search have rewards, too; a `goal` takes their place.
#[test]
fn a_reward_of_a_search_that_pays_nothing_is_named_once() {
    let folder = tempfile::tempdir().unwrap();
    let warned = |method: &str, pay: &str, more: &str| {
        let text = format!(
            "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport harbour from \"std/towns.scn\"\n\
             spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}\nepisode brief {{ ticks: 100  hold: 10 }}\n\
             requirement far = always(gap > 0.5 m)\nreward mine {{ {pay} }}\nmethod one = {method}\nmethod two = {method}\n\
             campaign c {{ vehicle: model3  body: plausible  spawn: near  episode: brief  requirements: [far]\n\
             search {{ towns: [harbour]  drivers: [idm]  methods: [one, two]  budget: 10_000  {more} }} }}\n"
        );
        std::fs::write(folder.path().join("my.scn"), text).unwrap();
        let output = falsify(&["check", "my.scn"], folder.path());
        assert!(output.status.success(), "{output:?}");
        error(&output).matches("warning[never-positive]").count()
    };
    for method in ["archive(reward: mine)", "mcts(reward: mine)", "cem(reward: mine)"] {
        assert_eq!(warned(method, "on touch(fault) => -1  on touch => 0", ""), 1, "{method}");
        assert_eq!(warned(method, "on touch(fault) => 1", ""), 0, "{method}");
    }
    assert_eq!(warned("archive(reward: mine)", "on touch(fault) => -1", "goal: far"), 0);
    // A miss that costs more than a touch is an aim, too, as in adaptive stress testing.
    for (pay, warnings) in [
        ("on timeout => -300 - miss_distance in m  on lost => -300", 0),
        ("on timeout => -300", 1),
        ("on touch => -400  on timeout => -300  on lost => -300", 1),
    ] {
        assert_eq!(warned("archive(reward: mine)", pay, ""), warnings, "{pay}");
    }
}

#[test]
fn files_with_a_campaign_of_one_name_are_checked_together_and_not_run_together() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.scn", "b.scn"] {
        let text = ON_A_MAP.replace("town t = opendrive(file: \"map.xodr\")", "import harbour from \"std/towns.scn\"");
        std::fs::write(folder.path().join(name), text.replace("[t]", "[harbour]")).unwrap();
    }
    let checked = falsify(&["check", "a.scn", "b.scn"], folder.path());
    assert!(checked.status.success() && error(&checked).is_empty(), "{checked:?}");
    let run = falsify(&["run", "--smoke", "a.scn", "b.scn"], folder.path());
    assert!(!run.status.success() && error(&run).contains("campaign `c`"), "{run:?}");
    assert!(!folder.path().join("reports").exists());
}
