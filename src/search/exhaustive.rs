//! Tries every walk of a grid from one start after another: a ceiling for what a search can find there.
//!
//! A start from which no crossing of the grid leads to a fault is one where the driver does well, as far as the grid shows. So the share of the
//! other starts says of two drivers which is better, whatever a pedestrian has learnt.
//!
//! | component of the [`Goal`] | values for `levels` *n* |
//! |---|---|
//! | pace, aim, depth | *n* from 0 to 1 |
//! | hurry | 2*n* − 1 from 0 to 1 |
//! | pursuit and slant | straight at the car; to where the two meet; 2*n* − 1 lines between the slants 0 and 1 |

use super::crossing::{Crossing, Goal};
use super::{BudgetedSimulation, Falsifier, Searched};
use base::keys;
use base::seed::Seed;
use episode::play;

keys! {
    /// Tries every walk of a grid from each start: a ceiling for other searches.
    pub struct Exhaustive = "exhaustive" {
        /// Values of a component: 2 makes 120 walks, 3 makes 945, 4 makes 4,032.
        levels: u32 as whole(2, 6) = "3",
        /// Most starts; the budget may end the search before.
        starts: u64 as whole(1, 1_000_000) = "1000",
    }
}

/// The walks of a grid with this number of values of a component (at least 2): 2 makes 120, 3 makes 945, 4 makes 4,032.
pub fn crossings(levels: u32) -> Vec<Goal> {
    let shares = |count: u32| (0..count).map(move |place| f64::from(place) / f64::from(count - 1));
    let fine = 2 * levels - 1;
    let walks: Vec<(f64, f64)> =
        [(0.5, 0.5), (1.0, 0.5)].into_iter().chain(shares(fine).map(|slant| (0.0, slant))).collect();
    let mut goals = Vec::new();
    for pace in shares(levels) {
        for aim in shares(levels) {
            for depth in shares(levels) {
                for hurry in shares(fine) {
                    goals.extend(
                        walks.iter().map(|(pursuit, slant)| Goal::new([pace, aim, depth, *slant, hurry, *pursuit])),
                    );
                }
            }
        }
    }
    goals
}

impl Falsifier for Exhaustive {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, _: &Seed) -> Searched {
        let goals = crossings(self.levels);
        for start in 0..self.starts {
            for goal in &goals {
                if !simulator.begin(start) || play(simulator, &mut Crossing::new(*goal), &mut ()).is_none() {
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_has_the_stated_number_of_different_crossings_with_the_scripted_ones() {
        for (levels, count) in [(2, 120), (3, 945), (4, 4032)] {
            let goals = crossings(levels);
            let different: std::collections::BTreeSet<_> =
                goals.iter().map(|goal| goal.components().map(f64::to_bits)).collect();
            assert_eq!((goals.len(), different.len()), (count, count));
            // An odd number of values has the middle, at which the scripted controllers aim.
            let scripted = [Goal::INTERCEPT, Goal::HOMING].iter().filter(|goal| goals.contains(goal)).count();
            assert_eq!(scripted, if levels == 3 { 2 } else { 0 });
        }
    }
}
