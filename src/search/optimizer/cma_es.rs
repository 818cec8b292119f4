use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{Optimizer, ranked};
use base::seed::Stream;
use learn::standard_normal;

/// The covariance matrix adaptation evolution strategy, with weighted recombination of the better half.
///
/// | tutorial | field |
/// |---|---|
/// | m, σ, C = B D² Bᵀ | `mean`, `step`, `covariance`, `basis`, `scales` |
/// | λ, wᵢ, μ_eff | `population`, `weights`, `effective` |
/// | p_σ, p_c | `step_path`, `covariance_path` |
/// | c_σ, d_σ, c_c, c₁, c_μ, χ_n | `step_rate`, `damping`, `path_rate`, `rank_one`, `rank_mu`, `expected_norm` |
///
/// # Source
/// Hansen, *The CMA evolution strategy: a tutorial*, arXiv:1604.00772, with non-negative weights (no active update).
#[derive(Debug, Clone)]
pub struct CmaEs {
    mean: DVector<f64>,
    step: f64,
    covariance: DMatrix<f64>,
    basis: DMatrix<f64>,
    scales: DVector<f64>,
    step_path: DVector<f64>,
    covariance_path: DVector<f64>,
    population: usize,
    weights: Vec<f64>,
    effective: f64,
    step_rate: f64,
    damping: f64,
    path_rate: f64,
    rank_one: f64,
    rank_mu: f64,
    expected_norm: f64,
    generation: i32,
    decomposed: i32,
}

impl CmaEs {
    /// The population that the tutorial recommends for n dimensions: 4 + ⌊3 ln n⌋.
    pub fn usual_population(dimensions: usize) -> usize {
        4 + (3.0 * libm::log(dimensions as f64)).floor() as usize
    }

    /// Starts around a point with one standard deviation for all components; the population is at least 4.
    pub fn new(mean: Vec<f64>, step: f64, population: usize) -> Self {
        let (n, population) = (mean.len() as f64, population.max(4));
        let best = population / 2;
        let raw: Vec<f64> =
            (1..=best).map(|rank| libm::log((population as f64 + 1.0) / 2.0) - libm::log(rank as f64)).collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| weight / total).collect();
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let step_rate = (effective + 2.0) / (n + effective + 5.0);
        let rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + effective);
        let rank_mu = 2.0 * (0.25 + effective + 1.0 / effective - 2.0) / ((n + 2.0) * (n + 2.0) + effective);
        let dimensions = mean.len();
        Self {
            mean: DVector::from_vec(mean),
            step,
            covariance: DMatrix::identity(dimensions, dimensions),
            basis: DMatrix::identity(dimensions, dimensions),
            scales: DVector::repeat(dimensions, 1.0),
            step_path: DVector::zeros(dimensions),
            covariance_path: DVector::zeros(dimensions),
            population,
            weights,
            effective,
            step_rate,
            damping: 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + step_rate,
            path_rate: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one,
            rank_mu: rank_mu.min(1.0 - rank_one),
            expected_norm: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            generation: 0,
            decomposed: 0,
        }
    }

    /// Decomposes the covariance into its axes, only after enough generations to change it.
    fn decompose(&mut self) {
        let rate = (self.rank_one + self.rank_mu) * self.mean.len() as f64 * 10.0;
        if f64::from(self.generation - self.decomposed) < 1.0 / rate {
            return;
        }
        self.decomposed = self.generation;
        self.covariance.fill_lower_triangle_with_upper_triangle();
        let eigen = SymmetricEigen::new(self.covariance.clone());
        // Rounding can push a vanishing eigenvalue below zero.
        self.scales = eigen.eigenvalues.map(|value| value.max(1e-300).sqrt());
        self.basis = eigen.eigenvectors;
    }
}

impl Optimizer for CmaEs {
    fn ask(&mut self, stream: &mut Stream) -> Vec<Vec<f64>> {
        self.decompose();
        let mut draw = || {
            let z = DVector::from_fn(self.mean.len(), |_, _| standard_normal(stream));
            let y = &self.basis * z.component_mul(&self.scales);
            (&self.mean + y * self.step).as_slice().to_vec()
        };
        (0..self.population).map(|_| draw()).collect()
    }

    fn tell(&mut self, points: &[Vec<f64>], costs: &[f64]) {
        self.generation += 1;
        let n = self.mean.len() as f64;
        let steps: Vec<DVector<f64>> = ranked(costs)
            .into_iter()
            .take(self.weights.len())
            .map(|place| (DVector::from_column_slice(&points[place]) - &self.mean) / self.step)
            .collect();
        let mut shift = DVector::zeros(self.mean.len());
        for (weight, step) in self.weights.iter().zip(&steps) {
            shift.axpy(*weight, step, 1.0);
        }
        self.mean.axpy(self.step, &shift, 1.0);
        let whitened = &self.basis * (self.basis.tr_mul(&shift)).component_div(&self.scales);
        let gain = (self.step_rate * (2.0 - self.step_rate) * self.effective).sqrt();
        self.step_path = &self.step_path * (1.0 - self.step_rate) + whitened * gain;
        let norm = self.step_path.norm();
        // Soon after the start the path is short of its length in the long run.
        let warm = (1.0 - libm::pow(1.0 - self.step_rate, 2.0 * f64::from(self.generation))).sqrt();
        let steady = norm / warm / self.expected_norm < 1.4 + 2.0 / (n + 1.0);
        let gain = if steady { (self.path_rate * (2.0 - self.path_rate) * self.effective).sqrt() } else { 0.0 };
        self.covariance_path = &self.covariance_path * (1.0 - self.path_rate) + shift * gain;
        let lost = if steady { 0.0 } else { self.rank_one * self.path_rate * (2.0 - self.path_rate) };
        self.covariance *= 1.0 - self.rank_one - self.rank_mu + lost;
        self.covariance.ger(self.rank_one, &self.covariance_path, &self.covariance_path, 1.0);
        for (weight, step) in self.weights.iter().zip(&steps) {
            self.covariance.ger(self.rank_mu * weight, step, step, 1.0);
        }
        let growth = self.step_rate / self.damping * (norm / self.expected_norm - 1.0);
        self.step *= libm::exp(growth.min(1.0));
    }
}
