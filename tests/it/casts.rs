//! A campaign with several pedestrians and cars, from its file to a page, and back from the name of a failure.

use std::path::Path;

use crate::program::{falsify, said};

/// The scenario of the page of the book about casts.
fn scenario() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/how-to/casts.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("```scn\n").unwrap();
    rest.split_once("```").unwrap().0.replace("episodes: 200", "episodes: 40")
}

#[test]
fn a_cast_runs_to_a_page_and_a_failure_names_the_actors_that_it_needs() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("family.scn"), scenario()).unwrap();
    let run = falsify(&["run", "family.scn"], here);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let report = here.join("reports/family");
    let page = std::fs::read_to_string(report.join("report.html")).unwrap();
    for name in ["\"friend\"", "\"van\"", "\"follower\"", "\"crowd\""] {
        assert!(page.contains(name), "the page shows {name}");
    }
    let episodes = std::fs::read_to_string(report.join("episodes.csv")).unwrap();
    let hit = episodes.lines().skip(1).find(|line| line.contains(",collision,")).expect("somebody is hit");
    let mut cells = hit.split(',');
    let run_id = cells.next().unwrap();
    let head: Vec<&str> = episodes.lines().next().unwrap().split(',').collect();
    let place = head.iter().position(|name| *name == "episode").unwrap();
    let name = format!("{run_id}:{}", hit.split(',').nth(place).unwrap());
    let actors = std::fs::read_to_string(report.join("actors.csv")).unwrap();
    let rows = actors.lines().filter(|line| line.starts_with(&name.replace(':', ","))).count();
    assert_eq!(rows, 8, "each actor of {name} has a row: {actors}");
    assert!(actors.lines().any(|line| line.contains(",vehicle,0,ego,") && line.ends_with(",true,")), "{actors}");
    for text in [&page, &std::fs::read_to_string(report.join("summary.md")).unwrap()] {
        assert!(text.contains("need two or more actors"), "{text}");
    }
    let listed = said(&falsify(&["failures", "reports/family", "--format", "json"], here));
    assert!(listed.lines().all(|line| line.contains("\"needs\":\"")), "{listed}");
    let again = falsify(&["replay", &name], here);
    let text = said(&again);
    assert!(again.status.success() && text.contains("as in the report, in every column"), "{text}");
    assert!(text.contains("the pedestrian is `") && text.contains("It needs `"), "{text}");
    // Files for other programs name the roles.
    for (format, text) in [
        ("xosc-1.3", "ScenarioObject name=\"crowd_3\""),
        ("commonroad", "<!-- follower -->"),
        ("osi", "friend"),
        ("carla", "\\\"name\\\":\\\"van\\\""),
    ] {
        assert!(falsify(&["export", &name, "--as", format, "--out", format], here).status.success(), "{format}");
        let files =
            std::fs::read_dir(here.join(format)).unwrap().map(|file| std::fs::read(file.unwrap().path()).unwrap());
        let is_in = |bytes: &Vec<u8>| bytes.windows(text.len()).any(|part| part == text.as_bytes());
        assert!(files.into_iter().any(|bytes| is_in(&bytes)), "{format} names {text}");
    }
    // Each of them has a track of the whole episode.
    let files = std::fs::read_dir(here.join("xosc-1.3")).unwrap().map(|file| file.unwrap().path());
    let file = files.into_iter().find(|path| path.extension().is_some_and(|end| end == "xosc")).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    let named =
        |what: &str| -> Vec<&str> { text.split(what).skip(1).map(|rest| rest.split_once('"').unwrap().0).collect() };
    assert_eq!(named("Trajectory name=\"track_"), named("ScenarioObject name=\""));
    let tracks: Vec<&str> =
        text.split("<Trajectory ").skip(1).map(|rest| rest.split_once("</Trajectory>").unwrap().0).collect();
    let vertices = |track: &&str| track.matches("<Vertex ").count();
    let places = tracks.iter().map(|track| track.split_once("<WorldPosition ").unwrap().1.split_once("/>").unwrap().0);
    assert_eq!((tracks.len(), places.collect::<std::collections::BTreeSet<_>>().len()), (8, 8));
    assert!(tracks.iter().all(|track| vertices(track) > 2 && vertices(track) == vertices(&tracks[0])), "{text}");
    let json = said(&falsify(&["replay", &name, "--json"], here));
    let object: serde_json::Value = serde_json::from_str(&json).unwrap();
    let roles: Vec<&str> =
        object["actors"].as_array().unwrap().iter().map(|actor| actor["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["van", "follower", "child", "friend", "crowd", "crowd", "crowd"]);
}

const VAN: &str = "edition 1
import \"std/drivers.scn\"
import \"std/paper.scn\"
town street { street main { through: [(0 m, 0 m), (400 m, 0 m)]  speed_limit: 50 km/h } }
spawn kerb { ego_poses: [(100 m, -1.75 m, 0 deg)]  ego_speed: 8 m/s  bearing: -20 deg .. -8 deg  distance: 18 m .. 28 m }
campaign van {
  vehicle: model3  body: suicidal  spawn: kerb  episode: thirty_seconds
  cast { CAST }
  REQUIRED
  evaluate { towns: [street]  drivers: [idm()]  pedestrians: [intercept]  episodes: 60 }
}
";

/// A parked car of one episode is no obstacle of the next.
#[test]
fn a_start_does_not_depend_on_the_episodes_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = VAN
        .replace("CAST", "child: pedestrian()  van: vehicle(distance: 8 m .. 20 m, aside: -3.2 m)")
        .replace("REQUIRED", "");
    std::fs::write(folder.path().join("van.scn"), text).unwrap();
    let run = falsify(&["run", "van.scn"], folder.path());
    assert!(run.status.success(), "{run:?}");
    let replayed = falsify(&["replay", "--all", "reports/van"], folder.path());
    assert!(said(&replayed).contains("60 repeated, 60 equal"), "{}", said(&replayed));
}

#[test]
fn casts_that_cannot_be_placed_or_named_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (cast, required, why) in [
        (
            "a: vehicle(driver: idm(), behind: ego)  b: vehicle(driver: idm(), behind: ego)",
            "",
            "a second car behind the ego",
        ),
        (
            "a: vehicle(driver: idm(), behind: ego)  b: pedestrian(moved_by: natural, beside: a)  c: pedestrian()",
            "",
            "gets its place when the episode starts",
        ),
        ("ego: pedestrian()", "", "is a word of casts"),
        ("a: pedestrian()", "training: ppo_paper", "so `credit` needs `policies`"),
        ("a: pedestrian()", "requirements: [me]", "ego to itself"),
    ] {
        let mut text = VAN.replace("CAST", cast).replace("REQUIRED", required);
        text = text.replace("ppo_paper", "ppo(credit: own)");
        if required.contains("requirements") {
            text = text.replace("campaign van", "requirement me = always(ego.gap > 1 m)\ncampaign van");
        }
        std::fs::write(folder.path().join("van.scn"), text).unwrap();
        let output = falsify(&["check", "van.scn"], folder.path());
        let text = String::from_utf8_lossy(&output.stderr).into_owned() + &said(&output);
        assert_eq!(output.status.code(), Some(3), "{cast}: {text}");
        assert!(text.contains(why), "{cast}: {text}");
    }
}

#[test]
fn roles_learn_policies_of_their_own_and_walk_by_them_in_evaluations_and_in_other_casts() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let text = VAN
        .replace("campaign van", "body small { shape: child  others: 1 }\ncampaign van")
        .replace("CAST", "child: pedestrian(body: small)  pair: pedestrian(count: 2)")
        .replace("REQUIRED", "training: ppo(steps: 300, policies: each, credit: own, hidden: [8])")
        .replace("evaluate", "train { towns: [street]  drivers: [idm()]  rewards: [r1]  runs: 1 }\n  evaluate")
        .replace("[intercept]", "[trained, stochastic, untrained]");
    std::fs::write(here.join("van.scn"), &text).unwrap();
    let run = falsify(&["run", "van.scn"], here);
    assert!(run.status.success(), "{run:?}");
    let replayed = falsify(&["replay", "--all", "reports/van", "--trainings"], here);
    let said_of = said(&replayed);
    assert!(said_of.contains("180 repeated, 180 equal") && replayed.status.success(), "{said_of}");
    // Each role has files of its own, and one of them can move another role.
    let networks = here.join("reports/van/pedestrians");
    let mut files: Vec<String> =
        std::fs::read_dir(&networks).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    let ends: Vec<&str> = files.iter().map(|file| file.rsplit_once("-0-").unwrap().1).collect();
    assert_eq!(ends, ["child.onnx", "child.safetensors", "pair.onnx", "pair.safetensors"]);
    let model = networks.join(&files[2]).display().to_string();
    let text = VAN
        .replace("campaign van", &format!("pedestrian learnt = onnx(model: \"{model}\")\ncampaign van"))
        .replace("CAST", "child: pedestrian()  pair: pedestrian(moved_by: learnt, count: 2)")
        .replace("REQUIRED", "");
    std::fs::write(here.join("other.scn"), text).unwrap();
    let run = falsify(&["run", "other.scn", "--out", "other"], here);
    assert!(run.status.success(), "{run:?}");
}
