use polars::prelude::{DataFrame, PolarsResult};

use super::cell::CellModes;
use super::sample::RunSample;
use crate::campaign::TrainingResult;
use crate::compile::{Campaign, Evaluation, Pedestrian};
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// The ways in which the pedestrians of a campaign hit the cars, and from which starts.
#[derive(Debug, Clone)]
pub struct FailureModes<'a> {
    campaign: &'a Campaign,
    trainings: &'a [TrainingResult],
    seed: Seed,
    /// The runs of cells of which some are still to come.
    open: Vec<Vec<RunSample<'a>>>,
    cells: Vec<CellModes<'a>>,
}

impl<'a> FailureModes<'a> {
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
        self.cells.push(CellModes::new(runs, &trained, &self.seed));
    }

    /// The cells of all that was added, in the plan's order whatever the order in which their runs came.
    pub fn finish(mut self) -> Vec<CellModes<'a>> {
        for runs in std::mem::take(&mut self.open) {
            self.analyse(runs);
        }
        let place = |cell: &CellModes<'_>| {
            self.campaign.evaluations.iter().position(|each| is_of_one_cell(each, cell.evaluation))
        };
        self.cells.sort_by_key(place);
        self.cells
    }
}

/// Whether two evaluations are runs of one cell.
fn is_of_one_cell(a: &Evaluation, b: &Evaluation) -> bool {
    names(a) == names(b)
}

/// All names of an evaluation but the number of its run, in the order of the columns.
pub fn names(evaluation: &Evaluation) -> ([&str; 8], u32) {
    let key = &evaluation.trained;
    let (pedestrian, town, policy) = (evaluation.pedestrian.name(), &evaluation.town, &evaluation.policy);
    let (vehicle, adversary) = (&evaluation.vehicle, &evaluation.adversary);
    ([&key.reward, &key.town, &key.policy, pedestrian, town, policy, vehicle, adversary], evaluation.block)
}

/// The columns of [`names`].
pub const NAMES: [&str; 8] =
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
