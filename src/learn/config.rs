//! The settings of a training run.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

use super::actor_critic::ActorCritic;
use super::schedule::Schedule;
use super::until::Until;

/// The hyperparameters of PPO.
///
/// The number of environments is not one of them: it is the number of environments passed to [`train`](super::train).
///
/// # Source
/// Table I of "Suicidal Pedestrian" (ITSC 2023); a setting that the table does not list has the default of
/// stable-baselines3's `PPO`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PpoConfig {
    /// Environment steps after which no further update starts, summed over all environments.
    pub total_steps: u64,
    /// What ends the training.
    pub until: Until,
    /// Steps per environment between two updates.
    pub rollout_steps: usize,
    /// Passes over the rollout in every update.
    pub epochs: usize,
    /// Samples per minibatch; the last one of an epoch may be shorter.
    pub batch_size: usize,
    /// Adam's step size, for actor and critic alike.
    pub learning_rate: f64,
    /// How the step size changes during training.
    pub learning_rate_schedule: Schedule,
    /// The discount factor per step, γ.
    pub gamma: f64,
    /// The decay λ of generalised advantage estimation.
    pub gae_lambda: f64,
    /// The half width ε of the interval around 1 in which the probability ratio counts.
    pub clip_coef: f64,
    /// The target divergence between old and new policy (nat). It is estimated on a minibatch, and at 1.5 times the target the
    /// update ends early; `None` for never.
    pub target_kl: Option<f64>,
    /// The weight of the critic's mean squared error in the loss.
    pub vf_coef: f64,
    /// The weight of the entropy bonus in the loss.
    pub ent_coef: f64,
    /// The upper bound of the gradient's Euclidean norm, taken over all parameters together.
    pub max_grad_norm: f64,
    /// The ε in Adam's denominator.
    pub adam_eps: f64,
    /// Whether advantages are standardised within every minibatch.
    pub norm_adv: bool,
    /// Whether observations are normalised by their running mean and deviation, which become part of the policy.
    pub normalize_obs: bool,
    /// Whether rewards are divided by the running deviation of the discounted return, with the discount γ.
    pub normalize_reward: bool,
    /// The share of the training over which starts widen from the easiest to all; 0 for all from the first episode.
    pub curriculum: f64,
    /// The number of starts that an environment keeps and begins its episodes with copies of, where it can; `None` for a fresh start each time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<usize>,
    /// The share of these copies that are of starts known to be hard for what is trained against.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hard_starts: Option<f64>,
    /// The number of last observations that the policy sees, the newest included.
    pub frame_stack: usize,
    /// The maximum number of threads that step the environments, out of those available; `None` for all of these.
    ///
    /// The bits are the same on any number.
    pub threads: Option<usize>,
    /// Whether only instructions are used that all processors have, so that a seed gives the same bits everywhere.
    ///
    /// It takes about twice the time.
    pub portable_bits: bool,
    /// The first value of every component of the logarithm of the policy's standard deviation.
    pub initial_log_std: f64,
    /// Networks whose weights, standard deviation and moments of observations are the first ones, instead of drawn ones.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "as_digest")]
    pub initial: Option<Arc<ActorCritic>>,
    /// The widths of the hidden layers, the same for actor and critic.
    pub hidden: Vec<usize>,
}

impl PpoConfig {
    /// The settings of the paper.
    pub fn paper() -> Self {
        Self {
            total_steps: 70_000,
            until: Until::Steps,
            rollout_steps: 150,
            epochs: 10,
            batch_size: 64,
            learning_rate: 3e-4,
            learning_rate_schedule: Schedule::Constant,
            gamma: 0.98,
            gae_lambda: 0.95,
            clip_coef: 0.2,
            target_kl: None,
            vf_coef: 0.5,
            ent_coef: 0.01,
            max_grad_norm: 0.5,
            adam_eps: 1e-5,
            norm_adv: true,
            normalize_obs: false,
            normalize_reward: false,
            curriculum: 0.0,
            starts: None,
            hard_starts: None,
            frame_stack: 1,
            threads: None,
            portable_bits: false,
            initial_log_std: 0.0,
            initial: None,
            hidden: vec![64, 64],
        }
    }

    /// The share of all starts from which episodes are drawn after this number of steps, from 0 for the easiest to 1 for all;
    /// none without a curriculum.
    pub(super) fn widening(&self, steps: u64) -> Option<f64> {
        let whole = self.curriculum * self.total_steps as f64;
        (self.curriculum > 0.0).then(|| (steps as f64 / whole).min(1.0))
    }

    /// Returns whether the first updates depend on the number of all steps, so that a longer training is not a continuation of a
    /// shorter one.
    pub fn depends_on_total_steps(&self) -> bool {
        self.curriculum > 0.0 || self.until == Until::Plateau || self.learning_rate_schedule != Schedule::Constant
    }

    /// Writes the settings as a JSON object.
    pub(super) fn to_json(&self) -> String {
        serde_json::to_string(self).expect("settings have a form in JSON")
    }

    /// Returns the first setting, in alphabetical order, that differs from those in a JSON object and on which the next updates
    /// depend; then one that only the object has.
    pub(super) fn difference(&self, other: &str) -> Option<String> {
        let other: Map<String, Value> = serde_json::from_str(other).unwrap_or_default();
        let own: Map<String, Value> = serde_json::from_str(&self.to_json()).expect("settings are an object");
        let differs = |(name, value): &(&String, &Value)| {
            !["total_steps", "threads"].contains(&name.as_str()) && other.get(*name) != Some(value)
        };
        let only_there = || other.keys().find(|name| !own.contains_key(*name)).cloned();
        own.iter().find(differs).map(|(name, _)| name.clone()).or_else(only_there)
    }
}

/// Networks in the settings of a saved training, which has weights of its own.
#[expect(clippy::ref_option, reason = "the form that serde calls")]
fn as_digest<S: Serializer>(networks: &Option<Arc<ActorCritic>>, serializer: S) -> Result<S::Ok, S::Error> {
    let digest = |networks: &Arc<ActorCritic>| blake3::hash(&networks.to_safetensors(&BTreeMap::new())).to_string();
    networks.as_ref().map(digest).serialize(serializer)
}

/// Why networks cannot be the first ones of a training.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsuitableNetworks {
    /// They are for other states.
    #[error(
        "its states have {found} numbers, and those of this training have {expected}; `frame_stack` multiplies them"
    )]
    States {
        /// The numbers of the file.
        found: usize,
        /// Those of the training.
        expected: usize,
    },
    /// They give other actions.
    #[error("its actions have {found} numbers, and those of this training have {expected}")]
    Actions {
        /// The numbers of the file.
        found: usize,
        /// Those of the training.
        expected: usize,
    },
    /// Their hidden layers have other widths.
    #[error("its hidden layers are {found:?}, so `hidden` must be that, and it is {expected:?}")]
    Hidden {
        /// The widths of the file.
        found: Vec<usize>,
        /// Those of the training.
        expected: Vec<usize>,
    },
    /// Only one of the two standardises states.
    #[error("it was trained with `normalize_observations: {found}`, so this training needs the same")]
    Normalised {
        /// Whether the file has moments of observations.
        found: bool,
    },
}

impl PpoConfig {
    /// Checks whether networks can be the first ones of a training with these settings and this number of components of an observation, with
    /// `frame_stack` of them, and of an action.
    ///
    /// # Errors
    /// The first reason why they cannot.
    pub fn accepts(&self, networks: &ActorCritic, obs_dim: usize, action_dim: usize) -> Result<(), UnsuitableNetworks> {
        let states = (networks.obs_dim(), obs_dim * self.frame_stack);
        let actions = (networks.action_dim(), action_dim);
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
        if found != self.normalize_obs { Err(UnsuitableNetworks::Normalised { found }) } else { Ok(()) }
    }
}

impl Default for PpoConfig {
    fn default() -> Self {
        Self::paper()
    }
}
