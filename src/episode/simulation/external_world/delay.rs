use std::collections::VecDeque;

use super::bridge::MOVED;
use world::av::Fault;
use world::sim::Pedestrian;

/// In how many ticks in a row a delay is seen until it is one.
const SEEN: u32 = 10;

/// Whether another simulator puts pedestrians where they were told to be some ticks ago. A world with a tolerance may put them elsewhere, but not late.
#[derive(Debug, Default)]
pub(super) struct Delay {
    /// Where they were told to be, the last first.
    told: VecDeque<Vec<[f64; 2]>>,
    /// Of each number of ticks, in how many ticks in a row it was the delay.
    seen: [u32; 8],
}

impl Delay {
    /// Adds a tick.
    ///
    /// # Errors
    /// The pedestrians are late.
    pub fn add(&mut self, pedestrians: &[Pedestrian], places: &[[f64; 2]]) -> Result<(), Fault> {
        let told: Vec<[f64; 2]> = pedestrians.iter().map(|one| [one.state.pose.x, one.state.pose.y]).collect();
        let are_within = |told: &[[f64; 2]], limit: f64| {
            told.iter().zip(places).all(|(one, other)| libm::hypot(one[0] - other[0], one[1] - other[1]) < limit)
        };
        // Where nobody moves, nothing shows.
        if !are_within(&told, MOVED) {
            for (seen, past) in self.seen.iter_mut().zip(&self.told) {
                *seen = if are_within(past, MOVED / 2.0) { *seen + 1 } else { 0 };
            }
        }
        self.told.push_front(told);
        self.told.truncate(self.seen.len());
        let late = self.seen.iter().position(|seen| *seen == SEEN);
        late.map_or(Ok(()), |ticks| Err(Fault::Delayed { ticks: ticks as u32 + 1 }))
    }
}
