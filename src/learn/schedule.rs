//! How a setting changes during training.

use base::choice;
use serde::Serialize;

choice! {
    /// The course of a setting from the first update to the last.
    ///
    /// # Source
    /// The schedules of stable-baselines3: functions of the remaining share of training.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Schedule {
        /// The setting is constant.
        #[default]
        Constant = "constant",
        /// The setting falls linearly with the steps, to zero at the last one.
        Linear = "linear",
    }
}

impl Schedule {
    /// Returns the setting when `steps` of `total_steps` have been taken.
    ///
    /// A last rollout beyond `total_steps` counts as the end; stable-baselines3 would go below zero.
    pub fn at(self, initial: f64, steps: u64, total_steps: u64) -> f64 {
        match self {
            Self::Constant => initial,
            Self::Linear => initial * (1.0 - steps as f64 / total_steps as f64).max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_schedule_ends_at_zero_and_stays_there() {
        for (steps, expected) in [(0, 8.0), (25, 6.0), (100, 0.0), (130, 0.0)] {
            assert_eq!(Schedule::Linear.at(8.0, steps, 100), expected);
            assert_eq!(Schedule::Constant.at(8.0, steps, 100), 8.0);
        }
    }
}
