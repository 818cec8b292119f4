use crate::failure::Failure;
use crate::record::{EpisodeTable, RunKey};
use compile::Evaluation;
use world::env::Spawn;
use world::judge::Label;

/// Maximum number of collisions of a cell that are analysed, the first ones of each of its runs.
pub const MAX_FAILURES: usize = 20_000;
/// Maximum number of episodes of a cell that are explained, the first ones of each of its runs.
pub const MAX_CASES: usize = 6_000;

/// The start and the end of an episode.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub episode: u32,
    pub spawn: Spawn,
    pub collision: bool,
    pub preventable: bool,
}

/// The analysed part of a run of a cell.
#[derive(Debug, Clone)]
pub struct RunSample<'a> {
    pub evaluation: &'a Evaluation,
    pub key: RunKey,
    /// The numbers of its episodes and collisions, without those in which the driver failed.
    pub all: (u64, u64),
    /// The number of its first episodes whose collisions were analysed; all of these are in the list.
    pub episodes: u64,
    pub failures: Vec<Failure>,
    pub cases: Vec<Case>,
}

impl<'a> RunSample<'a> {
    /// Starts without any episode.
    pub(super) fn new(evaluation: &'a Evaluation, key: RunKey) -> Self {
        Self { evaluation, key, all: (0, 0), episodes: 0, failures: Vec::new(), cases: Vec::new() }
    }

    /// Takes the first episodes of a run from a part of its table, when its cell has this number of runs.
    pub(super) fn add(&mut self, table: &EpisodeTable<'_>, runs: usize) {
        let sample = self;
        let (failures, cases) = (MAX_FAILURES.div_ceil(runs), MAX_CASES.div_ceil(runs));
        for row in table.rows().filter(|row| table.counts(*row)) {
            let (episode, collision) = (table.episode(row), table.is_collision(row));
            sample.all = (sample.all.0 + 1, sample.all.1 + u64::from(collision));
            let label = table.label(row);
            if sample.cases.len() < cases {
                let preventable = label == Some(Label::Preventable);
                sample.cases.push(Case { episode, spawn: table.spawn(row), collision, preventable });
            }
            if sample.failures.len() == failures {
                continue;
            }
            sample.episodes += 1;
            if collision && label.is_some() {
                sample.failures.push(Failure::of_row(table, row, sample.key.clone()));
            }
        }
    }
}
