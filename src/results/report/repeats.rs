use std::collections::{BTreeMap, BTreeSet};

use polars::prelude::{DataFrame, PolarsResult};

use crate::record::EpisodeTable;
use episode::Spawn;

/// Maximum number of different starts of a run whose starts come again, as the cases of a test do. Drawn starts are more.
const MAX_STARTS: usize = 10_000;

/// A start: the bits of the car's pose and speed, and of the pedestrian's place. What else is drawn, such as which way it looks, counts if episodes
/// differ by it.
pub type StartBits = [u64; 6];

pub fn start_bits(Spawn { ego, ego_speed, pedestrian }: Spawn) -> StartBits {
    [ego.x, ego.y, ego.yaw, ego_speed, pedestrian.x, pedestrian.y].map(f64::to_bits)
}

/// Which episodes only repeat another one.
///
/// A driver that draws nothing does the same from the same start, and a second episode says nothing more. One that draws may end differently, so of
/// a start whose episodes are not all equal, each counts.
#[derive(Debug, Default)]
pub struct Repeats {
    /// By start: the digest of its episodes; `None` if they are not all equal.
    starts: BTreeMap<StartBits, Option<String>>,
    /// Whether a start came again.
    has_duplicates: bool,
    /// The starts of the rows that were kept.
    kept: BTreeSet<StartBits>,
}

impl Repeats {
    /// Looks through the parts of a run for starts that come again. It stops where there are too many starts for that.
    ///
    /// # Errors
    /// Those of polars, for a part without the columns of episodes.
    pub fn of(parts: impl Iterator<Item = PolarsResult<DataFrame>>) -> PolarsResult<Self> {
        let mut all = Self::default();
        for part in parts {
            let part = part?;
            let table = EpisodeTable::new(&part)?;
            for row in table.rows().filter(|row| table.counts(*row)) {
                all.add(start_bits(table.spawn(row)), table.digest(row));
            }
            if all.starts.len() > MAX_STARTS {
                return Ok(Self::default());
            }
        }
        Ok(all)
    }

    /// Adds an episode.
    pub fn add(&mut self, start: StartBits, digest: &str) {
        match self.starts.get_mut(&start) {
            Some(known) => {
                self.has_duplicates = true;
                known.take_if(|known| known != digest);
            }
            None => drop(self.starts.insert(start, Some(digest.to_owned()))),
        }
    }

    /// Whether the starts are those of a grid: they come again, so they are no sample.
    pub fn is_grid(&self) -> bool {
        self.has_duplicates
    }

    /// Whether an episode only repeats one that was kept before; one that does not is kept.
    pub fn repeats(&mut self, start: StartBits) -> bool {
        self.has_duplicates && self.starts.get(&start).is_some_and(Option::is_some) && !self.kept.insert(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_episodes_of_a_driver_that_draws_count() {
        let mut repeats = Repeats::default();
        for (start, digest) in [(0, "1"), (1, "2"), (0, "1"), (1, "3"), (1, "2"), (2, "4")] {
            repeats.add([start; 6], digest);
        }
        assert!(repeats.is_grid());
        let repeated = [0, 1, 0, 1, 1, 2].map(|start| repeats.repeats([start; 6]));
        assert_eq!(repeated, [false, false, true, false, false, false]);
    }
}
