use polars::prelude::{DataFrame, PolarsResult};

use crate::failure::{Failure, FoundBy, Violation};
use crate::record::columns::{EPISODE, EPISODE_LENGTH, OUTCOME, RUN_ID, TICKS};
use crate::record::episodes::named;
use crate::record::{CellKey, Column, DEGREES, EpisodeTable, RunKey, Signed, Table, parse_degrees};
use crate::tables::{Method, Rate};
use base::statistics::{ClusteredCount, wilson};
use episode::requirement::{Degree, NamedRequirement};
use verdict::{JudgedDegree, NoVerdict, ViolationVerdict};

/// The stem of the files of the table of requirements.
pub const REQUIREMENTS: &str = "requirements";

pub const REQUIREMENT: Column<String> = Column::new("requirement", "", "name of the requirement");
pub const VIOLATED: Column<bool> = Column::new("violated", "", "whether the episode violates it");
pub const APPLIES: Column<bool> = Column::new(
    "applies",
    "",
    "whether the antecedent of an `implies` of the requirement held in a sample; where it never did, the episode says nothing about the requirement",
);
pub const ROBUSTNESS: Column<f64> = Column::new(
    "robustness",
    "as `unit`",
    "how far it is from being violated, below 0 (or -0) where it is; infinite where only conditions without degree decide",
);
pub const ROBUSTNESS_UNIT: Column<String> =
    Column::new("unit", "", "unit of the robustness; empty where it is scaled, and of plain numbers");
pub const INSTANT: Column<f64> =
    Column::new("instant_s", "s", "time from the start of the episode to the sample that decides");
pub const PART: Column<String> = Column::new("part", "", "the comparison that decides, as the scenario writes it");
/// A requirement in an episode.
pub struct RequirementRow {
    pub key: RunKey,
    pub episode: u32,
    pub degree: Degree,
    pub violation: Violation,
    pub instant: f64,
    pub counts: bool,
    /// Whose fault a violation is.
    pub verdict: Option<ViolationVerdict>,
    /// Length of the episode (s).
    pub length: f64,
}

impl RequirementRow {
    /// The failure, if it is violated.
    pub fn failure(&self) -> Failure {
        Failure {
            foreseeable: self.verdict.is_some_and(|verdict| verdict.foreseeable),
            fault: self.verdict.is_some_and(|verdict| verdict.fault),
            length: self.instant,
            episode_length: Some(self.length),
            violation: Some(self.violation.clone()),
            ..Failure::new(self.key.clone(), FoundBy::Evaluation, self.episode.into())
        }
    }
}

/// The columns of the table of requirements.
pub fn requirement_table<'a>() -> Table<'a, RequirementRow> {
    Table::new(
        REQUIREMENTS,
        "One row for each episode without error and each requirement of the campaign; `episodes` has the episode of `run_id` and `episode`, `failures` more of a violation. Campaigns \
         without requirements do not have it.",
    )
    .column(RUN_ID.of(|row: &RequirementRow| row.key.id.to_string()))
    .column(EPISODE.of(|row: &RequirementRow| row.episode))
    .column(REQUIREMENT.of(|row: &RequirementRow| row.violation.requirement.clone()))
    .column(VIOLATED.of(|row: &RequirementRow| row.degree.is_violated()))
    .column(APPLIES.of(|row: &RequirementRow| row.degree.applies))
    .column(ROBUSTNESS.of(|row: &RequirementRow| Signed(Some(row.degree.robustness))))
    .column(ROBUSTNESS_UNIT.of(|row: &RequirementRow| row.violation.unit.clone()))
    .column(INSTANT.of(|row: &RequirementRow| row.instant))
    .column(PART.of(|row: &RequirementRow| row.violation.part.clone()))
}

/// The rows of a part of the table of episodes, with the length of a tick (s).
///
/// # Errors
/// A column is missing or holds something else.
pub fn requirement_rows(
    requirements: &[NamedRequirement],
    part: &DataFrame,
    tick: f64,
) -> PolarsResult<Vec<RequirementRow>> {
    let (table, degrees) = (EpisodeTable::new(part)?, DEGREES.read(part)?);
    let (outcomes, ticks, lengths) = (OUTCOME.read(part)?, TICKS.read(part)?, EPISODE_LENGTH.read(part)?);
    let mut rows = Vec::new();
    for row in table.rows() {
        let Some(degrees) = degrees.get(row).and_then(parse_degrees) else { continue };
        let key = RunKey::read(part, row)?;
        let last = ticks.get(row).unwrap_or_default();
        let length = lengths.get(row).unwrap_or_default();
        for (named, JudgedDegree { degree, verdict }) in requirements.iter().zip(degrees) {
            let at_collision = outcomes.get(row) == Some(named::COLLISION) && degree.sample == last;
            rows.push(RequirementRow {
                key: key.clone(),
                episode: table.episode(row),
                degree,
                violation: Violation { at_collision, ..Violation::new(named, &degree, verdict) },
                instant: degree.instant(tick).min(length),
                counts: table.counts(row),
                verdict,
                length,
            });
        }
    }
    Ok(rows)
}

/// The violations of a requirement in the episodes of a run that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Violations {
    pub episodes: u32,
    /// Those in which it applied.
    pub applied: u32,
    pub violated: u32,
    /// Those that both careful humans would not have made.
    pub preventable: u32,
    /// Those that count against the driver.
    pub faults: u32,
}

impl Violations {
    /// Counts an episode.
    pub fn add(&mut self, row: &RequirementRow) {
        self.episodes += 1;
        self.applied += u32::from(row.degree.applies);
        self.violated += u32::from(row.degree.is_violated());
        self.preventable += u32::from(row.verdict.is_some_and(|verdict| verdict.preventable));
        self.faults += u32::from(row.verdict.is_some_and(|verdict| verdict.fault));
    }
}

/// Which violations are counted.
pub type Counted = fn(&Violations) -> u32;

/// The violations of a requirement in a cell, run by run.
#[derive(Debug, Clone, PartialEq)]
pub struct CellRequirement {
    pub key: CellKey,
    pub name: String,
    /// Why its violations have no verdict; `None` if they have.
    pub no_verdict: Option<NoVerdict>,
    /// Whether its episodes are the cases of a test: its rates have no interval.
    pub is_fixed_cases: bool,
    pub runs: Vec<Violations>,
}

impl CellRequirement {
    /// All violations.
    pub const ALL: Counted = |run| run.violated;
    /// The preventable ones.
    pub const PREVENTABLE: Counted = |run| run.preventable;
    /// The faults.
    pub const FAULTS: Counted = |run| run.faults;

    /// Whether its violations have a verdict.
    pub fn is_judged(&self) -> bool {
        self.no_verdict.is_none()
    }

    /// The episodes that count, of all runs.
    pub fn episodes(&self) -> u32 {
        self.runs.iter().map(|run| run.episodes).sum()
    }

    /// What is counted, and the episodes in which it applied, of all runs: those of the others say nothing about it.
    pub fn sums(&self, counted: Counted) -> (u32, u32) {
        self.runs.iter().fold((0, 0), |(part, whole), run| (part + counted(run), whole + run.applied))
    }

    /// The rate of violations in the episodes in which it applied, with Wilson's interval over the starts, which all runs share; no value if it never did.
    pub fn rate(&self, counted: Counted) -> Rate {
        let (part, whole) = self.sums(counted);
        if whole == 0 {
            return Rate::default();
        }
        let of_run = |run: &Violations| f64::from(counted(run)) / f64::from(run.applied);
        let by_run: Vec<f64> = self.runs.iter().filter(|run| run.applied > 0).map(of_run).collect();
        let of_runs = |count: u32| ClusteredCount::from(u64::from(count)).of_clusters(by_run.len() as f64);
        let interval = (!self.is_fixed_cases).then(|| wilson(of_runs(part), of_runs(whole)));
        Rate::of_runs(by_run).within(interval, Method::Wilson)
    }
}

/// Adds the rows of a run to the cells.
pub fn add_run(
    cells: &mut Vec<CellRequirement>,
    key: &CellKey,
    requirements: &[NamedRequirement],
    counts: &[Violations],
    is_fixed_cases: bool,
) {
    for (named, count) in requirements.iter().zip(counts) {
        // The runs of a cell follow each other, and so do its requirements.
        let mut last = cells.iter_mut().rev().take(requirements.len());
        match last.find(|cell| cell.key == *key && cell.name == *named.name) {
            Some(cell) => cell.runs.push(*count),
            None => cells.push(CellRequirement {
                key: key.clone(),
                name: named.name.to_string(),
                no_verdict: NoVerdict::of(&named.requirement),
                is_fixed_cases,
                runs: vec![*count],
            }),
        }
    }
}

/// The rates of a requirement that gates know: the word before its name, what it counts, and whether that needs a verdict.
pub const GATED: [(&str, Counted, bool); 2] =
    [("violation_rate", CellRequirement::ALL, false), ("fault_rate", CellRequirement::FAULTS, true)];
