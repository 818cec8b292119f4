//! One update on experience that was recorded elsewhere.

use super::actor_critic::ActorCritic;
use super::arithmetic::Path;
use super::config::PpoConfig;
use super::gaussian::{Gaussian, Spread};
use super::learner::Learner;
use super::rollout::Rollout;
use super::train_error::Quantity;

/// One environment's recorded experience over a rollout, perhaps from another program.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRollout {
    /// obs_dim × steps, column-major: the inputs of the decisions.
    pub obs: Vec<f32>,
    /// action_dim × steps, column-major, before clipping to the bounds.
    pub actions: Vec<f64>,
    /// The rewards, with γ times the value of the final observation added where an episode was cut off.
    pub rewards: Vec<f64>,
    /// Whether the observation of a step is the first of an episode.
    pub episode_starts: Vec<bool>,
    /// The observation after the last step (length obs_dim).
    pub last_obs: Vec<f64>,
    /// Whether the last step ended an episode.
    pub last_done: bool,
}

/// The result of an update on a [`RecordedRollout`].
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedUpdate {
    /// The policy and the critic after the update.
    pub actor_critic: ActorCritic,
    /// The critic's value of every observation before the update.
    pub values: Vec<f64>,
    /// The logarithm of every action's density before the update.
    pub log_probs: Vec<f64>,
    /// The advantage of every action, not yet standardised.
    pub advantages: Vec<f64>,
    /// The critic's target for every observation.
    pub returns: Vec<f64>,
    /// As in [`UpdateLog`](super::UpdateLog).
    pub policy_loss: f64,
    /// As in [`UpdateLog`](super::UpdateLog).
    pub value_loss: f64,
    /// As in [`UpdateLog`](super::UpdateLog) (nat).
    pub entropy: f64,
    /// As in [`UpdateLog`](super::UpdateLog) (nat).
    pub approx_kl: f64,
    /// As in [`UpdateLog`](super::UpdateLog).
    pub clip_fraction: f64,
}

/// Takes the gradient steps of one update on recorded experience, in a given order of the samples.
///
/// It does what [`train`](super::train) does with a rollout, except for collecting it: it values it, estimates advantages,
/// and takes the same gradient steps, from an optimiser in its initial state. `epochs` holds the sample numbers of every
/// epoch in the order in which they are cut into minibatches. `config.steps_per_update`, `config.steps` and
/// the schedules have no effect.
///
/// # Errors
/// The quantity that was not finite.
///
/// # Panics
/// When the lengths in `rollout` do not fit the policy and each other, when there is not one element of `epochs` for each
/// of `config.epochs`, when one does not have as many elements as there are steps, or when `config.batch_size` is zero.
pub fn update_on_recorded(
    actor_critic: ActorCritic,
    rollout: &RecordedRollout,
    epochs: &[Vec<usize>],
    config: &PpoConfig,
) -> Result<RecordedUpdate, Quantity> {
    let steps = rollout.rewards.len();
    let (obs_dim, action_dim) = (actor_critic.obs_dim(), actor_critic.action_dim());
    assert_eq!(epochs.len(), config.epochs, "there must be an order for every epoch");
    assert!(
        rollout.obs.len() == steps * obs_dim
            && rollout.actions.len() == steps * action_dim
            && rollout.episode_starts.len() == steps
            && rollout.last_obs.len() == obs_dim,
        "the parts of a rollout must have the same number of steps"
    );
    let mut buffer = Rollout::new(steps, obs_dim, action_dim);
    buffer.obs.copy_from_slice(&rollout.obs);
    buffer.actions.copy_from_slice(&rollout.actions);
    buffer.rewards.copy_from_slice(&rollout.rewards);
    buffer.episode_starts.copy_from_slice(&rollout.episode_starts);

    let mut scratch = actor_critic.scratch(1);
    let mut spread = Spread::new(action_dim);
    spread.set(actor_critic.log_std());
    let (mut obs, mut mean) = (vec![0.0; obs_dim], vec![0.0; action_dim]);
    for step in 0..steps {
        for (slot, x) in obs.iter_mut().zip(&buffer.obs[step * obs_dim..]) {
            *slot = f64::from(*x);
        }
        actor_critic.act(&obs, &mut mean, &mut scratch);
        let action = &buffer.actions[step * action_dim..(step + 1) * action_dim];
        buffer.log_probs[step] = Gaussian { mean: &mean, spread: &spread }.log_prob(action);
        buffer.values[step] = actor_critic.value(&obs, &mut scratch);
    }
    let last_value = actor_critic.value(&rollout.last_obs, &mut scratch);
    buffer.finish(last_value, rollout.last_done, config.gamma, config.gae_lambda);

    let mut policy = actor_critic;
    let mut learner = Learner::new(&policy, config, (0..steps).collect(), Path::of(config.portable_bits));
    let mut recorded = epochs.iter();
    let rollouts = [buffer];
    let means = learner.learn(&mut policy, &rollouts, config, config.learning_rate, &mut |order| {
        order.copy_from_slice(recorded.next().expect("there is an order for every epoch"));
    })?;
    let [buffer] = rollouts;
    Ok(RecordedUpdate {
        actor_critic: policy,
        values: buffer.values,
        log_probs: buffer.log_probs,
        advantages: buffer.advantages,
        returns: buffer.returns,
        policy_loss: means.policy,
        value_loss: means.value,
        entropy: means.entropy,
        approx_kl: means.approx_kl,
        clip_fraction: means.clip_fraction,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    #[test]
    fn an_update_moves_the_value_towards_the_return() {
        let policy = ActorCritic::new(1, 1, &[8], 0.0, &mut Seed::root(0).stream());
        let rollout = RecordedRollout {
            obs: vec![1.0; 3],
            actions: vec![0.5, -0.5, 0.0],
            rewards: vec![10.0; 3],
            episode_starts: vec![true; 3],
            last_obs: vec![1.0],
            last_done: true,
        };
        let config = PpoConfig { batch_size: 2, epochs: 5, ..PpoConfig::paper() };
        let value = |policy: &ActorCritic| policy.value(&[1.0], &mut policy.scratch(1));
        let before = value(&policy);
        let epochs = vec![vec![2, 0, 1]; 5];
        let update = update_on_recorded(policy, &rollout, &epochs, &config).unwrap();
        assert_eq!((&update.returns[..], &update.values[..]), (&[10.0; 3][..], &[before; 3][..]));
        assert!(value(&update.actor_critic) > before + 1e-3);
    }
}
