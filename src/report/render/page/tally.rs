use std::collections::BTreeMap;

use polars::prelude::*;

use crate::geometry::{Point, Pose};

/// Edge of a bin about the car (m).
pub const NEAR: f64 = 2.0;
/// Edge of a bin in a town (m).
pub const FAR: f64 = 3.0;
/// Width of a bin of speeds (m/s), and of times (s).
const STEP: f64 = 0.25;

/// What the page tells cells apart by; names of columns of `episodes`.
const KEY: [&str; 8] = ["pedestrian", "reward", "train_town", "train_policy", "town", "policy", "vehicle", "adversary"];

/// A cell: pedestrian, reward, town and policy of its training, town, policy, vehicle, adversary, and the number of the `evaluate` block.
pub type CellKey = ([String; 8], u32);

/// Episodes that began in one place.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bin {
    /// How many.
    pub episodes: u32,
    /// How many of them hit a moving car.
    pub moving: u32,
}

impl Bin {
    fn add(&mut self, moving: bool) {
        self.episodes += 1;
        self.moving += u32::from(moving);
    }

    /// Adds what another bin holds.
    pub fn merge(&mut self, other: Self) {
        self.episodes += other.episodes;
        self.moving += other.moving;
    }
}

/// Bins by their column and row.
pub type Bins = BTreeMap<(i32, i32), Bin>;

/// How many values lie in each bin of a quarter, from 0 on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Histogram {
    /// The counts.
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

    /// For the lower end of every bin, and the end of the last: how many values are at least that, as shares of `whole`.
    pub fn at_least(&self, whole: u32) -> Vec<(f64, f64)> {
        let mut left: u32 = self.counts.iter().sum();
        let mut curve = vec![(0.0, share(left, whole))];
        for (slot, count) in self.counts.iter().enumerate() {
            left -= count;
            curve.push(((slot + 1) as f64 * STEP, share(left, whole)));
        }
        curve
    }

    /// The same for how many are below.
    pub fn below(&self, whole: u32) -> Vec<(f64, f64)> {
        let all: u32 = self.counts.iter().sum();
        self.at_least(whole).into_iter().map(|(value, rest)| (value, share(all, whole) - rest)).collect()
    }
}

fn share(part: u32, whole: u32) -> f64 {
    f64::from(part) / f64::from(whole.max(1))
}

/// What the page needs of the episodes of a cell, in memory that does not grow with their number.
#[derive(Debug, Clone, Default)]
pub struct CellTally {
    /// Which cell.
    pub key: CellKey,
    /// Episodes in which the driver drove to the end.
    pub episodes: u32,
    /// Where the pedestrian began in the town.
    pub town: Bins,
    /// Where it began as the car sees it: ahead and to the left.
    pub around: Bins,
    /// Collisions with a moving car by the car's speed (m/s).
    pub speeds: Histogram,
    /// Episodes without a collision by their least time to collision (s), where the table has it.
    pub times: Histogram,
    /// Episodes without a collision by their post-encroachment time (s), where the table has it.
    pub lags: Histogram,
}

/// Gathers what the page shows of episodes, run by run.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// The cells, in order of appearance.
    pub cells: Vec<CellTally>,
}

impl Tally {
    /// Adds the episodes of one run: rows of the table `episodes` that differ in nothing that tells runs apart.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::report::episodes).
    pub fn add(&mut self, run: &DataFrame) -> PolarsResult<()> {
        if run.height() == 0 {
            return Ok(());
        }
        let text = |name: &str| -> PolarsResult<String> {
            Ok(run.column(name)?.str()?.get(0).unwrap_or_default().to_string())
        };
        let mut names: [String; 8] = Default::default();
        for (value, name) in names.iter_mut().zip(KEY) {
            *value = text(name)?;
        }
        let key = (names, run.column("block")?.u32()?.get(0).unwrap_or_default());
        let place = self.cells.iter().position(|cell| cell.key == key).unwrap_or_else(|| {
            self.cells.push(CellTally { key, ..CellTally::default() });
            self.cells.len() - 1
        });
        let cell = &mut self.cells[place];
        let (outcome, moving) = (run.column("outcome")?.str()?, run.column("moving")?.bool()?);
        let speed = run.column("impact_speed_mps")?.f64()?;
        let number = |name: &str| -> PolarsResult<Float64Chunked> { Ok(run.column(name)?.f64()?.clone()) };
        let maybe = |name: &str| run.column(name).ok().and_then(|column| column.f64().ok()).cloned();
        let (time, lag) = (maybe("min_ttc_s"), maybe("pet_s"));
        let (ego_x, ego_y, ego_yaw) = (number("ego_x_m")?, number("ego_y_m")?, number("ego_yaw_deg")?);
        let (x, y) = (number("pedestrian_x_m")?, number("pedestrian_y_m")?);
        for row in (0..run.height()).filter(|row| outcome.get(*row) != Some("error")) {
            let at = |column: &Float64Chunked| column.get(row).unwrap_or_default();
            let hit = moving.get(row).unwrap_or_default();
            let ego = Pose::new(at(&ego_x), at(&ego_y), at(&ego_yaw).to_radians());
            let start = Point::new(at(&x), at(&y));
            let seen = ego.to_local(start);
            cell.episodes += 1;
            cell.town.entry(bin(start.x, start.y, FAR)).or_default().add(hit);
            cell.around.entry(bin(seen.x, seen.y, NEAR)).or_default().add(hit);
            if let (true, Some(speed)) = (hit, speed.get(row)) {
                cell.speeds.add(speed);
            }
            if outcome.get(row) == Some("collision") {
                continue;
            }
            for (into, from) in [(&mut cell.times, &time), (&mut cell.lags, &lag)] {
                if let Some(value) = from.as_ref().and_then(|column| column.get(row)) {
                    into.add(value);
                }
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
