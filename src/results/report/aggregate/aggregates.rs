use std::collections::{BTreeMap, BTreeSet};

use polars::prelude::{DataFrame, PolarsResult};

use super::protocol::{ProtocolCell, ProtocolRun};
use super::requirements::{REQUIREMENTS, RequirementRow, judged_table, requirement_rows, requirement_table};
use super::{Episodes, Failures, Run};
use crate::failure::Failure;
use crate::jobs::SearchResult;
use crate::record::{self, CellKey, EPISODES, EpisodeTable};
use crate::report::failure_table::{FAILURES, failure_table};
use crate::report::repeats::{Repeats, start_bits};
use crate::report::{Evidence, EvidenceBuilder, ReportFolder, Starts, Tally, WriteError};
use crate::tables::{Cells, Runs};
use compile::{ControllerKind, Evaluation, Planned};

/// The results of one pass over all episodes: small tables, counts, and a bounded sample.
#[derive(Debug, Clone, Default)]
pub struct Aggregates {
    pub cells: Cells,
    /// What differs from these in the reward of an untrained pedestrian alone.
    pub copies: Cells,
    /// Episodes, those in error included.
    pub episodes: u64,
    /// Their simulator ticks.
    pub ticks: u64,
    /// Whether every evaluation has all its episodes.
    pub all_tried: bool,
    /// Episodes in error.
    pub errors: u64,
    /// The number of these that were not run, because of a limit or of an earlier error.
    pub untried: u64,
    /// Those of the errors that are of another simulator, and the episodes in one.
    pub of_worlds: (u64, u64),
    /// The place of the first error, and the error.
    pub first_error: Option<String>,
    /// Episodes whose reward is not a number.
    pub unpaid: u64,
    /// The place of the first of these.
    pub first_unpaid: Option<String>,
    /// Whether every driver reached the end of at least one episode in every town.
    pub every_driver_drove: bool,
    /// Intervals over trainings, comparisons on common starts, transfer gaps.
    pub evidence: Evidence,
    /// The starts of trained pedestrians, by town.
    pub starts: BTreeMap<String, Starts>,
    /// The data of the page on the episodes.
    pub tally: Tally,
    /// The worst failures of each driver in evaluations.
    pub failures: Failures,
    /// The results in the tests of a protocol.
    pub protocol: Vec<ProtocolCell>,
    /// The same by the cell of the campaign, with those that are equal.
    pub tests: Vec<(CellKey, Vec<ProtocolCell>)>,
    /// The violations of each requirement in each cell; empty without requirements.
    pub requirements: Cells,
}

/// Reads all episodes once: writes the tables `episodes`, `failures` and `requirements`, and gathers the data of all other outputs.
///
/// # Errors
/// A table that cannot be made or a file that cannot be written.
pub fn aggregate_episodes(
    folder: &ReportFolder,
    episodes: &Episodes<'_>,
    searches: &[SearchResult],
) -> Result<Aggregates, WriteError> {
    let failed = |source| WriteError::Table { name: EPISODES.into(), source };
    let mut gathered = Aggregates { all_tried: true, ..Aggregates::default() };
    let (mut evidence, mut runs, mut judged) = (EvidenceBuilder::default(), Runs::default(), Runs::of_requirements());
    let mut walked: BTreeSet<(CellKey, u32)> = BTreeSet::new();
    let mut drove: BTreeMap<(&str, &str), bool> = BTreeMap::new();
    let none = record::episodes(&[]);
    let columns: Vec<_> = record::episode_references().columns.into_iter().map(|column| column.name).collect();
    let own = |part: &DataFrame| part.select(columns.iter().map(AsRef::as_ref));
    let mut file = folder.stream(EPISODES, own(&none).map_err(failed)?.schema())?;
    let failed_table = failure_table();
    let mut failures = folder.stream(FAILURES, failed_table.frame(&[]).schema())?;
    let required = |evaluation: &Evaluation| !evaluation.scenario.requirements.is_empty();
    let table = requirement_table();
    let mut requirements = match episodes.runs().any(|run| required(run.evaluation)) {
        true => Some(folder.stream(REQUIREMENTS, table.frame(&[]).schema())?),
        false => None,
    };
    for run in episodes.runs() {
        let evaluation = run.evaluation;
        let named = &*evaluation.scenario.requirements;
        let mut protocol = ProtocolRun::new(evaluation);
        // A run of one part is decoded once, a longer one twice: it need not fit in memory.
        let single: Option<Vec<DataFrame>> =
            (evaluation.parts() == 1).then(|| run.parts().collect()).transpose().map_err(failed)?;
        let parts = || -> Box<dyn Iterator<Item = PolarsResult<DataFrame>>> {
            match &single {
                Some(parts) => Box::new(parts.iter().cloned().map(Ok)),
                None => Box::new(run.parts()),
            }
        };
        let mut repeats = Repeats::of(parts()).map_err(failed)?;
        let is_fixed_cases = protocol.is_some() || repeats.is_grid();
        let mut tried = 0;
        let is_copy = !walked.insert(run.key.of_any_reward());
        runs.begin(&run.key, is_fixed_cases, is_copy);
        judged.begin(&run.key, is_fixed_cases, is_copy);
        for part in parts() {
            let mut part = part.map_err(failed)?;
            tried += part.height();
            file.add(&own(&part).map_err(failed)?)?;
            let all = EpisodeTable::new(&part).map_err(failed)?;
            let drives = gathered.count(&run, &all);
            *drove.entry((&evaluation.town, &evaluation.policy)).or_default() |= drives;
            let is_new = |row: usize| !(all.counts(row) && repeats.repeats(start_bits(all.spawn(row))));
            let new: Vec<bool> = all.rows().map(is_new).collect();
            if let Some(protocol) = &mut protocol {
                protocol.add(&all, &new);
            }
            let mut degrees = Vec::new();
            if let Some(file) = &mut requirements {
                degrees = requirement_rows(named, &part, evaluation.scenario.episode.tick).map_err(failed)?;
                file.add(&table.frame(&degrees))?;
            }
            let touches = all.rows().filter(|row| all.counts(*row) && all.is_touch(*row));
            let touches = touches.map(|row| Failure::of_row(&all, row, run.key.clone()));
            let violated = degrees.iter().filter(|row| row.counts && row.degree.is_violated());
            let here: Vec<Failure> = touches.chain(violated.map(RequirementRow::failure)).collect();
            if !is_copy {
                failures.add(&failed_table.frame(&here))?;
            }
            if is_fixed_cases {
                part = part.filter(&new.into_iter().collect()).map_err(failed)?;
            }
            let episodes = EpisodeTable::new(&part).map_err(failed)?;
            if is_fixed_cases {
                let kept: BTreeSet<u32> = episodes.rows().map(|row| episodes.episode(row)).collect();
                degrees.retain(|row| kept.contains(&row.episode));
            }
            runs.add(&part).map_err(failed)?;
            if part.height() > 0 {
                evidence.add(&run.key, &part).map_err(failed)?;
            }
            if is_copy {
                continue;
            }
            gathered.tally.add(&run.key.cell, &episodes);
            if matches!(evaluation.controller, ControllerKind::Trained) {
                gathered.note_starts(evaluation, &episodes);
            }
            gathered.failures.add(&run.key, &episodes);
            judged.add(&judged_table().frame(&degrees)).map_err(failed)?;
            gathered.failures.add_violations(&degrees);
        }
        gathered.all_tried &= tried == evaluation.episodes as usize;
        if tried > 0 && !is_copy {
            let none: Vec<_> = named.iter().map(|named| RequirementRow::without_episode(&run.key, named)).collect();
            judged.add(&judged_table().frame(&none)).map_err(failed)?;
            let tested = protocol.map(|protocol| (run.key.cell.clone(), protocol.cells()));
            gathered.tests.extend(tested.clone());
            for cell in tested.into_iter().flat_map(|(_, cells)| cells) {
                // A target walks alike for every reward of the campaign; its cells are shown once. A case that one block ran is not missing in another.
                let all = &mut gathered.protocol;
                match all.iter().position(|known| cell.stands_for(known)) {
                    Some(place) => all[place] = cell,
                    None if all.iter().any(|known| known.stands_for(&cell) || known.repeats(&cell)) => {}
                    None => all.push(cell),
                }
            }
        }
    }
    gathered.every_driver_drove = drove.values().all(|drove| *drove);
    file.finish()?;
    let found: Vec<Failure> =
        searches.iter().flat_map(SearchResult::failures).map(|find| Failure::from(&find)).collect();
    failures.add(&failed_table.frame(&found))?;
    failures.finish()?;
    if let Some(file) = requirements {
        file.finish()?;
    }
    gathered.failures.add_searches(searches);
    [gathered.cells, gathered.copies] = runs.cells().map_err(failed)?;
    [gathered.requirements, _] = judged.cells().map_err(failed)?;
    gathered.evidence = evidence.finish();
    Ok(gathered)
}

/// The share of the episodes in other simulators that may be in error there: one has a car that leaves its road, or a scene that does not load, now and then.
const MAX_OF_WORLDS: f64 = 0.01;

impl Aggregates {
    /// Whether all errors are of other simulators, in few of the episodes there: a warning, and no failure of the run.
    pub fn errors_are_few(&self) -> bool {
        let (errors, episodes) = self.of_worlds;
        self.errors == errors && errors as f64 <= MAX_OF_WORLDS * episodes as f64
    }

    /// Counts the rows of a table of episodes; returns whether the driver reached the end of any.
    fn count(&mut self, run: &Run<'_>, table: &EpisodeTable<'_>) -> bool {
        let Evaluation { town, policy, trained, .. } = run.evaluation;
        let mut drives = false;
        let is_elsewhere = run.evaluation.scenario.external_world.is_some();
        self.of_worlds.1 += if is_elsewhere { table.rows().len() as u64 } else { 0 };
        for row in table.rows() {
            let (episode, ticks) = (table.episode(row), table.ticks(row));
            self.ticks += u64::from(ticks.unwrap_or_default());
            if let Some(error) = table.error(row) {
                self.errors += 1;
                self.of_worlds.0 += u64::from(error.starts_with("the world "));
                self.untried += u64::from(ticks.is_none());
                self.first_error.get_or_insert_with(|| match error.strip_prefix("the pedestrian ") {
                    Some(error) => format!("episode {episode} in {town}: {} {error}", run.evaluation.controller.name()),
                    None => format!("episode {episode} in {town}: {policy} {error}"),
                });
                continue;
            }
            drives = true;
            if let Some(reward) = table.reward(row).filter(|reward| !reward.is_finite()) {
                self.unpaid += 1;
                self.first_unpaid.get_or_insert_with(|| {
                    format!("`{}` was {reward} in episode {episode} in {town} against {policy}", trained.reward)
                });
            }
        }
        self.episodes += table.rows().len() as u64;
        drives
    }

    /// Records the starts of episodes of a run.
    fn note_starts(&mut self, evaluation: &Evaluation, table: &EpisodeTable<'_>) {
        let starts = self.starts.entry(evaluation.town.to_string()).or_default();
        for row in table.rows().filter(|row| table.counts(*row)) {
            let touch = table.is_touch(row).then(|| table.is_collision(row));
            let place = (&*evaluation.policy, evaluation.origin.block, table.episode(row));
            starts.add(place, table.spawn(row).pedestrian, touch);
        }
    }
}
