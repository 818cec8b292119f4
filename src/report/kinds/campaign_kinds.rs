use polars::prelude::{DataFrame, PolarsResult};

use super::cell::{CellKinds, Mode};
use super::sample::RunSample;
use super::{curves, mode_panels, rule_bars, tables, words};
use crate::analysis::FailureMode;
use crate::campaign::TrainingResult;
use crate::compile::{Campaign, Evaluation, Pedestrian};
use crate::report::{ReportFolder, WriteError};
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// In how many ways the pedestrians of a campaign hit the cars, and from which beginnings.
#[derive(Debug, Clone)]
pub struct Kinds<'a> {
    campaign: &'a Campaign,
    trainings: &'a [TrainingResult],
    seed: Seed,
    /// The runs of cells of which some are still to come.
    open: Vec<Vec<RunSample<'a>>>,
    cells: Vec<CellKinds<'a>>,
}

impl<'a> Kinds<'a> {
    /// Of a campaign that has been run from this seed, before any of its episodes is seen.
    pub fn new(campaign: &'a Campaign, trainings: &'a [TrainingResult], seed: &Seed) -> Self {
        Self { campaign, trainings, seed: *seed, open: Vec::new(), cells: Vec::new() }
    }

    /// Takes a table of the episodes of one run, as [`episodes`](crate::report::episodes) makes it; runs may come in any order, each
    /// once. One that was not planned, or has no episodes, is left out.
    ///
    /// # Errors
    /// Those of polars, when a column is missing or of another type.
    pub fn add(&mut self, run: &DataFrame) -> PolarsResult<()> {
        let Some(evaluation) = planned(self.campaign, run)? else { return Ok(()) };
        let planned = self.campaign.evaluations.iter().filter(|other| is_of_one_cell(evaluation, other)).count();
        let sample = RunSample::new(evaluation, planned, run)?;
        let place = self.open.iter().position(|cell| is_of_one_cell(cell[0].evaluation, evaluation));
        let place = place.unwrap_or_else(|| {
            self.open.push(Vec::new());
            self.open.len() - 1
        });
        self.open[place].push(sample);
        if self.open[place].len() == planned {
            let runs = self.open.remove(place);
            self.analyse(runs);
        }
        Ok(())
    }

    fn analyse(&mut self, mut runs: Vec<RunSample<'a>>) {
        runs.sort_by_key(|run| run.evaluation.trained.run);
        let trained: Vec<Option<&ActorCritic>> =
            runs.iter().map(|run| networks(self.campaign, self.trainings, run.evaluation)).collect();
        self.cells.push(CellKinds::new(runs, &trained, &self.seed));
    }

    /// Adds tables and pictures to a report; gives what its summary says of them.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&mut self, folder: &ReportFolder) -> Result<String, WriteError> {
        for runs in std::mem::take(&mut self.open) {
            self.analyse(runs);
        }
        // In the plan's order, whatever the order in which they were finished.
        let place = |cell: &CellKinds<'_>| {
            self.campaign.evaluations.iter().position(|each| is_of_one_cell(each, cell.evaluation))
        };
        self.cells.sort_by_key(place);
        let cells = &self.cells;
        folder.table("failure_modes", &tables::failure_modes(cells))?;
        folder.table("mode_counts", &tables::mode_counts(cells))?;
        folder.table("mode_accumulation", &tables::mode_accumulation(cells))?;
        folder.table("explanations", &tables::explanations(cells))?;
        folder.table("explanation_features", &tables::explanation_features(cells))?;
        let names = words::file_names(cells);
        for (cell, name) in cells.iter().zip(&names) {
            if !cell.modes.is_empty() {
                folder.file(&format!("modes/{name}.svg"), mode_panels::mode_panels(cell).as_bytes())?;
            }
            if !cell.explanations.is_empty() {
                folder.file(&format!("modes/{name}-why.svg"), rule_bars::rule_bars(cell).as_bytes())?;
            }
        }
        if let Some(svg) = curves::accumulation_figure(cells) {
            folder.file("mode_accumulation.svg", svg.as_bytes())?;
        }
        Ok(words::words(cells, &names))
    }
}

impl Kinds<'_> {
    /// The modes of all cells that [`Kinds::write`] has written: an evaluation of the cell, the mode, and its example's name,
    /// `RUN:EPISODE`.
    pub fn modes(&self) -> impl Iterator<Item = (&Evaluation, &FailureMode, String)> {
        let example = |mode: &Mode| format!("{}:{}", mode.example.2, mode.example.1);
        self.cells
            .iter()
            .flat_map(move |cell| cell.modes.iter().map(move |mode| (cell.evaluation, &mode.mode, example(mode))))
    }
}

/// Whether two evaluations are runs of one cell.
fn is_of_one_cell(a: &Evaluation, b: &Evaluation) -> bool {
    names(a) == names(b)
}

/// All names of an evaluation but the number of its run, in the order of the columns.
pub(super) fn names(evaluation: &Evaluation) -> ([&str; 8], u32) {
    let key = &evaluation.trained;
    let (pedestrian, town, policy) = (evaluation.pedestrian.name(), &evaluation.town, &evaluation.policy);
    let (vehicle, adversary) = (&evaluation.vehicle, &evaluation.adversary);
    ([&key.reward, &key.town, &key.policy, pedestrian, town, policy, vehicle, adversary], evaluation.block)
}

/// The columns of [`names`].
pub(super) const NAMES: [&str; 8] =
    ["reward", "train_town", "train_policy", "pedestrian", "town", "policy", "vehicle", "adversary"];

/// The evaluation whose episodes a table holds.
fn planned<'a>(campaign: &'a Campaign, run: &DataFrame) -> PolarsResult<Option<&'a Evaluation>> {
    if run.height() == 0 {
        return Ok(None);
    }
    let mut wanted = [""; 8];
    for (value, name) in wanted.iter_mut().zip(NAMES) {
        *value = run.column(name)?.str()?.get(0).unwrap_or_default();
    }
    let number = |name| PolarsResult::Ok(run.column(name)?.u32()?.get(0).unwrap_or_default());
    let (block, number) = (number("block")?, number("run")?);
    let is_it = |each: &&Evaluation| names(each) == (wanted, block) && each.trained.run == number;
    Ok(campaign.evaluations.iter().find(is_it))
}

/// The networks of an evaluation's pedestrian, if it has any.
fn networks<'a>(
    campaign: &Campaign,
    trainings: &'a [TrainingResult],
    evaluation: &Evaluation,
) -> Option<&'a ActorCritic> {
    let (Pedestrian::Trained(training) | Pedestrian::Sampled(training)) = evaluation.pedestrian else { return None };
    let key = &campaign.trainings[training].key;
    let result = trainings.iter().find(|result| result.key == *key)?;
    Some(&result.result.as_ref().ok()?.actor_critic)
}
