use super::{Crossing, WalkPolicy, crossings};
use crate::env::PedestrianEnv;
use crate::sim::WalkCommand;
use learn::Env;

/// Every tenth crossing of a grid of 120 is tried.
const STRIDE: usize = 10;

/// Whether one of twelve crossings from this start, which is not changed, ends in a fault of the driver; or in any failure where faults are not judged.
/// `number` is that of the start: another has other crossings of the grid.
pub(super) fn is_hard(start: &PedestrianEnv, number: u64) -> bool {
    let mut commands = vec![WalkCommand::default(); start.scenario().cast.pedestrian_count()];
    crossings(2).into_iter().skip(number as usize % STRIDE).step_by(STRIDE).any(|goal| {
        let Some(mut env) = start.snapshot() else { return false };
        let mut crossing = Crossing::new(goal);
        loop {
            crossing.choose(&env.scene(), &mut commands);
            if env.carry_out(&commands).done() {
                return env.is_fault().unwrap_or_else(|| env.is_failure());
            }
        }
    })
}
