use std::collections::BTreeMap;

use polars::prelude::{DataFrame, PolarsResult};

use crate::record::{CellKey, EpisodeTable};

/// Edge of a bin around the car (m).
pub const NEAR: f64 = 2.0;
/// Edge of a bin in a town (m).
pub const FAR: f64 = 3.0;
/// Width of a bin of speeds (m/s), and of times (s).
const STEP: f64 = 0.25;

/// The episodes that started in one place.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bin {
    pub episodes: u32,
    /// The number of them that ended in a collision.
    pub collisions: u32,
}

impl Bin {
    fn add(&mut self, collision: bool) {
        self.episodes += 1;
        self.collisions += u32::from(collision);
    }

    /// Adds the counts of another bin.
    pub fn merge(&mut self, other: Self) {
        self.episodes += other.episodes;
        self.collisions += other.collisions;
    }
}

/// Bins by their column and row.
pub type Bins = BTreeMap<(i32, i32), Bin>;

/// The number of values in each bin; a bin is a quarter wide, the first starts at 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Histogram {
    pub counts: Vec<u32>,
}

impl Histogram {
    fn add(&mut self, value: f64) {
        let slot = (value.max(0.0) / STEP) as usize;
        if self.counts.len() <= slot {
            self.counts.resize(slot + 1, 0);
        }
        self.counts[slot] += 1;
    }

    /// The share of values of at least x, relative to `whole`, for x at the lower end of every bin and at the end of the last.
    pub fn at_least(&self, whole: u32) -> Vec<(f64, f64)> {
        let mut left: u32 = self.counts.iter().sum();
        let mut curve = vec![(0.0, share(left, whole))];
        for (slot, count) in self.counts.iter().enumerate() {
            left -= count;
            curve.push(((slot + 1) as f64 * STEP, share(left, whole)));
        }
        curve
    }

    /// The same for values below x.
    pub fn below(&self, whole: u32) -> Vec<(f64, f64)> {
        let all: u32 = self.counts.iter().sum();
        self.at_least(whole).into_iter().map(|(value, rest)| (value, share(all, whole) - rest)).collect()
    }
}

fn share(part: u32, whole: u32) -> f64 {
    f64::from(part) / f64::from(whole.max(1))
}

/// The data of the page on the episodes of a cell, in memory that does not grow with their number.
#[derive(Debug, Clone, Default)]
pub struct CellTally {
    pub key: CellKey,
    /// Episodes that the driver drove to their end.
    pub episodes: u32,
    /// The pedestrian's starts in the town.
    pub town: Bins,
    /// The pedestrian's starts relative to the car: ahead and to the left.
    pub around: Bins,
    /// Collisions, by the car's speed (m/s).
    pub speeds: Histogram,
    /// Episodes without a touch by their least time to collision (s), if the table has it.
    pub times: Histogram,
    /// Episodes without a touch by their post-encroachment time (s), if the table has it.
    pub lags: Histogram,
}

/// Gathers the page's data on episodes, run by run.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// The cells, in order of appearance.
    pub cells: Vec<CellTally>,
}

impl Tally {
    /// Adds the episodes of one run: rows of the table `episodes` with the same key.
    ///
    /// # Errors
    /// Those of polars; none for a table made by `episodes`.
    pub fn add(&mut self, run: &DataFrame) -> PolarsResult<()> {
        if run.height() == 0 {
            return Ok(());
        }
        let episodes = EpisodeTable::new(run)?;
        let key = episodes.key()?.cell;
        let place = self.cells.iter().position(|cell| cell.key == key).unwrap_or_else(|| {
            self.cells.push(CellTally { key, ..CellTally::default() });
            self.cells.len() - 1
        });
        let cell = &mut self.cells[place];
        for row in episodes.rows().filter(|row| episodes.counts(*row)) {
            let (spawn, hit) = (episodes.spawn(row), episodes.is_collision(row));
            let start = spawn.pedestrian.position();
            let seen = spawn.ego.to_local(start);
            cell.episodes += 1;
            cell.town.entry(bin(start.x, start.y, FAR)).or_default().add(hit);
            cell.around.entry(bin(seen.x, seen.y, NEAR)).or_default().add(hit);
            if let (true, Some(speed)) = (hit, episodes.impact_speed(row)) {
                cell.speeds.add(speed);
            }
            if !episodes.is_touch(row) {
                episodes.min_ttc(row).into_iter().for_each(|time| cell.times.add(time));
                episodes.pet(row).into_iter().for_each(|lag| cell.lags.add(lag));
            }
        }
        Ok(())
    }
}

fn bin(x: f64, y: f64, edge: f64) -> (i32, i32) {
    ((x / edge).floor() as i32, (y / edge).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_at_least_and_below_make_up_all() {
        let mut speeds = Histogram::default();
        [0.3, 0.4, 0.8, 0.9, 0.99].iter().for_each(|speed| speeds.add(*speed));
        assert_eq!(speeds.counts, [0, 2, 0, 3]);
        assert_eq!(speeds.at_least(10), [(0.0, 0.5), (0.25, 0.5), (0.5, 0.3), (0.75, 0.3), (1.0, 0.0)]);
        assert_eq!(speeds.below(10), [(0.0, 0.0), (0.25, 0.0), (0.5, 0.2), (0.75, 0.2), (1.0, 0.5)]);
        assert_eq!(Histogram::default().at_least(0), [(0.0, 0.0)]);
    }
}
