use super::{Crossing, crossings, play};
use crate::env::{PedestrianEnv, Simulation};

/// Every tenth crossing of a grid of 120 is tried.
const STRIDE: usize = 10;

/// Whether one of twelve crossings from this start, which is not changed, ends in a fault of the driver; or in any failure where faults are not judged.
/// `number` is that of the start: another has other crossings of the grid.
pub(super) fn is_hard(start: &PedestrianEnv, number: u64) -> bool {
    crossings(2).into_iter().skip(number as usize % STRIDE).step_by(STRIDE).any(|goal| {
        start.copy().is_some_and(|mut env| {
            play(&mut env, &mut Crossing::new(goal), &mut ());
            env.judged_fault().unwrap_or_else(|| env.is_failure())
        })
    })
}
