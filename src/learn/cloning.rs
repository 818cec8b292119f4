//! Behaviour cloning: fits a network to given outputs by least squares.

use super::actor_critic::ActorCritic;
use super::adam::Adam;
use super::arithmetic::Path;
use super::config::{ADAM_EPS, PpoConfig};
use super::minibatch::shuffle;
use super::mlp::MlpScratch;
use super::product::SquaredNorm;
use base::seed::Seed;

/// The network of an [`ActorCritic`] that is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fitted {
    /// The mean action; its targets are actions.
    Actor,
    /// The value of an observation; its targets are discounted sums of rewards.
    Critic,
}

/// Fits one of the networks to the targets of observations by Adam, with the batch size, the gradient's bound and the instructions of the settings,
/// and returns the mean squared error over the last epoch.
///
/// `observations` has the components of one sample after another, as the environment gives them; so have `targets`. The step size falls linearly to 0
/// over the epochs. `stop` is asked before every epoch, and ends the fit.
///
/// # Panics
/// When the lengths do not fit each other, or when a number in the settings is zero.
///
/// # Source
/// Pomerleau, *ALVINN*, NIPS 1988; Bain and Sammut, *A framework for behavioural cloning*, 1995.
pub fn fit(
    networks: &mut ActorCritic,
    fitted: Fitted,
    (observations, targets): (&[f32], &[f32]),
    (epochs, learning_rate): (usize, f64),
    config: &PpoConfig,
    seed: &Seed,
    stop: &dyn Fn() -> bool,
) -> f64 {
    let path = Path::of(config.portable_bits);
    let (mlp, range) = match fitted {
        Fitted::Actor => (networks.actor().clone(), networks.actor_range()),
        Fitted::Critic => (networks.critic().clone(), networks.critic_range()),
    };
    let (inputs, outputs) = (mlp.inputs(), mlp.outputs());
    let samples = targets.len() / outputs;
    assert!(observations.len() == samples * inputs && targets.len() == samples * outputs, "each sample is whole");
    let batch = config.batch_size.min(samples.max(1));
    let mut scratch = MlpScratch::<f32>::new(&mlp, batch);
    let mut adam = Adam::new(range.len(), ADAM_EPS);
    let mut gradient = vec![0.0; range.len()];
    let (mut input, mut sample) = (vec![0.0; inputs * batch], vec![0.0; inputs]);
    let mut order: Vec<usize> = (0..samples).collect();
    let mut stream = seed.stream();
    let steps = (epochs * samples.div_ceil(batch)) as f64;
    let (mut step, mut error) = (0.0, 0.0);
    for _ in 0..epochs {
        if stop() {
            break;
        }
        shuffle(&mut order, &mut stream);
        error = 0.0;
        for chosen in order.chunks(batch) {
            for (place, number) in input.chunks_exact_mut(inputs).zip(chosen) {
                let from = &observations[number * inputs..(number + 1) * inputs];
                sample.iter_mut().zip(from).for_each(|(slot, value)| *slot = f64::from(*value));
                networks.prepare(&sample, place);
            }
            let share = 2.0 / (chosen.len() * outputs) as f32;
            mlp.forward(&networks.parameters()[range.clone()], &input[..inputs * chosen.len()], &mut scratch, path);
            let slots = scratch.output_to_gradient(&mlp);
            for (slot, number) in slots.chunks_exact_mut(outputs).zip(chosen) {
                for (slot, target) in slot.iter_mut().zip(&targets[number * outputs..]) {
                    let difference = *slot - target;
                    error += f64::from(difference * difference) / (samples * outputs) as f64;
                    *slot = share * difference;
                }
            }
            mlp.backward(&networks.parameters()[range.clone()], &mut gradient, &mut scratch, path);
            let norm = f64::from(path.run(SquaredNorm(&gradient))).sqrt();
            let scale = (config.max_gradient_norm / (norm + 1e-6)).min(1.0);
            let rate = learning_rate * (1.0 - step / steps);
            adam.step(&mut networks.parameters_mut()[range.clone()], &gradient, rate, scale, path);
            step += 1.0;
        }
    }
    error
}
