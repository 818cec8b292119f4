//! Behaviour cloning: an actor is fitted to actions that are given.

use rand::RngExt;

use super::actor_critic::ActorCritic;
use super::adam::Adam;
use super::arithmetic::Path;
use super::config::PpoConfig;
use super::gaussian::{Gaussian, Spread};
use super::mlp::MlpScratch;
use super::product::SquaredNorm;
use base::seed::{Seed, Stream};

/// Decisions that a policy is to imitate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Demonstrations {
    /// The observation of each decision, with `frame_stack` the content of the stack: obs_dim × decisions.
    pub observations: Vec<f64>,
    /// The action of each decision, within the bounds of the environment: action_dim × decisions.
    pub actions: Vec<f64>,
    /// The weight of each decision, above 0.
    pub weights: Vec<f64>,
}

/// Gradient steps, and the decisions of each, drawn by their weights.
const STEPS: u32 = 4000;
const BATCH: usize = 256;
/// Adam's first step size; it falls to 0.
const LEARNING_RATE: f64 = 1e-3;

/// Fits the actor and its standard deviations to demonstrations by maximum likelihood. The moments that observations are normalised with become those
/// of the demonstrations. The critic stays.
///
/// Without a demonstration it changes nothing.
///
/// # Source
/// Pomerleau, *Efficient training of artificial neural networks for autonomous navigation*, Neural Computation 3, 1991.
pub fn imitate(policy: &mut ActorCritic, demonstrations: &Demonstrations, config: &PpoConfig, seed: &Seed) {
    let Demonstrations { observations, actions, weights } = demonstrations;
    let (obs_dim, dim) = (policy.obs_dim(), policy.action_dim());
    let mut total = 0.0;
    let sums: Vec<f64> = weights
        .iter()
        .map(|weight| {
            total += weight;
            total
        })
        .collect();
    if total <= 0.0 {
        return;
    }
    if let Some(moments) = policy.observation_moments_mut() {
        moments.update(observations.chunks_exact(obs_dim));
    }
    let mut inputs = vec![0.0_f32; observations.len()];
    for (observation, input) in observations.chunks_exact(obs_dim).zip(inputs.chunks_exact_mut(obs_dim)) {
        policy.prepare(observation, input);
    }
    let path = Path::of(config);
    let mut fit = Fit {
        adam: Adam::new(policy.parameters().len(), config.adam_eps),
        gradient: vec![0.0; policy.parameters().len()],
        scratch: MlpScratch::new(policy.actor(), BATCH),
        spread: Spread::new(dim),
        path,
    };
    let mut stream = seed.stream();
    let (mut seen, mut done) = (Vec::with_capacity(BATCH * obs_dim), Vec::with_capacity(BATCH * dim));
    for step in 0..STEPS {
        seen.clear();
        done.clear();
        for _ in 0..BATCH {
            let place = draw(&sums, &mut stream);
            seen.extend_from_slice(&inputs[place * obs_dim..(place + 1) * obs_dim]);
            done.extend_from_slice(&actions[place * dim..(place + 1) * dim]);
        }
        let rate = LEARNING_RATE * (1.0 - f64::from(step) / f64::from(STEPS));
        fit.step(policy, &seen, &done, rate, config.max_grad_norm);
    }
}

/// The memory for gradient steps.
struct Fit {
    adam: Adam<f32>,
    gradient: Vec<f32>,
    scratch: MlpScratch<f32>,
    spread: Spread,
    path: Path,
}

impl Fit {
    /// Takes a step towards greater likelihood of actions (action_dim × batch) at inputs (obs_dim × batch).
    fn step(&mut self, policy: &mut ActorCritic, inputs: &[f32], actions: &[f64], rate: f64, most_norm: f64) {
        let dim = policy.action_dim();
        let share = dim as f64 / actions.len() as f64;
        self.spread.set(policy.log_std());
        let actor = policy.actor_range();
        policy.actor().forward(&policy.parameters()[actor.clone()], inputs, &mut self.scratch, self.path);
        let slots = self.scratch.output_to_gradient(policy.actor());
        let (mut mean, mut by_log_std) = (vec![0.0; dim], vec![0.0; dim]);
        for (slot, action) in slots.chunks_exact_mut(dim).zip(actions.chunks_exact(dim)) {
            for (mean, slot) in mean.iter_mut().zip(slot.iter()) {
                *mean = f64::from(*slot);
            }
            let gaussian = Gaussian { mean: &mean, spread: &self.spread };
            for (k, slot) in slot.iter_mut().enumerate() {
                let (by_mean, by_spread) = gaussian.log_prob_gradient(action, k);
                *slot = (-share * by_mean) as f32;
                by_log_std[k] -= share * by_spread;
            }
        }
        let parameters = &policy.parameters()[actor.clone()];
        policy.actor().backward(parameters, &mut self.gradient[actor], &mut self.scratch, self.path);
        for (slot, value) in self.gradient[policy.log_std_range()].iter_mut().zip(&by_log_std) {
            *slot = *value as f32;
        }
        let norm = f64::from(self.path.run(SquaredNorm(&self.gradient))).sqrt();
        let scale = (most_norm / (norm + 1e-6)).min(1.0);
        self.adam.step(policy.parameters_mut(), &self.gradient, rate, scale, self.path);
        policy.hold_spread();
    }
}

/// The place of a decision, by sums of weights.
fn draw(sums: &[f64], stream: &mut Stream) -> usize {
    let total = sums.last().copied().unwrap_or(0.0);
    let drawn = total * stream.random::<f64>();
    sums.partition_point(|sum| *sum <= drawn).min(sums.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A teacher whose action is (x + y, −x / 2).
    fn toy() -> Demonstrations {
        let mut toy = Demonstrations::default();
        for number in 0..400 {
            let turn = f64::from(number) * 0.7;
            let (x, y) = (libm::sin(turn), libm::cos(1.3 * turn));
            toy.observations.extend([x, y]);
            toy.actions.extend([x + y, -x / 2.0]);
            toy.weights.push(1.0 + f64::from(number % 3));
        }
        toy
    }

    #[test]
    fn a_policy_repeats_the_commands_of_a_toy_teacher() {
        for normalize_obs in [false, true] {
            let config = PpoConfig { normalize_obs, hidden: vec![32, 32], ..PpoConfig::paper() };
            let mut policy = crate::first_networks(2, 2, &config, &Seed::root(5));
            let before = policy.clone();
            imitate(&mut policy, &toy(), &config, &Seed::root(6));
            let mut scratch = policy.scratch(1);
            for (x, y) in [(0.3, -0.4), (-0.6, 0.2), (0.1, 0.7)] {
                let mut action = [0.0; 2];
                policy.act(&[x, y], &mut action, &mut scratch);
                assert!((action[0] - (x + y)).abs() < 0.05 && (action[1] + x / 2.0).abs() < 0.05, "{action:?}");
            }
            assert!(policy.log_std().iter().all(|log_std| *log_std < -2.0), "{:?}", policy.log_std());
            let critic = policy.critic_range();
            assert_eq!(policy.parameters()[critic.clone()], before.parameters()[critic]);
        }
    }

    #[test]
    fn nothing_to_imitate_changes_nothing() {
        let config = PpoConfig { normalize_obs: true, ..PpoConfig::paper() };
        let mut policy = crate::first_networks(2, 2, &config, &Seed::root(5));
        let before = policy.clone();
        imitate(&mut policy, &Demonstrations::default(), &config, &Seed::root(6));
        assert_eq!(policy, before);
    }
}
