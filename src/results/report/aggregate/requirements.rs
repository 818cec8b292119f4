use polars::prelude::{Column as Values, DataFrame, PolarsResult};

use super::{Method, Rate};
use crate::record::columns::{EPISODE, EPISODE_LENGTH, OUTCOME, TICKS};
use crate::record::columns::{RUN, RUN_ID};
use crate::record::episodes::named;
use crate::record::{CellKey, Column, ColumnReference, DEGREES, EpisodeTable, RunKey, Table, cell_key, parse_degrees};
use base::statistics::{ClusteredCount, wilson};
use base::units::Dimension;
use world::judge::{NoVerdict, ViolationVerdict};
use world::requirement::{Degree, NamedRequirement};

/// The stem of the files of the table of requirements.
pub const REQUIREMENTS: &str = "requirements";

pub const REQUIREMENT: Column<String> = Column::new("requirement", "", "name of the requirement");
pub const PRIORITY: Column<u32> = Column::new("priority", "", "its rank in the scenario; 1 is the most important");
pub const VIOLATED: Column<bool> = Column::new("violated", "", "whether the episode violates it");
pub const ROBUSTNESS: Column<f64> = Column::new(
    "robustness",
    "as `unit`",
    "how far it is from being violated, below 0 (or -0) where it is; infinite where only conditions without degree decide",
);
pub const ROBUSTNESS_UNIT: Column<String> =
    Column::new("unit", "", "unit of the robustness; empty where it is scaled, and of plain numbers");
pub const SCALED: Column<bool> = Column::new(
    "scaled",
    "",
    "whether its comparisons have different dimensions, so that each is divided by its scale",
);
pub const INSTANT: Column<f64> =
    Column::new("instant_s", "s", "time from the start of the episode to the sample that decides");
pub const PART: Column<String> = Column::new("part", "", "the comparison that decides, as the scenario writes it");
pub const COUNTS: Column<bool> = Column::new("counts", "", "whether the episode is in rates");
pub const AT_COLLISION: Column<bool> =
    Column::new("at_collision", "", "whether that sample is the touch of a collision, which is a failure by itself");

pub const PREVENTABLE: Column<bool> = Column::new(
    "preventable",
    "",
    "of a violation, whether both careful humans satisfy the requirement from the start of the danger on; missing where there is no verdict",
);
/// Whether the pedestrian moved as people do.
pub const VIOLATION_FORESEEABLE: Column<bool> = Column::new(
    "foreseeable",
    "",
    "of a violation, whether the pedestrian moved as people do; missing where there is no verdict",
);
/// Whether a violation counts against the driver.
pub const VIOLATION_FAULT: Column<bool> = Column::new(
    "fault",
    "",
    "of a violation, whether it is both, and where the touch of a collision decides whether the collision is a fault; missing where there is no verdict",
);
pub const DANGER: Column<f64> = Column::new(
    "danger_s",
    "s",
    "of a violation, time from the start of the episode to the start of the danger; missing where there is no verdict",
);
pub const NO_VERDICT: Column<String> = Column::new(
    "no_verdict",
    "",
    "why the requirement has no verdict: `no_pedestrian` if it says nothing of one, `braking` if it says how hard the car brakes, which careful humans \
     never do less than the driver; empty if it has",
);

/// A requirement in an episode.
pub struct RequirementRow {
    pub key: RunKey,
    pub episode: u32,
    pub name: String,
    pub priority: u32,
    pub degree: Degree,
    pub unit: &'static str,
    pub is_scaled: bool,
    pub instant: f64,
    pub part: String,
    pub counts: bool,
    pub at_collision: bool,
    /// Whose fault a violation is.
    pub verdict: Option<ViolationVerdict>,
    /// The time of its danger (s).
    pub danger: Option<f64>,
    /// Why a violation has no verdict; empty if it has.
    pub no_verdict: &'static str,
}

/// The columns of the table of requirements.
pub fn requirement_table<'a>() -> Table<'a, RequirementRow> {
    Table::new(
        REQUIREMENTS,
        "One row for each episode without error and each requirement of the campaign. Campaigns without requirements do not have it.",
    )
    .column(RUN_ID.of(|row: &RequirementRow| row.key.id.to_string()))
    .columns(cell_key(|row: &RequirementRow| &row.key.cell))
    .column(RUN.of(|row: &RequirementRow| row.key.run))
    .column(EPISODE.of(|row: &RequirementRow| row.episode))
    .column(REQUIREMENT.of(|row: &RequirementRow| row.name.clone()))
    .column(PRIORITY.of(|row: &RequirementRow| row.priority))
    .column(VIOLATED.of(|row: &RequirementRow| row.degree.is_violated()))
    .column(ROBUSTNESS.of(|row: &RequirementRow| row.degree.robustness))
    .column(ROBUSTNESS_UNIT.of(|row: &RequirementRow| row.unit))
    .column(SCALED.of(|row: &RequirementRow| row.is_scaled))
    .column(INSTANT.of(|row: &RequirementRow| row.instant))
    .column(PART.of(|row: &RequirementRow| row.part.clone()))
    .column(COUNTS.of(|row: &RequirementRow| row.counts))
    .column(AT_COLLISION.of(|row: &RequirementRow| row.at_collision))
    .column(PREVENTABLE.of(|row: &RequirementRow| row.verdict.map(|verdict| verdict.preventable)))
    .column(VIOLATION_FORESEEABLE.of(|row: &RequirementRow| row.verdict.map(|verdict| verdict.foreseeable)))
    .column(VIOLATION_FAULT.of(|row: &RequirementRow| row.verdict.map(|verdict| verdict.fault)))
    .column(DANGER.of(|row: &RequirementRow| row.danger))
    .column(NO_VERDICT.of(|row: &RequirementRow| row.no_verdict))
}

/// Why violations of a requirement have no verdict; empty if they have.
pub fn no_verdict(named: &NamedRequirement) -> &'static str {
    NoVerdict::of(&named.requirement).map_or("", NoVerdict::name)
}

/// The unit of a requirement's robustness, in SI; empty where it is scaled, and of plain numbers.
pub fn unit_of(requirement: &NamedRequirement) -> &'static str {
    match requirement.requirement.dimension() {
        Some(Dimension::ANGLE) => "rad",
        Some(dimension) => dimension.usual_units().first().copied().unwrap_or_default(),
        None => "",
    }
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
    let reasons: Vec<&'static str> = requirements.iter().map(no_verdict).collect();
    let mut rows = Vec::new();
    for row in table.rows() {
        let Some(degrees) = degrees.get(row).and_then(parse_degrees) else { continue };
        let key = RunKey::read(part, row)?;
        let last = ticks.get(row).unwrap_or_default();
        let length = lengths.get(row).unwrap_or_default();
        for ((named, reason), judged) in requirements.iter().zip(&reasons).zip(degrees) {
            let (degree, verdict) = (judged.degree, judged.verdict);
            let parts = &named.requirement.parts;
            rows.push(RequirementRow {
                key: key.clone(),
                episode: table.episode(row),
                name: named.name.to_string(),
                priority: named.priority,
                degree,
                unit: unit_of(named),
                is_scaled: named.requirement.is_scaled(),
                instant: (f64::from(degree.sample) * tick).min(length),
                part: degree
                    .part
                    .and_then(|part| parts.get(usize::from(part)))
                    .map_or(String::new(), |part| part.text.clone()),
                counts: table.counts(row),
                at_collision: outcomes.get(row) == Some(named::COLLISION) && degree.sample == last,
                verdict,
                danger: verdict.map(|verdict| f64::from(verdict.danger) * tick),
                no_verdict: reason,
            });
        }
    }
    Ok(rows)
}

/// The violations of a requirement in the episodes of a run that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Violations {
    pub episodes: u32,
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

    /// Violations and episodes of all runs.
    pub fn sums(&self, counted: Counted) -> (u32, u32) {
        self.runs.iter().fold((0, 0), |(part, all), run| (part + counted(run), all + run.episodes))
    }

    /// The rate of violations, with Wilson's interval over the starts, which all runs share.
    pub fn rate(&self, counted: Counted) -> Rate {
        let of_run = |run: &Violations| f64::from(counted(run)) / f64::from(run.episodes);
        let by_run: Vec<f64> = self.runs.iter().filter(|run| run.episodes > 0).map(of_run).collect();
        let count = by_run.len() as f64;
        let value = (count > 0.0).then(|| by_run.iter().sum::<f64>() / count);
        let sd = value
            .filter(|_| count > 1.0)
            .map(|mean| (by_run.iter().map(|rate| (rate - mean) * (rate - mean)).sum::<f64>() / (count - 1.0)).sqrt());
        let (part, all) = self.sums(counted);
        let of_runs = |count: u32| ClusteredCount::from(u64::from(count)).of_clusters(self.runs.len() as f64);
        let interval = wilson(of_runs(part), of_runs(all));
        Rate { value, sd, by_run, ..Rate::default() }.within(Some(interval), Method::Wilson)
    }
}

/// Adds the rows of a run to the cells.
pub fn add_run(
    cells: &mut Vec<CellRequirement>,
    key: &CellKey,
    requirements: &[NamedRequirement],
    counts: &[Violations],
) {
    for (named, count) in requirements.iter().zip(counts) {
        match cells.iter_mut().find(|cell| cell.key == *key && cell.name == *named.name) {
            Some(cell) => cell.runs.push(*count),
            None => cells.push(CellRequirement {
                key: key.clone(),
                name: named.name.to_string(),
                no_verdict: NoVerdict::of(&named.requirement),
                runs: vec![*count],
            }),
        }
    }
}

/// The rates of a requirement that gates know: the word before its name, what it counts, whether that needs a verdict, and what it means.
pub const GATED: [(&str, Counted, bool, &str); 2] = [
    (
        "violation_rate",
        CellRequirement::ALL,
        false,
        "episodes that violate the requirement of all *episodes*, with Wilson's 95 % interval",
    ),
    (
        "fault_rate",
        CellRequirement::FAULTS,
        true,
        "violations that count against the driver of all *episodes*, with Wilson's 95 % interval; missing where the requirement has no verdict",
    ),
];

/// The columns of the rates of a requirement that gates know: each rate, and both ends of its interval.
pub fn rate_columns(requirement: &str) -> Vec<ColumnReference> {
    let columns = |(word, _, _, doc): (&'static str, Counted, bool, &'static str)| {
        ["", "_wilson_low", "_wilson_high"].map(|suffix| ColumnReference {
            name: format!("{word}({requirement}){suffix}").into(),
            unit: "".into(),
            doc: doc.into(),
            holds: polars::prelude::DataType::Float64,
        })
    };
    GATED.into_iter().flat_map(columns).collect()
}

/// Adds the columns of gates to the table of cells.
///
/// # Errors
/// Those of polars; none for cells in the order of the table.
pub fn with_rates(table: DataFrame, keys: &[&CellKey], cells: &[CellRequirement]) -> PolarsResult<DataFrame> {
    let mut names: Vec<&str> = Vec::new();
    for cell in cells {
        if !names.contains(&cell.name.as_str()) {
            names.push(&cell.name);
        }
    }
    let mut table = table;
    for name in names {
        let of = |value: &dyn Fn(&CellRequirement) -> Option<f64>| -> Vec<Option<f64>> {
            let found = |key: &&CellKey| cells.iter().find(|cell| cell.key == **key && cell.name == name);
            keys.iter().map(|key| found(key).and_then(value)).collect()
        };
        for (word, counted, needs_verdict, _) in GATED {
            let is_known = |cell: &CellRequirement| !needs_verdict || cell.is_judged();
            for (suffix, values) in [
                ("", of(&|cell| cell.rate(counted).value.filter(|_| is_known(cell)))),
                ("_wilson_low", of(&|cell| Some(cell.rate(counted).interval.filter(|_| is_known(cell))?.0))),
                ("_wilson_high", of(&|cell| Some(cell.rate(counted).interval.filter(|_| is_known(cell))?.1))),
            ] {
                table.with_column(Values::new(format!("{word}({name}){suffix}").into(), values))?;
            }
        }
    }
    Ok(table)
}
