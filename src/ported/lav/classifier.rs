/// The classifier's scores with a hazard and without one.
const SCORES: (f64, f64) = (0.95, 0.02);

/// The surrogate of LAV's brake classifier: the label after a first-order filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Classifier {
    /// Time constant (s); 0 for no delay.
    pub response: f64,
    score: f64,
}

impl Classifier {
    pub fn new(response: f64) -> Self {
        Self { response, score: SCORES.1 }
    }

    /// Resets the filter.
    pub fn reset(&mut self) {
        self.score = SCORES.1;
    }

    /// The score (0 to 1) at the end of a tick of length `dt` (s) with this label.
    pub fn run(&mut self, label: bool, dt: f64) -> f64 {
        let target = if label { SCORES.0 } else { SCORES.1 };
        self.score += (target - self.score) * (1.0 - libm::exp(-dt / self.response));
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
            let mut classifier = Classifier::new(0.1);
            assert_eq!(ticks(&mut classifier, true, threshold), 1);
            for _ in 0..100 {
                classifier.run(true, 0.05);
            }
            assert_eq!(ticks(&mut classifier, false, threshold), release);
        }
    }

    #[test]
    fn without_a_time_constant_it_is_the_label() {
        let mut classifier = Classifier::new(0.0);
        assert_eq!(classifier.run(true, 0.05), 0.95);
        assert!((classifier.run(false, 0.05) - 0.02).abs() < 1e-12);
    }
}
