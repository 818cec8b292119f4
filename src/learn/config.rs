//! The settings of a training run.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use serde_json::Map;

use super::actor_critic::ActorCritic;
use super::schedule::Schedule;
use base::signature::{Held, MIN_POSITIVE, Value};
use base::{choice, keys};

/// The ε in Adam's denominator: that of stable-baselines3.
pub const ADAM_EPS: f64 = 1e-5;

choice! {
    /// Which policies move several agents that see and choose for themselves.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub enum Policies {
        /// One for all of them.
        Shared = "shared",
        /// One for each role.
        Each = "each",
    }
}

choice! {
    /// What the reward of an agent is that sees and chooses for itself.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub enum Credit {
        /// That of the episode, for all.
        Team = "team",
        /// That of a touch for the agent that was touched alone.
        Own = "own",
        /// What the episode earns with the agent and not without it.
        Removal = "removal",
    }
}

keys! {
    /// Proximal policy optimisation.
    #[derive(Serialize)]
    pub struct PpoConfig = "ppo" {
        /// Decisions after which no further update begins; 0 leaves the first networks as they are.
        steps: u64 as whole(0, 10_000_000_000) = "70_000",
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
        /// Starts of moving cars that are kept for each driver and town: an episode begins with a copy of one, drawn at random, instead of a
        /// run-up of its own, which takes more ticks than most episodes. Without it every start is fresh, as it is in a
        /// `search`, in evaluations, for drivers that cannot be copied and for cars without a run-up.
        starts: Option<usize> as whole(1, 100_000),
        /// Share of these copies that are of hard starts, as far as there are enough: of ten times as many starts, those from which one of twelve
        /// scripted walks ends in a fault, or in a failure where the reward does not ask for faults. It needs `starts`. reports/learning.md has what it gains.
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
        from: Option<FirstNetworks> as Path,
        /// Of a cast: its trained pedestrians see and choose for themselves, by one policy (`shared`) or one for each role (`each`). Without it one
        /// policy chooses for all at once. The policies of roles learn from the same episodes, and have files of their own.
        policies: Option<Policies>,
        /// What each of them earns; `team` unless given. That is what the episode earns; or a touch pays the one that was touched alone (`own`); or
        /// what the episode earns with it and not without it (`removal`): the episode is run again from its start without that pedestrian.
        credit: Option<Credit>,
        /// Whether the critic values the state in which the time limit cuts an episode (Pardo et al., ICML 2018), as stable-baselines3 does where an
        /// environment says `TimeLimit.truncated`. Without it the time limit is an end like others.
        time_limit_bootstrap: bool = "true",
        /// Widths of the hidden layers.
        hidden: Vec<usize> as whole(1, 4096) = "[64, 64]",
    }
}

/// The networks with which a training begins: the file, and what it holds once it is read.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstNetworks {
    pub path: String,
    pub networks: Option<Arc<ActorCritic>>,
}

impl Held for FirstNetworks {
    fn held(value: &Value) -> Option<Self> {
        String::held(value).map(|path| Self { path, networks: None })
    }
}

/// The digest of the networks: the settings of a saved training hold it, whose state has weights of its own.
impl Serialize for FirstNetworks {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let digest = |networks: &Arc<ActorCritic>| blake3::hash(&networks.to_safetensors(&BTreeMap::new())).to_string();
        self.networks.as_ref().map(digest).serialize(serializer)
    }
}

impl PpoConfig {
    /// The settings of the paper, which are the defaults of the keys.
    ///
    /// # Source
    /// Table I of "Suicidal Pedestrian" (ITSC 2023); a setting that the table does not list has the default of
    /// stable-baselines3's `PPO`.
    pub fn paper() -> Self {
        Self {
            steps: 70_000,
            steps_per_update: 150,
            environments: 1,
            epochs: 10,
            batch_size: 64,
            learning_rate: 3e-4,
            gamma: 0.98,
            gae_lambda: 0.95,
            clip: 0.2,
            value_coefficient: 0.5,
            entropy_coefficient: 0.01,
            max_gradient_norm: 0.5,
            normalize_advantages: true,
            initial_log_std: 0.0,
            learning_rate_schedule: Schedule::Constant,
            target_kl: None,
            frame_stack: 1,
            starts: None,
            hard_starts: None,
            normalize_observations: false,
            normalize_rewards: false,
            threads: None,
            portable_bits: false,
            from: None,
            policies: None,
            credit: None,
            time_limit_bootstrap: true,
            hidden: vec![64, 64],
        }
    }

    /// Returns whether the first updates depend on the number of all steps, so that a longer training is not a continuation of a
    /// shorter one.
    pub fn depends_on_total_steps(&self) -> bool {
        self.learning_rate_schedule != Schedule::Constant
    }

    /// Writes the settings as a JSON object.
    pub(super) fn to_json(&self) -> String {
        serde_json::to_string(self).expect("settings have a form in JSON")
    }

    /// Returns the first setting, in alphabetical order, that differs from those in a JSON object and on which the next updates
    /// depend; then one that only the object has.
    pub(super) fn difference(&self, other: &str) -> Option<String> {
        let other: Map<String, serde_json::Value> = serde_json::from_str(other).unwrap_or_default();
        let own: Map<String, serde_json::Value> =
            serde_json::from_str(&self.to_json()).expect("settings are an object");
        let differs = |(name, value): &(&String, &serde_json::Value)| {
            !["steps", "threads"].contains(&name.as_str()) && other.get(*name) != Some(value)
        };
        let only_there = || other.keys().find(|name| !own.contains_key(*name)).cloned();
        own.iter().find(differs).map(|(name, _)| name.clone()).or_else(only_there)
    }
}

/// Why networks cannot be the first ones of a training.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsuitableNetworks {
    #[error(
        "its states have {found} numbers, and those of this training have {expected}; `frame_stack` multiplies them"
    )]
    States { found: usize, expected: usize },
    #[error("its actions have {found} numbers, and those of this training have {expected}")]
    Actions { found: usize, expected: usize },
    #[error("its hidden layers are {found:?}, so `hidden` must be that, and it is {expected:?}")]
    Hidden { found: Vec<usize>, expected: Vec<usize> },
    #[error("it was trained with `normalize_observations: {found}`, so this training needs the same")]
    Normalised {
        /// Whether the file has moments of observations.
        found: bool,
    },
}

impl PpoConfig {
    /// Checks whether networks can be the first ones of a training with these settings and this number of components of a state, which is
    /// `frame_stack` observations, and of an action.
    ///
    /// # Errors
    /// The first reason why they cannot.
    pub fn accepts(&self, networks: &ActorCritic, states: usize, actions: usize) -> Result<(), UnsuitableNetworks> {
        let states = (networks.obs_dim(), states);
        let actions = (networks.action_dim(), actions);
        let hidden = |outputs: Vec<usize>| outputs[..outputs.len() - 1].to_vec();
        let widths = [networks.actor(), networks.critic()]
            .map(|mlp| hidden(mlp.layers().iter().map(|layer| layer.outputs).collect()));
        if states.0 != states.1 {
            return Err(UnsuitableNetworks::States { found: states.0, expected: states.1 });
        }
        if actions.0 != actions.1 {
            return Err(UnsuitableNetworks::Actions { found: actions.0, expected: actions.1 });
        }
        if let Some(found) = widths.into_iter().find(|widths| *widths != self.hidden) {
            return Err(UnsuitableNetworks::Hidden { found, expected: self.hidden.clone() });
        }
        let found = networks.observation_moments().is_some();
        if found != self.normalize_observations { Err(UnsuitableNetworks::Normalised { found }) } else { Ok(()) }
    }
}
