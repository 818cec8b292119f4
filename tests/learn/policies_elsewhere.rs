//! Trained policies act alike in PyTorch, stable-baselines3 and onnxruntime.
//!
//! Needs a Python with these packages; `FALSIFY_PYTHON` names it (default `python3`):
//! `pip install stable-baselines3 safetensors onnx onnxruntime`.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

use base::seed::Seed;
use learn::{Env, FrameStack, PpoConfig, train};
use needs::needs;
use serde_json::{Value, json};

use super::ped_world::{End, PedWorld, Reward, Road, Rules, Units};

/// The largest difference of an action (rad, m/s): theirs are in single precision, and our hyperbolic tangent is our own.
const TOLERANCE: f64 = 1e-6;

/// Trains a policy briefly and writes it, with its actions in 500 states that it reaches.
fn write_case(folder: &Path, name: &str, config: &PpoConfig) {
    let rules = Rules { road: Road::Tee, obs: Units::Raw, act: Units::Raw, reward: Reward::R2, end: End::Lost };
    let mut worlds = [PedWorld::new(rules, Seed::root(1).stream())];
    let policy =
        train(&mut worlds, config, &Seed::root(2), &mut |_| ControlFlow::Continue(())).unwrap().policies.remove(0);
    let [world] = &mut worlds;
    let bounds = world.action_bounds();
    let (mut obs, mut stack, mut scratch) = ([0.0; 4], FrameStack::new(4, config.frame_stack), policy.scratch(1));
    let (mut states, mut actions, mut over) = (Vec::new(), Vec::new(), true);
    for _ in 0..500 {
        if over {
            world.reset(&mut obs);
            stack.begin(&obs);
        } else {
            stack.push(&obs);
        }
        let mut action = [0.0; 2];
        policy.act(stack.as_slice(), &mut action, &mut scratch);
        for (action, (low, high)) in action.iter_mut().zip(&bounds) {
            *action = action.clamp(*low, *high);
        }
        states.push(stack.as_slice().to_vec());
        actions.push(action);
        over = world.step(&action, &mut obs).done();
    }
    let none = BTreeMap::new();
    let (low, high): (Vec<f64>, Vec<f64>) = bounds.iter().copied().unzip();
    let recorded = json!({ "states": states, "actions": actions, "low": low, "high": high });
    std::fs::write(folder.join(format!("{name}.safetensors")), policy.to_safetensors(&none)).unwrap();
    std::fs::write(folder.join(format!("{name}.onnx")), policy.to_onnx(&bounds, &none)).unwrap();
    std::fs::write(folder.join(format!("{name}.json")), recorded.to_string()).unwrap();
}

/// Compares the actions of trained policies in a program.
fn acts_alike(program: &str) {
    let folder = tempfile::tempdir().unwrap();
    let plain = PpoConfig { steps: 3_000, learning_rate: 3e-3, ..PpoConfig::paper() };
    let rich = PpoConfig { frame_stack: 3, normalize_observations: true, hidden: vec![32, 16, 8], ..plain.clone() };
    write_case(folder.path(), "plain", &plain);
    write_case(folder.path(), "rich", &rich);

    let python = std::env::var("FALSIFY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = crate::repository().join("tests/reference/policy/elsewhere.py");
    let output = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let worst: BTreeMap<String, Value> = serde_json::from_str(text.lines().last().expect("a line of output")).unwrap();
    assert_eq!(worst.len(), 4);
    let difference = worst[program].as_f64().expect("all packages are there");
    eprintln!("{program}: the largest difference of an action is {difference:e}");
    assert!(difference <= TOLERANCE, "{program} differs by {difference:e}");
}

#[needs(module = "torch")]
#[test]
fn trained_policies_act_alike_in_pytorch() {
    acts_alike("torch");
}

#[needs(module = "stable_baselines3")]
#[test]
fn trained_policies_act_alike_in_stable_baselines3() {
    acts_alike("stable_baselines3");
}

#[needs(module = "onnxruntime")]
#[test]
fn trained_policies_act_alike_in_onnxruntime() {
    acts_alike("onnxruntime");
}

#[needs(module = "onnx")]
#[test]
fn trained_policies_are_valid_onnx() {
    acts_alike("onnx_checker");
}
