//! A multilayer perceptron with tanh between its layers.

use std::ops::Range;

use super::arithmetic::{Arithmetic, Kernel, Path, Plain, Real};
use super::product::{Product, ProductOfTranspose, affine, transpose};
use super::tanh::Tanh;

/// The number of outputs up to which a layer is computed by inner products.
const FEW: usize = 4;

/// One affine map of a network, as places in a parameter vector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer {
    pub inputs: usize,
    pub outputs: usize,
    /// Where the weight matrix lies, outputs × inputs, column-major.
    pub weight: Range<usize>,
    /// Where the bias lies.
    pub bias: Range<usize>,
}

/// The shape of a network: affine maps with tanh between them and none after the last.
///
/// The parameters are stored outside, in one flat vector, so that the optimiser needs only a slice.
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

    pub fn inputs(&self) -> usize {
        self.layers[0].inputs
    }

    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].outputs
    }

    /// Returns the length of the parameter vector.
    pub fn parameter_count(&self) -> usize {
        self.layers[self.layers.len() - 1].bias.end
    }

    /// Evaluates the network for one sample and returns the outputs: the same bits on every processor.
    pub fn forward_one<'s, T: Real>(&self, parameters: &[T], input: &[T], scratch: &'s mut MlpScratch<T>) -> &'s [T] {
        scratch.activations[0][..input.len()].copy_from_slice(input);
        for (l, layer) in self.layers.iter().enumerate() {
            let (before, after) = scratch.activations.split_at_mut(l + 1);
            let (x, y) = (&before[l][..layer.inputs], &mut after[0][..layer.outputs]);
            affine(&parameters[layer.weight.clone()], &parameters[layer.bias.clone()], x, y);
            if l + 1 < self.layers.len() {
                T::tanh_slice::<Plain>(y);
            }
        }
        &scratch.activations[self.layers.len()][..self.outputs()]
    }

    /// Evaluates the network for a batch and returns the outputs (outputs × batch).
    ///
    /// `input` is inputs × batch. The scratch space stores what [`Mlp::backward`] needs.
    pub fn forward<'s, T: Real>(
        &self,
        parameters: &[T],
        input: &[T],
        scratch: &'s mut MlpScratch<T>,
        path: Path,
    ) -> &'s [T] {
        let batch = input.len() / self.inputs();
        debug_assert!(input.len() == batch * self.inputs() && batch <= scratch.capacity);
        scratch.batch = batch;
        scratch.activations[0][..input.len()].copy_from_slice(input);
        for (l, layer) in self.layers.iter().enumerate() {
            let &Layer { inputs, outputs, .. } = layer;
            let (weight, bias) = (&parameters[layer.weight.clone()], &parameters[layer.bias.clone()]);
            let (before, after) = scratch.activations.split_at_mut(l + 1);
            let x = &before[l][..inputs * batch];
            let y = &mut after[0][..outputs * batch];
            if outputs <= FEW {
                let weight_transposed = &mut scratch.weight_transposed[..inputs * outputs];
                transpose(weight, weight_transposed, outputs, inputs);
                path.run(ProductOfTranspose {
                    a: weight_transposed,
                    b: x,
                    init: bias,
                    c: y,
                    rows: outputs,
                    inner: inputs,
                });
            } else {
                let (rows, inner, columns) = (outputs, inputs, batch);
                let init = Some(bias);
                path.run(Product::<_, false> { a: weight, b: x, init, c: y, rows, inner, columns });
            }
            if l + 1 < self.layers.len() {
                path.run(Tanh(y));
            }
        }
        &scratch.activations[self.layers.len()][..self.outputs() * batch]
    }

    /// Writes the gradient of a loss with respect to the parameters.
    ///
    /// Call it after [`Mlp::forward`] with the same scratch space. [`MlpScratch::output_to_gradient`] must
    /// hold the derivative of the loss with respect to every output; the call overwrites it.
    pub fn backward<T: Real>(&self, parameters: &[T], gradient: &mut [T], scratch: &mut MlpScratch<T>, path: Path) {
        let batch = scratch.batch;
        for (l, layer) in self.layers.iter().enumerate().rev() {
            let &Layer { inputs, outputs, .. } = layer;
            let x = &scratch.activations[l][..inputs * batch];
            let delta = &scratch.delta[..outputs * batch];
            let weight_transposed = &mut scratch.weight_transposed[..inputs * outputs];

            let weight_gradient = &mut gradient[layer.weight.clone()];
            let product = |a, b, c, rows, columns| {
                path.run(Product::<_, true> { a, b, init: None, c, rows, inner: batch, columns });
            };
            if outputs <= FEW {
                // The longer dimension becomes the rows, which are computed in parallel.
                product(x, delta, &mut *weight_transposed, inputs, outputs);
                transpose(weight_transposed, weight_gradient, inputs, outputs);
            } else {
                product(delta, x, weight_gradient, outputs, inputs);
            }
            path.run(SumOfColumns { columns: delta, sum: &mut gradient[layer.bias.clone()] });

            if l > 0 {
                transpose(&parameters[layer.weight.clone()], weight_transposed, outputs, inputs);
                let c = &mut scratch.next_delta[..inputs * batch];
                let (a, b, rows, inner, columns) = (&*weight_transposed, delta, inputs, outputs, batch);
                path.run(Product::<_, false> { a, b, init: None, c, rows, inner, columns });
                path.run(TimesTanhDerivative { values: &mut scratch.next_delta[..inputs * batch], tanh: x });
                std::mem::swap(&mut scratch.delta, &mut scratch.next_delta);
            }
        }
    }
}

/// Adds up the columns of a matrix.
struct SumOfColumns<'a, T> {
    columns: &'a [T],
    sum: &'a mut [T],
}

impl<T: Real> Kernel for SumOfColumns<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(self) {
        self.sum.fill(T::zero());
        for column in self.columns.chunks_exact(self.sum.len()) {
            for (sum, value) in self.sum.iter_mut().zip(column) {
                *sum += *value;
            }
        }
    }
}

/// Multiplies values by the derivative of tanh, which is 1 − tanh².
struct TimesTanhDerivative<'a, T> {
    values: &'a mut [T],
    tanh: &'a [T],
}

impl<T: Real> Kernel for TimesTanhDerivative<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(self) {
        for (value, tanh) in self.values.iter_mut().zip(self.tanh) {
            *value *= A::mul_add(-*tanh, *tanh, T::one());
        }
    }
}

/// The memory for evaluating a network, for batches up to a capacity.
#[derive(Debug, Clone)]
pub struct MlpScratch<T> {
    capacity: usize,
    batch: usize,
    activations: Vec<Vec<T>>,
    delta: Vec<T>,
    next_delta: Vec<T>,
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
            weight_transposed: zeros(largest),
        }
    }

    /// Returns the outputs of the last batch (outputs × batch), to be replaced by the derivatives of a loss with respect to
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
    use crate::arithmetic::all_paths;

    #[test]
    fn a_network_by_hand() {
        // One hidden unit: y = 3 tanh(2 x₀ − x₁ + 0.5) − 1.
        let mlp = Mlp::new(&[2, 1, 1]);
        assert_eq!(mlp.parameter_count(), 5);
        let parameters = [2.0, -1.0, 0.5, 3.0, -1.0];
        let mut scratch = MlpScratch::new(&mlp, 2);
        for path in all_paths() {
            let y = mlp.forward(&parameters, &[1.0, 2.0, -1.0, 0.0], &mut scratch, path);
            assert!((y[0] - (3.0 * libm::tanh(0.5) - 1.0)).abs() < 1e-15);
            assert!((y[1] - (3.0 * libm::tanh(-1.5) - 1.0)).abs() < 1e-15);
        }
        let y = mlp.forward_one(&parameters, &[-1.0, 0.0], &mut scratch);
        assert!((y[0] - (3.0 * libm::tanh(-1.5) - 1.0)).abs() < 1e-15);
    }

    #[test]
    fn every_derivative_agrees_with_differences() {
        for (path, widths) in all_paths().into_iter().flat_map(|path| [(path, [7, 6, 8, 2]), (path, [41, 3, 16, 5])]) {
            let mlp = Mlp::new(&[&[3], &widths[..]].concat());
            let mut parameters: Vec<f64> =
                (0..mlp.parameter_count()).map(|i| libm::sin(1.0 + 7.0 * i as f64)).collect();
            let input: Vec<f64> = (0..3 * 9).map(|i| libm::cos(3.0 * i as f64)).collect();
            let mut scratch = MlpScratch::new(&mlp, 9);
            // The loss is Σ (i + 1) yᵢ² / 2.
            let loss = |parameters: &[f64], scratch: &mut MlpScratch<f64>| -> f64 {
                let y = mlp.forward(parameters, &input, scratch, path);
                y.iter().enumerate().map(|(i, y)| (i + 1) as f64 * y * y / 2.0).sum()
            };
            mlp.forward(&parameters, &input, &mut scratch, path);
            for (i, slot) in scratch.output_to_gradient(&mlp).iter_mut().enumerate() {
                *slot *= (i + 1) as f64;
            }
            let mut gradient = vec![f64::NAN; parameters.len()];
            mlp.backward(&parameters, &mut gradient, &mut scratch, path);
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
}
