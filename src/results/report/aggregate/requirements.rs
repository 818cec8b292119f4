use polars::prelude::{DataFrame, PolarsResult};

use crate::failure::{Failure, FoundBy, Violation};
use crate::record::columns::{EPISODE, EPISODE_LENGTH, OUTCOME, RUN_ID, TICKS};
use crate::record::episodes::named;
use crate::record::{Column, DEGREES, EpisodeTable, RunKey, Signed, Table, parse_degrees};
use crate::tables::{APPLIES, COUNTS, IS_FAULT, IS_PREVENTABLE, NO_VERDICT, REQUIREMENT, VIOLATED};
use episode::requirement::{Degree, NamedRequirement};
use verdict::{JudgedDegree, NoVerdict, ViolationVerdict};

/// The stem of the files of the table of requirements.
pub const REQUIREMENTS: &str = "requirements";

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
    /// Why violations have no verdict; `None` if they have.
    pub no_verdict: Option<NoVerdict>,
    /// Length of the episode (s).
    pub length: f64,
}

impl RequirementRow {
    /// A requirement in a run before its first episode, so that it has a row also if none is judged.
    pub fn without_episode(key: &RunKey, named: &NamedRequirement) -> Self {
        let degree = Degree { applies: false, ..Degree::constant(true, 0) };
        Self {
            key: key.clone(),
            episode: 0,
            degree,
            violation: Violation::new(named, &degree, None),
            instant: 0.0,
            counts: false,
            verdict: None,
            no_verdict: NoVerdict::of(&named.requirement),
            length: 0.0,
        }
    }

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

/// What the metrics of requirements are made of.
pub fn judged_table<'a>() -> Table<'a, RequirementRow> {
    type Row = RequirementRow;
    Table::new("", "")
        .column(REQUIREMENT.of(|row: &Row| row.violation.requirement.clone()))
        .column(NO_VERDICT.of(|row: &Row| row.no_verdict.map(NoVerdict::name)))
        .column(COUNTS.of(|row: &Row| row.counts))
        .column(APPLIES.of(|row: &Row| row.degree.applies))
        .column(VIOLATED.of(|row: &Row| row.degree.is_violated()))
        .column(IS_PREVENTABLE.of(|row: &Row| row.verdict.is_some_and(|verdict| verdict.preventable)))
        .column(IS_FAULT.of(|row: &Row| row.verdict.is_some_and(|verdict| verdict.fault)))
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
                no_verdict: NoVerdict::of(&named.requirement),
                length,
            });
        }
    }
    Ok(rows)
}
