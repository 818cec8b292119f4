use super::*;
use crate::arithmetic::all_paths;
use crate::mlp::Mlp;
use crate::normal::standard_normal;
use base::seed::Seed;

const OBS: usize = 4;
const ACTIONS: usize = 2;
const SAMPLES: usize = 22;

/// Evaluates the network one sample at a time, without matrices.
fn naive_network(mlp: &Mlp, parameters: &[f64], input: &[f64]) -> Vec<f64> {
    let mut x = input.to_vec();
    for (l, layer) in mlp.layers().iter().enumerate() {
        let (weight, bias) = (&parameters[layer.weight.clone()], &parameters[layer.bias.clone()]);
        x = (0..layer.outputs)
            .map(|o| bias[o] + (0..layer.inputs).map(|i| weight[i * layer.outputs + o] * x[i]).sum::<f64>())
            .map(|y| if l + 1 < mlp.layers().len() { libm::tanh(y) } else { y })
            .collect();
    }
    x
}

/// The loss as stable-baselines3 writes it, one sample at a time.
fn naive_loss(policy: &ActorCritic<f64>, batch: &Minibatch<f64>, config: &PpoConfig) -> f64 {
    let half_log_tau = 0.5 * libm::log(2.0 * std::f64::consts::PI);
    let (mut surrogate, mut squares) = (0.0, 0.0);
    for i in 0..batch.len() {
        let obs = &batch.obs[i * OBS..(i + 1) * OBS];
        let mean = naive_network(policy.actor(), &policy.parameters()[policy.actor_range()], obs);
        let value = naive_network(policy.critic(), &policy.parameters()[policy.critic_range()], obs)[0];
        let mut log_prob = 0.0;
        for (k, (mean, log_std)) in mean.iter().zip(policy.log_std()).enumerate() {
            let miss = batch.actions[i * ACTIONS + k] - mean;
            log_prob += -miss * miss / (2.0 * libm::exp(2.0 * log_std)) - log_std - half_log_tau;
        }
        let ratio = libm::exp(log_prob - batch.old_log_probs[i]);
        let clipped = ratio.max(1.0 - config.clip).min(1.0 + config.clip);
        surrogate += (batch.advantages[i] * ratio).min(batch.advantages[i] * clipped);
        squares += (batch.returns[i] - value).powi(2);
    }
    let entropy: f64 = policy.log_std().iter().map(|log_std| 0.5 + half_log_tau + log_std).sum();
    let count = batch.len() as f64;
    -surrogate / count - config.entropy_coefficient * entropy + config.value_coefficient * squares / count
}

fn spread(policy: &ActorCritic<f64>) -> Spread {
    let mut spread = Spread::new(policy.action_dim());
    spread.set(policy.log_std());
    spread
}

/// A policy some steps away from its first weights, and samples of another one nearby.
fn policy_and_batch(hidden: &[usize]) -> (ActorCritic<f64>, Minibatch<f64>) {
    let mut stream = Seed::root(11).stream();
    let mut policy = ActorCritic::<f64>::new(OBS, ACTIONS, hidden, -0.3, &mut stream);
    for parameter in policy.parameters_mut() {
        *parameter += 0.1 * standard_normal(&mut stream);
    }
    let mut batch = Minibatch::with_capacity(SAMPLES, OBS, ACTIONS);
    for _ in 0..SAMPLES {
        let obs: Vec<f64> = (0..OBS).map(|_| standard_normal(&mut stream)).collect();
        let mean = naive_network(policy.actor(), &policy.parameters()[policy.actor_range()], &obs);
        let action: Vec<f64> = mean.iter().map(|mean| mean + standard_normal(&mut stream)).collect();
        let log_prob = Gaussian { mean: &mean, spread: &spread(&policy) }.log_prob(&action);
        batch.obs.extend(obs);
        batch.actions.extend(action);
        batch.old_log_probs.push(log_prob + 0.3 * standard_normal(&mut stream));
        batch.advantages.push(5.0 + 3.0 * standard_normal(&mut stream));
        batch.returns.push(standard_normal(&mut stream));
    }
    batch.normalise_advantages();
    (policy, batch)
}

#[test]
fn every_derivative_of_the_full_loss_agrees_with_differences() {
    let config = &PpoConfig::paper();
    for path in all_paths() {
        for hidden in [&[24, 16][..], &[7], &[3, 9, 4]] {
            let (mut policy, batch) = policy_and_batch(hidden);
            let mut loss = LossGradient::new(&policy, SAMPLES, path);
            let terms = loss.compute(&policy, &batch, config);
            assert!((0.2..0.8).contains(&terms.clip_fraction), "clipping is not put to the test");
            let total = terms.total(config);
            assert!((total - naive_loss(&policy, &batch, config)).abs() < 1e-12 * total.abs().max(1.0));

            let h = 1e-5;
            for i in 0..policy.parameters().len() {
                let old = policy.parameters()[i];
                policy.parameters_mut()[i] = old + h;
                let above = naive_loss(&policy, &batch, config);
                policy.parameters_mut()[i] = old - h;
                let below = naive_loss(&policy, &batch, config);
                policy.parameters_mut()[i] = old;
                let difference = (above - below) / (2.0 * h);
                let gradient = loss.gradient[i];
                assert!((gradient - difference).abs() < 1e-8, "{hidden:?}, {i}: {gradient} against {difference}");
            }
        }
    }
}

#[test]
fn the_gradient_in_single_precision_is_the_same_but_for_rounding() {
    let config = PpoConfig::paper();
    let (policy, batch) = policy_and_batch(&[64, 64]);
    let mut double = LossGradient::new(&policy, SAMPLES, Path::plain());
    double.compute(&policy, &batch, &config);
    let mut single_policy = ActorCritic::<f32>::zeros(policy.actor().clone(), policy.critic().clone());
    for (single, double) in single_policy.parameters_mut().iter_mut().zip(policy.parameters()) {
        *single = *double as f32;
    }
    let single_batch = Minibatch {
        obs: batch.obs.iter().map(|&x| x as f32).collect(),
        actions: batch.actions,
        old_log_probs: batch.old_log_probs,
        advantages: batch.advantages,
        returns: batch.returns,
    };
    for path in all_paths() {
        let mut single = LossGradient::new(&single_policy, SAMPLES, path);
        single.compute(&single_policy, &single_batch, &config);
        for (single, double) in single.gradient.iter().zip(&double.gradient) {
            assert!((f64::from(*single) - double).abs() < 1e-4);
        }
        assert!((single.norm() - double.norm()).abs() < 1e-4);
    }
}

#[test]
fn clipping_stops_only_what_would_go_further() {
    // One sample: ratio e^0.5 or e^-0.5 and an advantage of either sign.
    let config = PpoConfig { entropy_coefficient: 0.0, value_coefficient: 0.0, ..PpoConfig::paper() };
    let (policy, _) = policy_and_batch(&[6]);
    let obs = vec![0.2, -0.1, 0.4, 0.3];
    let mean = naive_network(policy.actor(), &policy.parameters()[policy.actor_range()], &obs);
    let action: Vec<f64> = mean.iter().map(|mean| mean + 0.5).collect();
    let log_prob = Gaussian { mean: &mean, spread: &spread(&policy) }.log_prob(&action);
    for (log_ratio, advantage, policy_loss, moves) in [
        (0.5, 1.0, -1.2, false),
        (0.5, -1.0, libm::exp(0.5f64), true),
        (-0.5, 1.0, -libm::exp(-0.5), true),
        (-0.5, -1.0, 0.8, false),
        (0.1, 1.0, -libm::exp(0.1f64), true),
    ] {
        let batch = Minibatch {
            obs: obs.clone(),
            actions: action.clone(),
            old_log_probs: vec![log_prob - log_ratio],
            advantages: vec![advantage],
            returns: vec![0.0],
        };
        let mut loss = LossGradient::new(&policy, 1, Path::widest());
        let terms = loss.compute(&policy, &batch, &config);
        assert!((terms.policy - policy_loss).abs() < 1e-9, "{log_ratio}, {advantage}: {}", terms.policy);
        assert!((terms.approx_kl - (libm::exp(log_ratio) - 1.0 - log_ratio)).abs() < 1e-9);
        assert_eq!(loss.norm() > 1e-6, moves, "{log_ratio}, {advantage}");
    }
}
