use super::Figure;
use crate::record::{CellKey, EpisodeTable, RunKey};
use base::statistics::ClusteredCount;
use world::judge::{Label, Reference};

/// The number of first episodes of a run that are kept one by one, for sampling errors, pairs and quantiles. Later episodes count only in
/// sums, so memory does not grow with them. With this number, an error is known to 0.3 %.
pub const MAX_KEPT: usize = 100_000;

/// The flags of an episode, in a byte.
mod is {
    pub const VALID: u8 = 1;
    pub const TOUCH: u8 = 2;
    pub const FRONT: u8 = 4;
    pub const COLLISION: u8 = 8;
    pub const PREVENTABLE: u8 = 16;
    pub const FAULT: u8 = 32;
    pub const ALL: [u8; 6] = [VALID, TOUCH, FRONT, COLLISION, PREVENTABLE, FAULT];
}

/// A quantity of episodes.
#[derive(Debug, Clone)]
struct Quantity {
    /// The sum over all episodes.
    sum: f64,
    /// The values of the kept episodes; 0 where there is none.
    kept: Vec<f64>,
}

/// The part of one run's episodes that inference needs.
#[derive(Debug, Clone)]
pub struct EvaluatedRun {
    pub key: CellKey,
    pub run: u32,
    /// Speeds at the collisions (m/s), of the episodes that are kept.
    pub impact_speeds: Vec<f64>,
    /// The collisions that each reference driver avoids.
    pub avoided: [ClusteredCount; Reference::COUNT],
    /// The episodes in which each would have braked needlessly.
    pub needless: [ClusteredCount; Reference::COUNT],
    /// The greatest number of episodes that are kept one by one.
    most: usize,
    /// The number of episodes, errors included.
    size: usize,
    /// The number of episodes with each flag, over all episodes.
    counts: [ClusteredCount; 6],
    /// Flags of the kept episodes.
    flags: Vec<u8>,
    /// Rewards, lengths and impact speeds of the episodes.
    quantities: [Quantity; 3],
}

impl EvaluatedRun {
    /// Starts without any episode, and will keep those with numbers below a limit.
    pub fn new(key: RunKey, kept: usize) -> Self {
        Self {
            key: key.cell,
            run: key.run,
            impact_speeds: Vec::new(),
            avoided: Default::default(),
            needless: Default::default(),
            most: kept,
            size: 0,
            counts: Default::default(),
            flags: Vec::new(),
            quantities: std::array::from_fn(|_| Quantity { sum: -0.0, kept: Vec::new() }),
        }
    }

    /// Adds the episodes in these rows of a table of the run, which are in ascending order.
    pub fn add(&mut self, table: &EpisodeTable<'_>, rows: &[usize]) {
        let run = self;
        run.size = rows.iter().map(|row| table.episode(*row) as usize + 1).max().unwrap_or(0).max(run.size);
        let (kept, here) = (run.most, run.size.min(run.most));
        run.flags.resize(here, 0);
        run.quantities.iter_mut().for_each(|quantity| quantity.kept.resize(here, 0.0));
        for row in rows.iter().copied().filter(|row| table.counts(*row)) {
            let episode = table.episode(row) as usize;
            let (touch, collision) = (table.is_touch(row), table.is_collision(row));
            let flag = |holds: bool, flag: u8| if holds { flag } else { 0 };
            let known = is::VALID
                | flag(touch, is::TOUCH)
                | flag(table.is_front(row), is::FRONT)
                | flag(collision, is::COLLISION)
                | flag(table.label(row) == Some(Label::Preventable), is::PREVENTABLE)
                | flag(table.is_fault(row), is::FAULT);
            // In the order of `quantity`.
            let impact_speed = table.impact_speed(row).filter(|_| collision);
            let values = [table.reward(row), table.length(row), impact_speed].map(Option::unwrap_or_default);
            for (count, _) in run.counts.iter_mut().zip(is::ALL).filter(|(_, flag)| known & flag != 0) {
                *count += 1.into();
            }
            for (quantity, value) in run.quantities.iter_mut().zip(values) {
                quantity.sum += value;
                if let Some(kept) = quantity.kept.get_mut(episode) {
                    *kept = value;
                }
            }
            if episode >= kept {
                continue;
            }
            run.flags[episode] = known;
            if collision {
                run.impact_speeds.extend(impact_speed);
            }
        }
        let is_own = |row: &usize| rows.binary_search(row).is_ok();
        for (place, reference) in Reference::ALL.into_iter().enumerate() {
            run.avoided[place] += (table.avoided(reference).filter(is_own).count() as u64).into();
            run.needless[place] += (table.needless(reference).filter(is_own).count() as u64).into();
        }
    }

    /// Adds an episode with three events that stand for a collision, a preventable one and a fault.
    pub fn add_events(&mut self, episode: u32, events: [bool; 3]) {
        let place = episode as usize;
        self.size = self.size.max(place + 1);
        self.flags.resize(self.size.min(self.most), 0);
        let flags = [is::COLLISION, is::PREVENTABLE, is::FAULT].into_iter().zip(events).filter(|(_, holds)| *holds);
        let known = flags.fold(is::VALID, |known, (flag, _)| known | flag);
        for (count, _) in self.counts.iter_mut().zip(is::ALL).filter(|(_, flag)| known & flag != 0) {
            *count += 1.into();
        }
        if let Some(kept) = self.flags.get_mut(place) {
            *kept = known;
        }
    }

    /// Episodes that the driver drove to their end.
    pub fn episodes(&self) -> ClusteredCount {
        self.count(is::VALID)
    }

    pub fn collisions(&self) -> ClusteredCount {
        self.count(is::COLLISION)
    }

    fn count(&self, flag: u8) -> ClusteredCount {
        is::ALL
            .iter()
            .zip(self.counts)
            .find(|(known, _)| **known == flag)
            .map_or_else(ClusteredCount::default, |(_, count)| count)
    }

    /// The factor from kept episodes to all episodes, for quantities that two runs have in common.
    pub fn stretch(&self, other: &Self) -> f64 {
        let kept = self.flags.len().min(other.flags.len());
        self.size.min(other.size) as f64 / kept.max(1) as f64
    }

    /// The number of pairs of equal, kept starts in which only this run had the event of the figure; and the number in which only the
    /// other run had it.
    pub fn discordant(&self, other: &Self, figure: Figure) -> (u64, u64) {
        let flag = part(figure);
        let both = self.flags.iter().zip(&other.flags).filter(|(a, b)| **a & **b & is::VALID != 0);
        both.fold((0, 0), |(only, others), (a, b)| match (a & flag != 0, b & flag != 0) {
            (true, false) => (only + 1, others),
            (false, true) => (only, others + 1),
            _ => (only, others),
        })
    }

    /// A figure, and the influence of each kept episode on it, relative to its mean; `None` if it has no value.
    pub fn influence(&self, figure: Figure) -> Option<(f64, Vec<f64>)> {
        let whole = match figure {
            Figure::Front => is::TOUCH,
            Figure::ImpactSpeed => is::COLLISION,
            _ => is::VALID,
        };
        let flag = part(figure);
        let quantity = quantity(figure).map(|quantity| &self.quantities[quantity]);
        let count = self.count(whole).sum();
        if count == 0.0 {
            return None;
        }
        let value = |episode: usize| match quantity {
            Some(quantity) => quantity.kept[episode],
            None => f64::from(u8::from(self.flags[episode] & flag != 0)),
        };
        let counts = |episode: &usize| self.flags[*episode] & whole != 0;
        let sum = quantity.map_or_else(|| self.count(flag).sum(), |quantity| quantity.sum);
        let mean = sum / count;
        let pull = |episode| if counts(&episode) { (value(episode) - mean) / count } else { 0.0 };
        Some((mean, (0..self.flags.len()).map(pull).collect()))
    }
}

/// The flag of the episodes that count for a rate.
fn part(figure: Figure) -> u8 {
    match figure {
        Figure::Collision | Figure::Reward | Figure::Length | Figure::ImpactSpeed => is::COLLISION,
        Figure::Touch => is::TOUCH,
        Figure::Front => is::FRONT,
        Figure::Preventable => is::PREVENTABLE,
        Figure::Fault => is::FAULT,
    }
}

/// The place of a figure among the quantities; `None` for a rate.
fn quantity(figure: Figure) -> Option<usize> {
    [Figure::Reward, Figure::Length, Figure::ImpactSpeed].iter().position(|quantity| *quantity == figure)
}
