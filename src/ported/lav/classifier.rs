/// The classifier's scores with a hazard and without one.
const SCORES: (f64, f64) = (0.95, 0.02);
/// Time constant (s); an assumption.
const RESPONSE: f64 = 0.1;

/// The surrogate of LAV's brake classifier: the label after a first-order filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Classifier {
    score: f64,
}

impl Default for Classifier {
    fn default() -> Self {
        Self { score: SCORES.1 }
    }
}

impl Classifier {
    /// Resets the filter.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The score (0 to 1) at the end of a tick of length `dt` (s) with this label.
    pub fn run(&mut self, label: bool, dt: f64) -> f64 {
        let target = if label { SCORES.0 } else { SCORES.1 };
        self.score += (target - self.score) * (1.0 - libm::exp(-dt / RESPONSE));
        self.score
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks of 0.05 s until the score is above, or again not above, a threshold.
    fn ticks(classifier: &mut Classifier, label: bool, threshold: f64) -> usize {
        1 + (0..1000).take_while(|_| (classifier.run(label, 0.05) > threshold) != label).count()
    }

    #[test]
    fn both_thresholds_fire_at_once_and_let_go_one_after_the_other() {
        for (threshold, release) in [(0.1, 5), (0.3, 3)] {
            let mut classifier = Classifier::default();
            assert_eq!(ticks(&mut classifier, true, threshold), 1);
            for _ in 0..100 {
                classifier.run(true, 0.05);
            }
            assert_eq!(ticks(&mut classifier, false, threshold), release);
        }
    }
}
