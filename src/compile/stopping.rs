use base::statistics::{Weighted, wilson_at};

/// Episodes until the first look; each further look comes at twice as many.
const FIRST_LOOK: u32 = 1_000;
/// The probability that an interval misses the rate, over all looks together.
const ALPHA: f64 = 0.05;

/// When an evaluation stops: when the 95 % interval of its collision rate is narrow enough.
///
/// It looks after 1,000 episodes, 2,000, 4,000 and so on, and at the end. Frequent looks with early stopping would make the intervals too
/// optimistic. So each of the K looks has an error of 0.05 / K (Bonferroni). In 95 % of all evaluations the intervals at all looks contain
/// the rate. A look depends only on counts of whole episodes, never on time or threads.
///
/// # Source
/// Chow and Robbins, *On the asymptotic theory of fixed-width sequential confidence intervals for the mean*, Annals of
/// Mathematical Statistics 36, 1965; the interval is Wilson's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoppingRule {
    halfwidth: f64,
    most: u32,
}

impl StoppingRule {
    /// A rule that stops at this half-width, if there is one, and after `most` episodes at the latest.
    pub fn new(halfwidth: Option<f64>, most: u32) -> Self {
        // No interval has a width of 0: without a half-width there is one look, at the end.
        Self { halfwidth: halfwidth.unwrap_or(0.0), most }
    }

    /// The number of episodes at each look; the last is `most`.
    pub fn looks(&self) -> Vec<u32> {
        let doubled = std::iter::successors(Some(FIRST_LOOK), |look| look.checked_mul(2));
        let early = doubled.take_while(|look| self.halfwidth > 0.0 && *look < self.most);
        early.chain([self.most]).collect()
    }

    /// Whether this number of collisions in this number of valid episodes is enough to stop at a look.
    pub fn is_met(&self, collisions: impl Into<Weighted>, episodes: impl Into<Weighted>) -> bool {
        let (low, high) = self.interval(collisions, episodes);
        high - low <= 2.0 * self.halfwidth
    }

    /// The interval that a look evaluates.
    pub fn interval(&self, collisions: impl Into<Weighted>, episodes: impl Into<Weighted>) -> (f64, f64) {
        wilson_at(collisions, episodes, ALPHA / self.looks().len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;
    use rand::Rng;

    #[test]
    fn looks_double_up_to_the_most() {
        assert_eq!(StoppingRule::new(Some(0.02), 10_000).looks(), [1_000, 2_000, 4_000, 8_000, 10_000]);
        assert_eq!(StoppingRule::new(Some(0.02), 1_000).looks(), [1_000]);
        assert_eq!(StoppingRule::new(Some(0.02), 5).looks(), [5]);
        assert_eq!(StoppingRule::new(None, 10_000).looks(), [10_000]);
        assert_eq!(StoppingRule::new(Some(0.02), u32::MAX).looks().last(), Some(&u32::MAX));
    }

    #[test]
    fn rare_and_frequent_events_are_known_sooner_than_even_ones() {
        let rule = StoppingRule::new(Some(0.02), 10_000);
        // z of 0.05 / 5 is 2.576: a half-width of 0.02 takes about 0.25 (2.576 / 0.02)² = 4,147 episodes at one half.
        assert!(!rule.is_met(2_000, 4_000) && rule.is_met(2_100, 4_200));
        assert!(!rule.is_met(100, 1_000) && rule.is_met(20, 1_000), "0.1 takes 1,493 episodes, 0.02 takes 325");
        assert!(!rule.is_met(0, 0) && !StoppingRule::new(None, 10).is_met(0, 10));
    }

    #[test]
    fn the_intervals_of_all_looks_hold_the_rate_together() {
        let rule = StoppingRule::new(Some(0.01), 16_000);
        let (campaigns, rate) = (400, 0.3);
        let mut missed = 0;
        for campaign in 0..campaigns {
            let mut stream = Seed::root(3).index(campaign).stream();
            let (mut hits, mut done, mut outside) = (0, 0, false);
            for look in rule.looks() {
                while done < look {
                    hits += u64::from((stream.next_u32() as f64) < rate * 2_f64.powi(32));
                    done += 1;
                }
                let (low, high) = rule.interval(hits, u64::from(done));
                outside |= rate < low || rate > high;
            }
            missed += u32::from(outside);
        }
        assert!(missed <= 20 + 9, "{missed} of {campaigns}: 20 are expected at most, 4.4 is their standard deviation");
    }
}
