use std::sync::Arc;

use super::lowering::Lowering;
use base::signature::{Arguments, Form, LEAST, Param, Signature, Type};
use base::units::Dimension;
use lang::hir::Declaration;
use lang::{Reader, diagnostics, reason};
use learn::{ActorCritic, PpoConfig, Schedule};

const SCHEDULES: &[&str] = &["constant", "linear"];

/// The form `training`.
pub fn form() -> Form {
    Form {
        name: "training",
        doc: "How pedestrians are trained. The defaults are the paper's, and stable-baselines3's where it is silent.",
        plain: None,
        multiplies: false,
        kinds: vec![Signature::new("ppo", "Proximal policy optimisation.", params())],
    }
}

fn params() -> Vec<Param> {
    let count = |max| Type::Integer { min: 1, max };
    let ratio = |min, max| Type::Quantity { dimension: Dimension::RATIO, min, max };
    vec![
        Param::with_default(
            "steps",
            count(10_000_000_000),
            "70_000",
            "Decisions after which no further update begins.",
        ),
        Param::with_default(
            "steps_per_update",
            Type::Integer { min: 2, max: 10_000_000 },
            "150",
            "Decisions of every environment between two updates.",
        ),
        Param::with_default("environments", count(4096), "1", "Environments that are stepped side by side."),
        Param::with_default("epochs", count(10_000), "10", "Passes over the decisions of an update."),
        Param::with_default("batch_size", Type::Integer { min: 2, max: 10_000_000 }, "64", "Decisions of a minibatch."),
        Param::with_default("learning_rate", ratio(LEAST, 1.0), "3e-4", "Adam's step size, for actor and critic."),
        Param::with_default("gamma", Type::share(), "0.98", "Discount of the future, a decision."),
        Param::with_default("gae_lambda", Type::share(), "0.95", "Decay of generalised advantage estimation."),
        Param::with_default("clip", ratio(LEAST, 100.0), "0.2", "Half width of the interval of the probability ratio."),
        Param::with_default("value_coefficient", ratio(0.0, 1e3), "0.5", "Weight of the critic's error."),
        Param::with_default("entropy_coefficient", ratio(0.0, 1e3), "0.01", "Weight of the entropy."),
        Param::with_default("max_gradient_norm", ratio(LEAST, 1e6), "0.5", "Greatest norm of a gradient."),
        Param::with_default(
            "normalize_advantages",
            Type::Boolean,
            "true",
            "Whether advantages are standardised within a minibatch.",
        ),
        Param::with_default(
            "initial_log_std",
            ratio(-10.0, 5.0),
            "0",
            "First logarithm of the action's standard deviation.",
        ),
        Param::with_default(
            "learning_rate_schedule",
            Type::Choice(SCHEDULES),
            "constant",
            "Whether the learning rate falls to 0 over the training.",
        ),
        Param::with_default(
            "clip_schedule",
            Type::Choice(SCHEDULES),
            "constant",
            "Whether the clip falls to 0 over the training.",
        ),
        Param::optional("target_kl", ratio(LEAST, 1e6), "Ends an update early when policies differ by 1.5 times this."),
        Param::optional(
            "value_clip",
            ratio(LEAST, 1e6),
            "How far the critic's values may move in an update and still be corrected, in units of the reward.",
        ),
        Param::with_default(
            "frame_stack",
            count(256),
            "1",
            "Last states that the pedestrian sees, the newest included; zeros stand for those before the first.",
        ),
        Param::with_default(
            "curriculum",
            Type::share(),
            "0",
            "Share of the training over which pedestrians begin nearer at first: from the nearest tenth of the spawn's distances to all of them. A `search` has no curriculum.",
        ),
        Param::with_default(
            "normalize_observations",
            Type::Boolean,
            "false",
            "Whether states are standardised by what was seen so far.",
        ),
        Param::with_default(
            "normalize_rewards",
            Type::Boolean,
            "false",
            "Whether rewards are scaled by the spread of returns so far.",
        ),
        Param::with_default(
            "adam_epsilon",
            ratio(1e-12, 1.0),
            "1e-5",
            "What is added to the denominator of Adam's steps.",
        ),
        Param::with_default(
            "statistics_window",
            count(1_000_000),
            "100",
            "Ended episodes over which the learning curve averages reward and length.",
        ),
        Param::optional(
            "threads",
            count(4096),
            "Most threads that the environments of a training are stepped on; all there are unless given. Changes no number.",
        ),
        Param::with_default(
            "portable_bits",
            Type::Boolean,
            "false",
            "Whether a training gives the same bits on every processor; it takes about twice as long.",
        ),
        Param::optional(
            "from",
            Type::Path,
            "Networks that a report has written (`pedestrians/NAME.safetensors`): the training starts with their weights and their standard deviation, instead of drawn ones and `initial_log_std`. `hidden`, `frame_stack` and `normalize_observations` must be theirs.",
        ),
        Param::with_default("hidden", Type::List(Box::new(count(4096))), "[64, 64]", "Widths of the hidden layers."),
    ]
}

/// The settings and the number of environments.
pub fn lower(arguments: &Arguments) -> (PpoConfig, usize) {
    let count = |key: &str| arguments.integer(key) as usize;
    let width = |value: &base::signature::Value| match value {
        base::signature::Value::Integer(width) => *width as usize,
        other => panic!("checked: a whole number, not {other:?}"),
    };
    let schedule = |key: &str| match arguments.choice(key) {
        "linear" => Schedule::Linear,
        _ => Schedule::Constant,
    };
    let config = PpoConfig {
        total_steps: arguments.integer("steps") as u64,
        rollout_steps: count("steps_per_update"),
        epochs: count("epochs"),
        // Never larger than the number of samples.
        batch_size: count("batch_size").min(count("steps_per_update").saturating_mul(count("environments"))),
        learning_rate: arguments.number("learning_rate"),
        gamma: arguments.number("gamma"),
        gae_lambda: arguments.number("gae_lambda"),
        clip_coef: arguments.number("clip"),
        vf_coef: arguments.number("value_coefficient"),
        ent_coef: arguments.number("entropy_coefficient"),
        max_grad_norm: arguments.number("max_gradient_norm"),
        norm_adv: arguments.boolean("normalize_advantages"),
        initial_log_std: arguments.number("initial_log_std"),
        learning_rate_schedule: schedule("learning_rate_schedule"),
        clip_schedule: schedule("clip_schedule"),
        target_kl: arguments.has("target_kl").then(|| arguments.number("target_kl")),
        clip_range_vf: arguments.has("value_clip").then(|| arguments.number("value_clip")),
        curriculum: arguments.number("curriculum"),
        frame_stack: count("frame_stack"),
        adam_eps: arguments.number("adam_epsilon"),
        stats_window: count("statistics_window"),
        threads: arguments.has("threads").then(|| count("threads")),
        normalize_obs: arguments.boolean("normalize_observations"),
        normalize_reward: arguments.boolean("normalize_rewards"),
        portable_bits: arguments.boolean("portable_bits"),
        hidden: arguments.list("hidden").iter().map(width).collect(),
        initial: None,
    };
    (config, count("environments"))
}

/// The networks of the key `from`, for pedestrians with four numbers of a state and two of an action; none without it, or after reporting what is
/// wrong.
pub fn initial(declaration: &Declaration, config: &PpoConfig, lowering: &mut Lowering<'_>) -> Option<Arc<ActorCritic>> {
    let block = &declaration.block;
    let path = block.arguments.has("from").then(|| block.arguments.text("from"))?;
    let bytes = lowering.read.bytes(&lowering.beside(declaration, path)).map_err(|error| reason(&error));
    let read = bytes.and_then(|bytes| ActorCritic::from_safetensors(&bytes).map_err(|error| error.to_string()));
    let fitting = read.and_then(|(networks, _)| {
        config.accepts(&networks, 4, 2).map_err(|error| error.to_string())?;
        Ok(Arc::new(networks))
    });
    fitting.map_err(|reason| lowering.said.push(diagnostics::unusable_model(block.place("from"), path, &reason))).ok()
}

#[cfg(test)]
mod tests {
    use super::super::Catalog;
    use super::*;
    use base::diagnostic::Sources;

    fn lowered(text: &str) -> (PpoConfig, usize) {
        let mut sources = Sources::default();
        let read = |_: &std::path::Path| Ok(format!("edition 1 training it = {text}"));
        let loaded = lang::load(&["t.scn".into()], &read, &mut sources).unwrap();
        let catalog = Catalog::builtin();
        let (program, said) =
            lang::check(&loaded, &sources, &catalog.forms, &mut lang::Checked::new(&catalog.vocabulary));
        assert_eq!(said, []);
        lower(&program.declarations[0].block.arguments)
    }

    #[test]
    fn the_defaults_are_the_papers() {
        assert_eq!(lowered("ppo()"), (PpoConfig::paper(), 1));
    }

    #[test]
    fn every_setting_can_be_written() {
        let text =
            "ppo(steps: 1000, steps_per_update: 100, environments: 3, epochs: 4, batch_size: 32, learning_rate: 0.001,
            gamma: 0.9, gae_lambda: 0.8, clip: 0.1, value_coefficient: 0.25, entropy_coefficient: 0.02,
            max_gradient_norm: 1, normalize_advantages: false, initial_log_std: -1, learning_rate_schedule: linear,
            clip_schedule: linear, target_kl: 0.03, value_clip: 0.3, frame_stack: 4, curriculum: 0.5, normalize_observations: true,
            normalize_rewards: true, adam_epsilon: 1e-8, statistics_window: 50, threads: 2, portable_bits: true,
            hidden: [32, 16])";
        let config = PpoConfig {
            total_steps: 1000,
            rollout_steps: 100,
            epochs: 4,
            batch_size: 32,
            learning_rate: 0.001,
            learning_rate_schedule: Schedule::Linear,
            gamma: 0.9,
            gae_lambda: 0.8,
            clip_coef: 0.1,
            clip_schedule: Schedule::Linear,
            clip_range_vf: Some(0.3),
            target_kl: Some(0.03),
            vf_coef: 0.25,
            ent_coef: 0.02,
            max_grad_norm: 1.0,
            adam_eps: 1e-8,
            norm_adv: false,
            normalize_obs: true,
            normalize_reward: true,
            curriculum: 0.5,
            frame_stack: 4,
            stats_window: 50,
            threads: Some(2),
            portable_bits: true,
            initial_log_std: -1.0,
            initial: None,
            hidden: vec![32, 16],
        };
        assert_eq!(lowered(text), (config, 3));
    }
}
