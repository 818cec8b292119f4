//! Minimisers of black-box functions: they request the costs of a generation of points and learn from them.

mod cem;
mod cma_es;

pub use cem::CrossEntropy;
pub use cma_es::CmaEs;

use base::seed::Stream;

/// A minimiser that works in generations.
pub trait Optimizer {
    /// Draws the points of the next generation.
    fn ask(&mut self, stream: &mut Stream) -> Vec<Vec<f64>>;

    /// Learns the costs of these points, in the same order. Costs are compared, never added up; NaN counts as the worst.
    fn tell(&mut self, points: &[Vec<f64>], costs: &[f64]);
}

/// The indices of the costs, the least first; equal costs keep their order.
fn ranked(costs: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    let worth = |index: usize| if costs[index].is_nan() { f64::INFINITY } else { costs[index] };
    order.sort_by(|a, b| worth(*a).total_cmp(&worth(*b)));
    order
}

#[cfg(test)]
mod tests;
