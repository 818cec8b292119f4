use crate::{Crossing, crossings};
use episode::{Simulation, play};

/// Every tenth crossing of a grid of 120 is tried.
const STRIDE: usize = 10;

/// Whether one of twelve walks from this start, which is not changed, ends in a fault of the driver; or in any failure where faults are not judged.
/// `number` is that of the start: another has other crossings of the grid.
pub(super) fn is_hard(start: &dyn Simulation, number: u64) -> bool {
    crossings(2).into_iter().skip(number as usize % STRIDE).step_by(STRIDE).any(|goal| {
        start.snapshot().is_some_and(|mut copy| {
            play(&mut *copy, &mut Crossing::new(goal), &mut ());
            copy.judged_fault().unwrap_or_else(|| copy.is_failure())
        })
    })
}
