use super::cell::CellModes;
use super::sample::RunSample;
use crate::jobs::{TrainingResult, networks};
use crate::record::{EpisodeTable, RunKey};
use base::seed::Seed;
use compile::{Campaign, Evaluation};
use learn::ActorCritic;

/// The failure modes of a campaign, and the starts that lead to failures.
#[derive(Debug, Clone)]
pub struct FailureModes<'a> {
    evaluations: Vec<&'a Evaluation>,
    trainings: &'a [TrainingResult],
    seed: Seed,
    /// The keys of the evaluations, in the plan's order.
    keys: Vec<RunKey>,
    /// The run of the last rows, of which more may follow, and the number of runs of its cell.
    last: Option<(RunSample<'a>, usize)>,
    /// The runs of cells of which more runs are expected.
    open: Vec<Vec<RunSample<'a>>>,
    cells: Vec<CellModes>,
}

impl<'a> FailureModes<'a> {
    /// For a campaign that has been run from this seed, before its first episode is added.
    pub fn new(campaign: &'a Campaign, trainings: &'a [TrainingResult], seed: &Seed) -> Self {
        let evaluations: Vec<&Evaluation> = campaign.all().collect();
        let keys = evaluations.iter().copied().map(RunKey::of).collect();
        Self { evaluations, trainings, seed: *seed, keys, last: None, open: Vec::new(), cells: Vec::new() }
    }

    /// Adds the episodes of one run or of a part of it. Runs may come in any order, each once; the parts of a run follow each other. A run that was
    /// not planned is ignored.
    pub fn add(&mut self, wanted: &RunKey, episodes: &EpisodeTable<'_>) {
        let is_it = |key: &RunKey| (&key.cell, key.run) == (&wanted.cell, wanted.run);
        let Some(place) = self.keys.iter().position(is_it) else { return };
        let planned = self.keys.iter().filter(|key| key.cell == wanted.cell).count();
        if !self.last.as_ref().is_some_and(|(last, _)| is_it(&last.key)) {
            self.close();
            let sample = RunSample::new(self.evaluations[place], self.keys[place].clone());
            self.last = Some((sample, planned));
        }
        let (sample, _) = self.last.as_mut().expect("it was opened above");
        sample.add(episodes, planned);
    }

    /// Ends the run of the last rows. A cell that has all its runs is analysed.
    fn close(&mut self) {
        let Some((sample, planned)) = self.last.take() else { return };
        let place = self.open.iter().position(|cell| cell[0].key.cell == sample.key.cell);
        let place = place.unwrap_or_else(|| {
            self.open.push(Vec::new());
            self.open.len() - 1
        });
        self.open[place].push(sample);
        if self.open[place].len() == planned {
            let runs = self.open.remove(place);
            self.analyse(runs);
        }
    }

    fn analyse(&mut self, mut runs: Vec<RunSample<'a>>) {
        runs.sort_by_key(|run| run.evaluation.trained.run);
        let trained: Vec<Option<&ActorCritic>> =
            runs.iter().map(|run| networks(run.evaluation, self.trainings)).collect();
        self.cells.push(CellModes::new(runs, &trained, &self.seed));
    }

    /// The cells of all added runs, in the plan's order, for any order of the runs.
    pub fn finish(mut self) -> Vec<CellModes> {
        self.close();
        for runs in std::mem::take(&mut self.open) {
            self.analyse(runs);
        }
        let place = |cell: &CellModes| self.keys.iter().position(|key| key.cell == cell.key);
        self.cells.sort_by_key(place);
        self.cells
    }
}
