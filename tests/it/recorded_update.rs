//! One update of the learner against the same update by stable-baselines3.
//!
//! `tests/reference/sb3_update` holds the recording and the script that made it.

use std::path::{Path, PathBuf};

use falsify::rl::{ActorCritic, PpoConfig, RecordedRollout, update_on_recorded};
use safetensors::SafeTensors;
use serde_json::Value;

/// The recording computes values and advantages in single precision.
const SINGLE: f64 = 2e-5;
/// How far a weight may be from the recorded one; the update moves weights by up to 8·10⁻³.
const WEIGHT: f64 = 1e-5;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/sb3_update").join(name)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// The numbers as they were recorded, in single precision.
fn singles(value: &Value) -> Vec<f64> {
    numbers(value).iter().map(|x| f64::from(*x as f32)).collect()
}

fn largest_difference(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs()).fold(0.0, f64::max)
}

/// All tensors of a file under their names.
fn weights(bytes: &[u8]) -> Vec<(String, Vec<f64>)> {
    let tensors = SafeTensors::deserialize(bytes).unwrap();
    let decode = |data: &[u8]| data.as_chunks().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect();
    let mut found: Vec<_> = tensors.iter().map(|(name, view)| (name.to_owned(), decode(view.data()))).collect();
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    found
}

#[test]
fn an_update_agrees_with_stable_baselines3() {
    let recording: Value = serde_json::from_str(&std::fs::read_to_string(file("rollout.json")).unwrap()).unwrap();
    let (before, _) = ActorCritic::from_safetensors(&std::fs::read(file("before.safetensors")).unwrap()).unwrap();
    let column = |name: &str| singles(&recording[name]);
    let rollout = RecordedRollout {
        obs: column("observations").iter().map(|x| *x as f32).collect(),
        actions: column("actions"),
        rewards: column("rewards"),
        episode_starts: recording["episode_starts"].as_array().unwrap().iter().map(|x| x == true).collect(),
        last_obs: column("last_obs"),
        last_done: recording["last_done"] == true,
    };
    let index = |x: f64| x as usize;
    let order: Vec<Vec<usize>> = recording["order"]
        .as_array()
        .unwrap()
        .iter()
        .map(|epoch| numbers(epoch).into_iter().map(index).collect())
        .collect();

    // The recording was made with the settings that are ours.
    let config = PpoConfig::paper();
    let setting = |name: &str| recording["settings"][name].as_f64().unwrap();
    assert_eq!(
        [config.learning_rate, config.gamma, config.gae_lambda, config.clip_coef, config.vf_coef, config.ent_coef],
        ["learning_rate", "gamma", "gae_lambda", "clip_range", "vf_coef", "ent_coef"].map(setting)
    );
    assert_eq!([config.max_grad_norm, config.adam_eps], ["max_grad_norm", "adam_eps"].map(setting));
    let sizes = ["n_steps", "batch_size", "n_epochs"].map(|name| index(setting(name)));
    assert_eq!([config.rollout_steps, config.batch_size, config.epochs], sizes);

    let update = update_on_recorded(before.clone(), &rollout, &order, &config).unwrap();
    for (name, ours) in [
        ("values", &update.values),
        ("log_probs", &update.log_probs),
        ("advantages", &update.advantages),
        ("returns", &update.returns),
    ] {
        let difference = largest_difference(ours, &column(name));
        eprintln!("{name}: the largest difference is {difference:.1e}");
        assert!(difference < SINGLE, "{name} differ by {difference}");
    }
    for (name, ours) in [
        ("policy_gradient_loss", update.policy_loss),
        ("value_loss", update.value_loss),
        ("entropy_loss", -update.entropy),
        ("approx_kl", update.approx_kl),
        ("clip_fraction", update.clip_fraction),
    ] {
        let theirs = recording["logged"][name].as_f64().unwrap();
        eprintln!("{name}: {ours:.9} and {theirs:.9}");
        assert!((ours - theirs).abs() < SINGLE, "{name}: {ours} is not {theirs}");
    }
    // Otherwise the recording would not show whether clipping is right.
    assert!(update.clip_fraction > 0.01);

    let bytes = |policy: &ActorCritic| policy.to_safetensors(&std::collections::BTreeMap::new());
    let recorded = weights(&std::fs::read(file("after.safetensors")).unwrap());
    let (start, end) = (weights(&bytes(&before)), weights(&bytes(&update.actor_critic)));
    let mut worst = 0.0f64;
    for (((name, ours), (same_name, theirs)), (_, start)) in end.iter().zip(&recorded).zip(&start) {
        assert_eq!(name, same_name);
        let (difference, movement) = (largest_difference(ours, theirs), largest_difference(start, theirs));
        eprintln!("{name}: moved by up to {movement:.1e}, the largest difference is {difference:.1e}");
        assert!(movement > 10.0 * WEIGHT, "{name} hardly moves, which proves nothing");
        worst = worst.max(difference);
    }
    let noise = recording["noise"].as_f64().unwrap();
    eprintln!("all weights: {worst:.2e}; rounding to single precision alone is worth {noise:.1e}");
    assert_eq!(end.len(), recorded.len());
    assert!(worst < WEIGHT, "a weight is off by {worst}");
}
