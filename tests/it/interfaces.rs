//! What is documented of states and actions is what controllers get and give.

use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::{Draw, Observer, Trace, carry_out};

use crate::program::{error, falsify, said};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
body tested { FRAMES }
episode short { ticks: 60  hold: 7 }
campaign all {
  vehicle: model3  body: tested  spawn: ahead  episode: short
  evaluate { towns: [harbour] drivers: [idm] pedestrians: [random] }
}
"#;

#[test]
fn a_trace_has_the_states_and_actions_of_the_episode_in_every_frame() {
    for frames in [
        "",
        "observation_frame: initial  action_frame: initial  observed_speed: relative",
        "observation_frame: line_of_sight  action_frame: line_of_sight  action_scaling: unit",
        "observation_frame: world  action_frame: world  observation_scaling: unit",
        "action_frame: meeting  heading: -0.5 rad .. 0.5 rad",
    ] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/interfaces.scn");
        let text = SCENARIO.replace("FRAMES", frames);
        let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
        let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default());
        let compiled = compiled.unwrap();
        let plan = compiled.plan.unwrap_or_else(|| panic!("{frames}: {:?}", compiled.diagnostics));
        let scenario = plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone();
        let mut simulation = scenario.simulation();
        let (mut state, mut trace) = ([0.0; 4], Trace::new(&scenario));
        simulation.start(Draw::new(&Seed::root(5), 0));
        trace.begin(&simulation.scene());
        let bounds = scenario.cast.action_bounds();
        let (mut taken, mut commands) = (Vec::new(), simulation.scene().commands().to_vec());
        loop {
            let share = [0.2, 0.9, 0.45][taken.len() % 3];
            let action = [0, 1].map(|part: usize| bounds[part].0 + share * (bounds[part].1 - bounds[part].0));
            simulation.scene().write_state(&mut state);
            simulation.scene().write_commands(&action, &mut commands);
            taken.push((state, action));
            if carry_out(&mut *simulation, &commands, &mut trace).done() {
                break;
            }
        }
        let pair = trace.main_pair(&scenario);
        let decided: Vec<usize> = (0..pair.len()).filter(|tick| pair.decision(*tick).is_some()).collect();
        assert_eq!(decided, (0..taken.len()).map(|number| 7 * number).collect::<Vec<_>>(), "{frames}");
        for (tick, (state, action)) in decided.into_iter().zip(taken) {
            let frame = pair.frame(tick);
            assert_eq!(pair.state(&frame), state, "{frames}, tick {tick}");
            let told = pair.action(&frame, pair.decision(tick).unwrap());
            for (one, other) in told.into_iter().zip(action) {
                assert!((one - other).abs() < 1e-9, "{frames}, tick {tick}: {told:?} and {action:?}");
            }
        }
    }
}

#[test]
fn networks_and_explain_tell_the_names_units_and_bounds_of_states_and_actions() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let text = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
training quick = ppo(steps: 40, steps_per_update: 20, epochs: 1, hidden: [8])
body sighted { observation_frame: line_of_sight  speed: 0.5 m/s .. 2.5 m/s }
campaign told {
  vehicle: model3  body: sighted  spawn: ahead  episode: thirty_seconds  training: quick
  train { towns: [harbour] drivers: [blind] rewards: [r1] runs: 1 }
}
"#;
    std::fs::write(here.join("told.scn"), text).unwrap();
    let output = falsify(&["run", "told.scn"], here);
    assert!(output.status.success(), "{}", error(&output));
    let networks = here.join("reports/told/pedestrians");
    let read = |extension: &str| {
        let files = std::fs::read_dir(&networks).unwrap().map(|file| file.unwrap().path());
        let file = files.into_iter().find(|path| path.extension().is_some_and(|found| found == extension)).unwrap();
        std::fs::read(file).unwrap()
    };
    let bytes = read("safetensors");
    let length = u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
    let header: serde_json::Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let metadata = &header["__metadata__"];
    let part = |name: &str| -> serde_json::Value { serde_json::from_str(metadata[name].as_str().unwrap()).unwrap() };
    let names = |name: &str| -> Vec<String> {
        part(name).as_array().unwrap().iter().map(|each| each["name"].as_str().unwrap().to_string()).collect()
    };
    assert_eq!(names("state"), ["heading", "distance", "relative_heading", "speed"]);
    assert_eq!(names("action"), ["heading", "speed"]);
    let speed = &part("action")[1];
    assert_eq!(
        (speed["unit"].as_str(), speed["low"].as_f64(), speed["high"].as_f64()),
        (Some("m/s"), Some(0.5), Some(2.5))
    );
    assert_eq!(
        (metadata["state_frame"].as_str(), metadata["action_frame"].as_str()),
        (Some("line_of_sight"), Some("heading"))
    );
    let number = |name: &str| metadata[name].as_str().unwrap().parse::<f64>().unwrap();
    assert!((number("decision_s") - number("tick_s") * number("decision_ticks")).abs() < 1e-12);
    // The ONNX file has the same entries.
    let onnx = String::from_utf8_lossy(&read("onnx")).into_owned();
    for name in ["state", "action", "state_frame", "decision_s"] {
        assert!(onnx.contains(metadata[name].as_str().unwrap()), "{name}");
    }

    // In another body, or at another time of a decision, it is another pedestrian, and a check says so.
    let file = std::fs::read_dir(&networks).unwrap().map(|file| file.unwrap().path());
    let file = file.into_iter().find(|path| path.extension().is_some_and(|found| found == "onnx")).unwrap();
    let checked = |hold: u32, fastest: &str| {
        let model =
            format!("edition 1\nimport \"std/paper.scn\"\npedestrian mine = onnx(model: \"{}\")\n", file.display());
        let text = text.replace("edition 1\nimport \"std/paper.scn\"\n", &model).replace("2.5 m/s", fastest);
        let evaluated = text.lines().filter(|line| !line.starts_with("training") && !line.contains("train {"));
        let evaluated = evaluated.collect::<Vec<_>>().join("\n").replace("  training: quick", "");
        let block = "  evaluate { towns: [harbour, village] drivers: [blind] pedestrians: [mine] episodes: 2 }\n}";
        let episode = format!("episode short {{ ticks: 200  hold: {hold} }}\ncampaign");
        let evaluated = evaluated.trim_end().trim_end_matches('}').replace("episode: thirty_seconds", "episode: short");
        std::fs::write(here.join("walked.scn"), evaluated.replace("campaign", &episode) + block).unwrap();
        error(&falsify(&["check", "walked.scn"], here))
    };
    assert!(!checked(20, "2.5 m/s").contains("trained otherwise"), "{}", checked(20, "2.5 m/s"));
    let other = checked(10, "1.5 m/s");
    assert!(other.contains("it decided every 1 s, and here every 0.5 s"), "{other}");
    assert!(other.contains("at 0.50 to 2.50 m/s") && other.contains("here it is"), "{other}");
    assert_eq!(other.matches("trained otherwise").count(), 1, "{other}");

    for (topic, all) in [("state", names("state")), ("action", names("action"))] {
        let page = said(&falsify(&["explain", topic], here));
        let missing =
            all.iter().find(|name| !page.contains(&format!("{name} ")) && !page.contains(&format!("`{name}`")));
        assert_eq!(missing, None, "{page}");
        for word in ["rad", "m/s", "heading", "line_of_sight", "unit", "hold"] {
            assert!(page.contains(word), "{word}: {page}");
        }
    }
    assert!(said(&falsify(&["explain"], here)).contains("  state  "));
}
