//! The keys of a training.

use base::diagnostic::Sources;
use compile::Catalog;
use learn::{PpoConfig, Schedule};

fn lowered(text: &str) -> PpoConfig {
    let mut sources = Sources::default();
    let read = |_: &std::path::Path| Ok(format!("edition 1 training it = {text}"));
    let loaded = lang::load(&["t.scn".into()], &read, &mut sources).unwrap();
    let catalog = Catalog::builtin();
    let (program, said) = lang::check(&loaded, &sources, &catalog.forms, &mut lang::Checked::new(&catalog.vocabulary));
    assert_eq!(said, []);
    program.declarations[0].block.keys()
}

#[test]
fn the_defaults_are_the_papers() {
    assert_eq!(lowered("ppo()"), PpoConfig::paper());
}

#[test]
fn every_setting_can_be_written() {
    let text =
        "ppo(steps: 1000, steps_per_update: 100, environments: 3, epochs: 4, batch_size: 32, learning_rate: 0.001,
        gamma: 0.9, gae_lambda: 0.8, clip: 0.1, value_coefficient: 0.25, entropy_coefficient: 0.02,
        max_gradient_norm: 1, normalize_advantages: false, initial_log_std: -1, learning_rate_schedule: linear,
        target_kl: 0.03, frame_stack: 4, starts: 512, hard_starts: 0.75, normalize_observations: true,
        normalize_rewards: true, threads: 2, portable_bits: true,
        time_limit_bootstrap: false, hidden: [32, 16])";
    let config = PpoConfig {
        steps: 1000,
        steps_per_update: 100,
        epochs: 4,
        batch_size: 32,
        learning_rate: 0.001,
        learning_rate_schedule: Schedule::Linear,
        gamma: 0.9,
        gae_lambda: 0.8,
        clip: 0.1,
        target_kl: Some(0.03),
        value_coefficient: 0.25,
        entropy_coefficient: 0.02,
        max_gradient_norm: 1.0,
        environments: 3,
        normalize_advantages: false,
        normalize_observations: true,
        normalize_rewards: true,
        starts: Some(512),
        hard_starts: Some(0.75),
        frame_stack: 4,
        threads: Some(2),
        portable_bits: true,
        initial_log_std: -1.0,
        from: None,
        policies: None,
        credit: None,
        time_limit_bootstrap: false,
        hidden: vec![32, 16],
    };
    assert_eq!(lowered(text), config);
}
