//! A multilayer perceptron with tanh between its layers.

use std::ops::Range;

use super::product::{SMALL, product, product_of_transpose, transpose};
use super::real::Real;

/// One affine map of a network, as places in a parameter vector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer {
    /// The number of inputs.
    pub inputs: usize,
    /// The number of outputs.
    pub outputs: usize,
    /// Where the weight matrix lies, outputs × inputs, column-major.
    pub weight: Range<usize>,
    /// Where the bias lies.
    pub bias: Range<usize>,
}

/// The shape of a network: affine maps with tanh between them and none after the last.
///
/// The parameters live outside, in one flat vector, so that the optimiser sees nothing but a slice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mlp {
    layers: Vec<Layer>,
}

impl Mlp {
    /// Lays out a network whose layers have these widths, input first, output last.
    ///
    /// # Panics
    /// When there are fewer than two widths, or one of them is zero.
    pub fn new(widths: &[usize]) -> Self {
        assert!(widths.len() >= 2 && widths.iter().all(|&width| width > 0), "a network needs layers of positive width");
        let mut end = 0;
        let mut take = |count: usize| {
            end += count;
            end - count..end
        };
        let layers = widths
            .windows(2)
            .map(|pair| {
                let (inputs, outputs) = (pair[0], pair[1]);
                Layer { inputs, outputs, weight: take(inputs * outputs), bias: take(outputs) }
            })
            .collect();
        Self { layers }
    }

    /// Returns the layers, from the input to the output.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Returns the number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs
    }

    /// Returns the number of outputs.
    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].outputs
    }

    /// Returns the length of the parameter vector.
    pub fn parameter_count(&self) -> usize {
        self.layers[self.layers.len() - 1].bias.end
    }

    /// Evaluates the network for a batch and returns the outputs (outputs × batch).
    ///
    /// `input` is inputs × batch. What [`Mlp::backward`] needs stays in the scratch space.
    pub fn forward<'s, T: Real>(&self, parameters: &[T], input: &[T], scratch: &'s mut MlpScratch<T>) -> &'s [T] {
        let batch = input.len() / self.inputs();
        debug_assert!(input.len() == batch * self.inputs() && batch <= scratch.capacity);
        scratch.batch = batch;
        scratch.activations[0][..input.len()].copy_from_slice(input);
        for (l, layer) in self.layers.iter().enumerate() {
            let &Layer { inputs, outputs, .. } = layer;
            let weight = &parameters[layer.weight.clone()];
            let (before, after) = scratch.activations.split_at_mut(l + 1);
            let x = &before[l][..inputs * batch];
            let y = &mut after[0][..outputs * batch];
            if outputs <= SMALL {
                let weight_transposed = &mut scratch.weight_transposed[..inputs * outputs];
                transpose(weight, weight_transposed, outputs, inputs);
                product_of_transpose(weight_transposed, x, y, outputs, inputs);
            } else {
                product(weight, x, y, outputs, inputs, batch);
            }
            let bias = &parameters[layer.bias.clone()];
            for y in y.chunks_exact_mut(outputs) {
                for (y, bias) in y.iter_mut().zip(bias) {
                    *y += *bias;
                }
            }
            if l + 1 < self.layers.len() {
                T::tanh_slice(y);
            }
        }
        &scratch.activations[self.layers.len()][..self.outputs() * batch]
    }

    /// Writes the gradient of a loss with respect to the parameters.
    ///
    /// Belongs to the last call of [`Mlp::forward`] with this scratch space. [`MlpScratch::output_to_gradient`] must
    /// hold the derivative of the loss with respect to every output; it is used up.
    pub fn backward<T: Real>(&self, parameters: &[T], gradient: &mut [T], scratch: &mut MlpScratch<T>) {
        let batch = scratch.batch;
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let &Layer { inputs, outputs, .. } = layer;
            let x = &scratch.activations[l][..inputs * batch];
            let delta = &scratch.delta[..outputs * batch];

            let weight_gradient = &mut gradient[layer.weight.clone()];
            if outputs <= SMALL {
                let delta_transposed = &mut scratch.transposed[..outputs * batch];
                transpose(delta, delta_transposed, outputs, batch);
                let weight_transposed = &mut scratch.weight_transposed[..inputs * outputs];
                product(x, delta_transposed, weight_transposed, inputs, batch, outputs);
                transpose(weight_transposed, weight_gradient, inputs, outputs);
            } else {
                let x_transposed = &mut scratch.transposed[..inputs * batch];
                transpose(x, x_transposed, inputs, batch);
                product(delta, x_transposed, weight_gradient, outputs, batch, inputs);
            }
            let bias_gradient = &mut gradient[layer.bias.clone()];
            bias_gradient.fill(T::zero());
            for delta in delta.chunks_exact(outputs) {
                for (sum, delta) in bias_gradient.iter_mut().zip(delta) {
                    *sum += *delta;
                }
            }

            if l > 0 {
                let weight_transposed = &mut scratch.weight_transposed[..inputs * outputs];
                transpose(&parameters[layer.weight.clone()], weight_transposed, outputs, inputs);
                let next = &mut scratch.next_delta[..inputs * batch];
                product(weight_transposed, delta, next, inputs, outputs, batch);
                for (next, x) in next.iter_mut().zip(x) {
                    *next *= T::one() - *x * *x;
                }
                std::mem::swap(&mut scratch.delta, &mut scratch.next_delta);
            }
        }
    }
}

/// The memory that evaluating a network takes, for batches up to a capacity.
#[derive(Debug, Clone)]
pub struct MlpScratch<T> {
    capacity: usize,
    batch: usize,
    activations: Vec<Vec<T>>,
    delta: Vec<T>,
    next_delta: Vec<T>,
    transposed: Vec<T>,
    weight_transposed: Vec<T>,
}

impl<T: Real> MlpScratch<T> {
    /// Makes room for batches of at most `capacity` samples.
    pub fn new(mlp: &Mlp, capacity: usize) -> Self {
        let widths = || std::iter::once(mlp.inputs()).chain(mlp.layers.iter().map(|layer| layer.outputs));
        let zeros = |count: usize| vec![T::zero(); count];
        let widest = widths().max().unwrap_or(0);
        let largest = mlp.layers.iter().map(|layer| layer.weight.len()).max().unwrap_or(0);
        Self {
            capacity,
            batch: 0,
            activations: widths().map(|width| zeros(width * capacity)).collect(),
            delta: zeros(widest * capacity),
            next_delta: zeros(widest * capacity),
            transposed: zeros(widest * capacity),
            weight_transposed: zeros(largest),
        }
    }

    /// Gives the outputs of the last batch (outputs × batch), to be replaced by the derivatives of a loss with respect to
    /// them.
    pub fn output_to_gradient(&mut self, mlp: &Mlp) -> &mut [T] {
        let count = mlp.outputs() * self.batch;
        self.delta[..count].copy_from_slice(&self.activations[mlp.layers.len()][..count]);
        &mut self.delta[..count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_by_hand() {
        // One hidden unit: y = 3 tanh(2 x₀ − x₁ + 0.5) − 1.
        let mlp = Mlp::new(&[2, 1, 1]);
        assert_eq!(mlp.parameter_count(), 5);
        let parameters = [2.0, -1.0, 0.5, 3.0, -1.0];
        let mut scratch = MlpScratch::new(&mlp, 2);
        let y = mlp.forward(&parameters, &[1.0, 2.0, -1.0, 0.0], &mut scratch);
        assert!((y[0] - (3.0 * libm::tanh(0.5) - 1.0)).abs() < 1e-15);
        assert!((y[1] - (3.0 * libm::tanh(-1.5) - 1.0)).abs() < 1e-15);
    }

    #[test]
    fn every_derivative_agrees_with_differences() {
        let mlp = Mlp::new(&[3, 7, 6, 8, 2]);
        let mut parameters: Vec<f64> = (0..mlp.parameter_count()).map(|i| libm::sin(1.0 + 7.0 * i as f64)).collect();
        let input: Vec<f64> = (0..3 * 9).map(|i| libm::cos(3.0 * i as f64)).collect();
        let mut scratch = MlpScratch::new(&mlp, 9);
        // The loss is Σ (i + 1) yᵢ² / 2.
        let loss = |parameters: &[f64], scratch: &mut MlpScratch<f64>| -> f64 {
            let y = mlp.forward(parameters, &input, scratch);
            y.iter().enumerate().map(|(i, y)| (i + 1) as f64 * y * y / 2.0).sum()
        };
        mlp.forward(&parameters, &input, &mut scratch);
        for (i, slot) in scratch.output_to_gradient(&mlp).iter_mut().enumerate() {
            *slot *= (i + 1) as f64;
        }
        let mut gradient = vec![f64::NAN; parameters.len()];
        mlp.backward(&parameters, &mut gradient, &mut scratch);
        let h = 1e-6;
        for i in 0..parameters.len() {
            let old = parameters[i];
            parameters[i] = old + h;
            let above = loss(&parameters, &mut scratch);
            parameters[i] = old - h;
            let below = loss(&parameters, &mut scratch);
            parameters[i] = old;
            let difference = (above - below) / (2.0 * h);
            assert!((gradient[i] - difference).abs() < 1e-6 * difference.abs().max(1.0), "parameter {i}");
        }
    }
}
