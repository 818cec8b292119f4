use std::collections::BTreeMap;
use std::sync::LazyLock;

use polars::prelude::{DataFrame, DataType, Expr, IntoLazy, PolarsResult};

use crate::record::{CellKey, EpisodeTable, RunKey};
use crate::tables::Metric;
use crate::tables::metrics::{COLLISIONS, EPISODES, inferred};
use base::statistics::ClusteredCount;
use verdict::Reference;

/// The number of first episodes of a run that are kept one by one, for sampling errors, pairs and quantiles. Later episodes count only in
/// sums, so memory does not grow with them. With this number, an error is known to 0.3 %.
pub const MAX_KEPT: usize = 100_000;

/// The counts that inference needs, each with a flag of an episode.
static FLAGS: LazyLock<BTreeMap<&str, (u16, &Metric)>> = LazyLock::new(|| {
    let parts = inferred().filter_map(|metric| metric.counted);
    let wholes = inferred().filter_map(|metric| metric.whole);
    let mut all = BTreeMap::new();
    for count in [&EPISODES, &COLLISIONS].into_iter().chain(parts).chain(wholes) {
        let next = 1 << all.len();
        all.entry(count.name).or_insert((next, count));
    }
    all
});

fn flag(count: &Metric) -> u16 {
    FLAGS.get(count.name).map_or(0, |(flag, _)| *flag)
}

/// The means that inference needs.
fn means() -> impl Iterator<Item = &'static Metric> {
    inferred().filter(|metric| !metric.is_share())
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
    /// The number of episodes of each count, over all episodes.
    counts: BTreeMap<&'static str, ClusteredCount>,
    /// Flags of the kept episodes.
    flags: Vec<u16>,
    /// The quantities of the means, in the order of [`means`].
    quantities: Vec<Quantity>,
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
            counts: BTreeMap::new(),
            flags: Vec::new(),
            quantities: means().map(|_| Quantity { sum: -0.0, kept: Vec::new() }).collect(),
        }
    }

    /// Adds the episodes of a table of the run, which are in ascending order.
    ///
    /// # Errors
    /// Those of polars; none for a table of episodes.
    pub fn add(&mut self, rows: &DataFrame) -> PolarsResult<()> {
        let table = EpisodeTable::new(rows)?;
        self.size = table.rows().map(|row| table.episode(row) as usize + 1).max().unwrap_or(0).max(self.size);
        let kept = self.size.min(self.most);
        self.flags.resize(kept, 0);
        self.quantities.iter_mut().for_each(|quantity| quantity.kept.resize(kept, 0.0));
        let parts = FLAGS.values().map(|(_, count)| *count).chain(means());
        let parts: Vec<Expr> = parts.map(|metric| (metric.part)().alias(metric.name)).collect();
        let parts = rows.clone().lazy().select(parts).collect()?;
        for (flag, count) in FLAGS.values() {
            let holds = parts.column(count.name)?.bool()?;
            let here = table.rows().filter(|row| holds.get(*row) == Some(true));
            let mut counted = 0_u64;
            for row in here {
                counted += 1;
                if let Some(known) = self.flags.get_mut(table.episode(row) as usize) {
                    *known |= flag;
                }
            }
            *self.counts.entry(count.name).or_default() += counted.into();
        }
        for (quantity, mean) in self.quantities.iter_mut().zip(means()) {
            let values = parts.column(mean.name)?.cast(&DataType::Float64)?;
            let values = values.f64()?;
            for row in table.rows() {
                let value = values.get(row).unwrap_or_default();
                quantity.sum += value;
                if let Some(kept) = quantity.kept.get_mut(table.episode(row) as usize) {
                    *kept = value;
                }
            }
        }
        let is_kept = |row: &usize| (table.episode(*row) as usize) < self.most;
        let collided = table.rows().filter(|row| table.counts(*row) && table.is_collision(*row)).filter(is_kept);
        self.impact_speeds.extend(collided.filter_map(|row| table.impact_speed(row)));
        for (place, reference) in Reference::ALL.into_iter().enumerate() {
            self.avoided[place] += (table.avoided(reference).count() as u64).into();
            self.needless[place] += (table.needless(reference).count() as u64).into();
        }
        Ok(())
    }

    /// Adds an episode, with whether each of these shares counts it.
    pub fn add_events<'e>(&mut self, episode: u32, events: impl Iterator<Item = (&'e Metric, bool)>) {
        let place = episode as usize;
        self.size = self.size.max(place + 1);
        self.flags.resize(self.size.min(self.most), 0);
        let parts = events.filter(|(_, holds)| *holds).filter_map(|(metric, _)| metric.counted);
        let mut known = 0;
        for count in std::iter::once(&EPISODES).chain(parts) {
            known |= flag(count);
            *self.counts.entry(count.name).or_default() += 1.into();
        }
        if let Some(kept) = self.flags.get_mut(place) {
            *kept = known;
        }
    }

    /// Episodes that the driver drove to their end.
    pub fn episodes(&self) -> ClusteredCount {
        self.count(&EPISODES)
    }

    pub fn collisions(&self) -> ClusteredCount {
        self.count(&COLLISIONS)
    }

    fn count(&self, count: &Metric) -> ClusteredCount {
        self.counts.get(count.name).copied().unwrap_or_default()
    }

    /// The factor from kept episodes to all episodes, for quantities that two runs have in common.
    pub fn scale_to_all(&self, other: &Self) -> f64 {
        let kept = self.flags.len().min(other.flags.len());
        self.size.min(other.size) as f64 / kept.max(1) as f64
    }

    /// The number of pairs of equal, kept starts in which only this run had the event that a share counts; and the number in which only the
    /// other run had it.
    pub fn discordant(&self, other: &Self, share: &Metric) -> (u64, u64) {
        let (valid, event) = (flag(&EPISODES), share.counted.map_or(0, flag));
        let both = self.flags.iter().zip(&other.flags).filter(|(a, b)| **a & **b & valid != 0);
        both.fold((0, 0), |(only, others), (a, b)| match (a & event != 0, b & event != 0) {
            (true, false) => (only + 1, others),
            (false, true) => (only, others + 1),
            _ => (only, others),
        })
    }

    /// A metric, and the influence of each kept episode on it, relative to its mean; `None` if it has no value.
    pub fn influence(&self, metric: &Metric) -> Option<(f64, Vec<f64>)> {
        let whole = metric.whole?;
        let count = self.count(whole).sum();
        if count == 0.0 {
            return None;
        }
        let (whole, event) = (flag(whole), metric.counted.map_or(0, flag));
        let quantity = means().position(|mean| mean == metric).map(|place| &self.quantities[place]);
        let value = |episode: usize| match quantity {
            Some(quantity) => quantity.kept[episode],
            None => f64::from(u8::from(self.flags[episode] & event != 0)),
        };
        let counted = || metric.counted.map_or(0.0, |count| self.count(count).sum());
        let mean = quantity.map_or_else(counted, |quantity| quantity.sum) / count;
        let influence =
            |episode: usize| if self.flags[episode] & whole != 0 { (value(episode) - mean) / count } else { 0.0 };
        Some((mean, (0..self.flags.len()).map(influence).collect()))
    }
}
