use std::sync::Arc;

use super::lowering::Lowering;
use base::keys;
use base::signature::{Form, Keys, MIN_POSITIVE};
use lang::hir::Declaration;
use lang::{Reader, diagnostics, reason};
use learn::{ActorCritic, PpoConfig, Schedule, Until};

keys! {
    /// Proximal policy optimisation.
    pub struct PpoKeys = "ppo" {
        /// Decisions after which no further update begins; 0 leaves the first networks as they are.
        steps: u64 as whole(0, 10_000_000_000) = "70_000",
        /// `plateau` ends a training when the mean reward of its episodes has not risen clearly for half of `steps`: ten parts of a twentieth in
        /// a row, none of them better than the best before by two standard errors. Schedules go by `steps` all the same.
        until: Until = "steps",
        /// Decisions of every environment between two updates.
        steps_per_update: usize as whole(2, 10_000_000) = "150",
        /// Environments that are stepped side by side.
        environments: usize as whole(1, 4096) = "1",
        /// Passes over the decisions of an update.
        epochs: usize as whole(1, 10_000) = "10",
        /// Decisions of a minibatch.
        batch_size: usize as whole(2, 10_000_000) = "64",
        /// Adam's step size, for actor and critic.
        learning_rate: f64 as within(RATIO, MIN_POSITIVE, 1.0) = "3e-4",
        /// Discount of the future, a decision.
        gamma: f64 as share() = "0.98",
        /// Decay of generalised advantage estimation.
        gae_lambda: f64 as share() = "0.95",
        /// Half width of the interval of the probability ratio.
        clip: f64 as within(RATIO, MIN_POSITIVE, 100.0) = "0.2",
        /// Weight of the critic's error.
        value_coefficient: f64 as within(RATIO, 0.0, 1e3) = "0.5",
        /// Weight of the entropy.
        entropy_coefficient: f64 as within(RATIO, 0.0, 1e3) = "0.01",
        /// Maximum norm of a gradient.
        max_gradient_norm: f64 as within(RATIO, MIN_POSITIVE, 1e6) = "0.5",
        /// Whether advantages are standardised within a minibatch.
        normalize_advantages: bool = "true",
        /// First logarithm of the action's standard deviation.
        initial_log_std: f64 as within(RATIO, -10.0, 5.0) = "0",
        /// Whether the learning rate falls to 0 over the training.
        learning_rate_schedule: Schedule = "constant",
        /// Ends an update early when policies differ by 1.5 times this.
        target_kl: Option<f64> as within(RATIO, MIN_POSITIVE, 1e6),
        /// Last states that the pedestrian sees, the newest included; zeros stand for those before the first.
        frame_stack: usize as whole(1, 256) = "1",
        /// Share of the training over which pedestrians begin nearer at first: from the nearest tenth of the spawn's distances
        /// to all of them. A `search` has no curriculum.
        curriculum: f64 as share() = "0",
        /// Starts of moving cars that are kept for each driver and town: an episode begins with a copy of one, drawn at random, instead of a
        /// run-up of its own, which takes more ticks than most encounters. Without it every start is fresh, as it is in a curriculum, in a
        /// `search`, in evaluations, for drivers that cannot be copied and for cars without a run-up.
        starts: Option<usize> as whole(1, 100_000),
        /// Share of these copies that are of hard starts, as far as there are enough: of ten times as many starts, those from which one of twelve
        /// crossings ends in a fault, or in a failure where the reward does not ask for faults. It needs `starts`. reports/learning.md has what it gains.
        hard_starts: Option<f64> as share(),
        /// Whether states are standardised by what was seen so far.
        normalize_observations: bool = "false",
        /// Whether rewards are scaled by the spread of returns so far.
        normalize_rewards: bool = "false",
        /// Most threads that the environments of a training are stepped on; all there are unless given. Changes no number.
        threads: Option<usize> as whole(1, 4096),
        /// Whether a training gives the same bits on every processor; it takes about twice as long.
        portable_bits: bool = "false",
        /// Networks that a report has written (`pedestrians/NAME.safetensors`): the training starts with their weights and
        /// their standard deviation, instead of drawn ones and `initial_log_std`. `hidden`, `frame_stack` and
        /// `normalize_observations` must be theirs.
        from: Option<String> as Path,
        /// Widths of the hidden layers.
        hidden: Vec<usize> as whole(1, 4096) = "[64, 64]",
    }
}

/// The form `training`.
pub fn form() -> Form {
    let doc = "How pedestrians are trained. The defaults are the paper's, and stable-baselines3's where it is silent.";
    Form::of_kinds("training", doc, vec![PpoKeys::signature()])
}

/// The settings and the number of environments.
pub fn lower(keys: PpoKeys) -> (PpoConfig, usize) {
    let config = PpoConfig {
        total_steps: keys.steps,
        until: keys.until,
        rollout_steps: keys.steps_per_update,
        epochs: keys.epochs,
        // Never larger than the number of samples.
        batch_size: keys.batch_size.min(keys.steps_per_update.saturating_mul(keys.environments)),
        learning_rate: keys.learning_rate,
        gamma: keys.gamma,
        gae_lambda: keys.gae_lambda,
        clip_coef: keys.clip,
        vf_coef: keys.value_coefficient,
        ent_coef: keys.entropy_coefficient,
        max_grad_norm: keys.max_gradient_norm,
        norm_adv: keys.normalize_advantages,
        initial_log_std: keys.initial_log_std,
        learning_rate_schedule: keys.learning_rate_schedule,
        target_kl: keys.target_kl,
        curriculum: keys.curriculum,
        starts: keys.starts,
        hard_starts: keys.hard_starts,
        frame_stack: keys.frame_stack,
        adam_eps: PpoConfig::paper().adam_eps,
        threads: keys.threads,
        normalize_obs: keys.normalize_observations,
        normalize_reward: keys.normalize_rewards,
        portable_bits: keys.portable_bits,
        hidden: keys.hidden,
        initial: None,
    };
    (config, keys.environments)
}

/// The networks of the key `from`, for pedestrians with this number of numbers of a state and two of an action; `None` without it, or after reporting
/// what is wrong.
pub fn initial(
    declaration: &Declaration,
    config: &PpoConfig,
    state: usize,
    lowering: &mut Lowering<'_>,
) -> Option<Arc<ActorCritic>> {
    let block = &declaration.block;
    let path = block.keys::<PpoKeys>().from?;
    let mut is_missing = false;
    let bytes = lowering.read.bytes(&lowering.beside(declaration, &path)).map_err(|error| {
        is_missing = error.kind() == std::io::ErrorKind::NotFound;
        reason(&error)
    });
    let read = bytes.and_then(|bytes| ActorCritic::from_safetensors(&bytes).map_err(|error| error.to_string()));
    let fitting = read.and_then(|(networks, _)| {
        config.accepts(&networks, state, 2).map_err(|error| error.to_string())?;
        Ok(Arc::new(networks))
    });
    let unusable = |reason: String| diagnostics::unusable_model(block.place("from"), &path, &reason, is_missing);
    fitting.map_err(|reason| lowering.said.push(unusable(reason))).ok()
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
        lower(program.declarations[0].block.keys())
    }

    #[test]
    fn the_defaults_are_the_papers() {
        assert_eq!(lowered("ppo()"), (PpoConfig::paper(), 1));
    }

    #[test]
    fn every_setting_can_be_written() {
        let text =
            "ppo(steps: 1000, until: plateau, steps_per_update: 100, environments: 3, epochs: 4, batch_size: 32, learning_rate: 0.001,
            gamma: 0.9, gae_lambda: 0.8, clip: 0.1, value_coefficient: 0.25, entropy_coefficient: 0.02,
            max_gradient_norm: 1, normalize_advantages: false, initial_log_std: -1, learning_rate_schedule: linear,
            target_kl: 0.03, frame_stack: 4, curriculum: 0.5, starts: 512, hard_starts: 0.75, normalize_observations: true,
            normalize_rewards: true, threads: 2, portable_bits: true,
            hidden: [32, 16])";
        let config = PpoConfig {
            total_steps: 1000,
            until: Until::Plateau,
            rollout_steps: 100,
            epochs: 4,
            batch_size: 32,
            learning_rate: 0.001,
            learning_rate_schedule: Schedule::Linear,
            gamma: 0.9,
            gae_lambda: 0.8,
            clip_coef: 0.1,
            target_kl: Some(0.03),
            vf_coef: 0.25,
            ent_coef: 0.02,
            max_grad_norm: 1.0,
            adam_eps: 1e-5,
            norm_adv: false,
            normalize_obs: true,
            normalize_reward: true,
            curriculum: 0.5,
            starts: Some(512),
            hard_starts: Some(0.75),
            frame_stack: 4,
            threads: Some(2),
            portable_bits: true,
            initial_log_std: -1.0,
            initial: None,
            hidden: vec![32, 16],
        };
        assert_eq!(lowered(text), (config, 3));
    }
}
