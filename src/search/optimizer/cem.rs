use super::{Optimizer, ranked};
use base::seed::Stream;
use learn::standard_normal;

/// Weight of the elite's moments against those before.
const SMOOTHING: f64 = 0.7;

/// The cross-entropy method with a normal distribution of independent components.
///
/// Each generation is drawn from the distribution. Then mean and standard deviation move towards those of the generation's elite, by the
/// smoothing.
///
/// # Source
/// de Boer, Kroese, Mannor, Rubinstein, *A tutorial on the cross-entropy method*, Annals of Operations Research 134, 2005,
/// section 5 (continuous optimisation), with smoothing.
#[derive(Debug, Clone)]
pub struct CrossEntropy {
    mean: Vec<f64>,
    sd: Vec<f64>,
    population: usize,
    elite: usize,
}

impl CrossEntropy {
    /// Starts around a point with one standard deviation for all components. `elite` is the number of best points.
    pub fn new(mean: Vec<f64>, sd: f64, population: usize, elite: usize) -> Self {
        Self { sd: vec![sd; mean.len()], mean, population, elite: elite.clamp(1, population) }
    }
}

impl Optimizer for CrossEntropy {
    fn ask(&mut self, stream: &mut Stream) -> Vec<Vec<f64>> {
        let mut draw =
            || self.mean.iter().zip(&self.sd).map(|(mean, sd)| mean + sd * standard_normal(stream)).collect();
        (0..self.population).map(|_| draw()).collect()
    }

    fn tell(&mut self, points: &[Vec<f64>], costs: &[f64]) {
        let elite = &ranked(costs)[..self.elite.min(costs.len())];
        for (axis, (middle, spread)) in self.mean.iter_mut().zip(&mut self.sd).enumerate() {
            let values = || elite.iter().map(|place| points[*place][axis]);
            let count = elite.len() as f64;
            let mean = values().sum::<f64>() / count;
            let sd = (values().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count).sqrt();
            *middle += SMOOTHING * (mean - *middle);
            *spread += SMOOTHING * (sd - *spread);
        }
    }
}
