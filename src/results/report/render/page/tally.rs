use std::collections::BTreeMap;

use crate::record::{CellKey, EpisodeTable};

/// Edge of a bin around the car (m).
pub const NEAR: f64 = 2.0;

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

/// Gathers the page's data on episodes, run by run.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// The pedestrian's starts relative to the car in each cell: ahead and to the left.
    pub around: BTreeMap<CellKey, Bins>,
}

impl Tally {
    pub fn add(&mut self, key: &CellKey, episodes: &EpisodeTable<'_>) {
        let around = self.around.entry(key.clone()).or_default();
        for row in episodes.rows().filter(|row| episodes.counts(*row)) {
            let (spawn, hit) = (episodes.spawn(row), episodes.is_collision(row));
            let seen = spawn.ego.to_local(spawn.pedestrian.position());
            around.entry(bin(seen.x, seen.y, NEAR)).or_default().add(hit);
        }
    }
}

fn bin(x: f64, y: f64, edge: f64) -> (i32, i32) {
    ((x / edge).floor() as i32, (y / edge).floor() as i32)
}
