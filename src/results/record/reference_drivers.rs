//! What the reference drivers did in each episode: the table `reference_drivers`.
//!
//! In memory and in the store an episode's row has these columns for each of them, `cc_avoids` and so on; the table has a row for each instead.

use polars::prelude::{Column as Values, DataFrame, IdxCa, NamedFrom, PolarsResult};

use super::columns::{AVOIDS, EPISODE, FALSE_BRAKE, FALSE_STOP, MARGIN, MOVED, RUN_ID, SPEED_REDUCTION};
use super::{Column, ColumnReference, Entry, TableReference};
use world::judge::{FalseAlarms, Reference, Trial, Verdict};

/// The stem of the files of the table.
pub const REFERENCE_DRIVERS: &str = "reference_drivers";

const DRIVER: Column<String> = Column::new(
    "driver",
    "",
    "the reference driver, see [Was it avoidable?](#was-it-avoidable): `cc`, `cc_attentive` and so on",
);

/// Its columns of a verdict and of false alarms, for a table whose rows may have either.
pub fn reference_columns<'t, R>(
    verdict: impl Fn(&R) -> Option<Verdict> + Copy + 't,
    alarms: impl Fn(&R) -> Option<FalseAlarms> + Copy + 't,
) -> Vec<Entry<'t, R>> {
    let of = |reference: Reference| {
        let name = reference.name();
        let trial = move |verdict: &Verdict| *verdict.trial(reference);
        let margin =
            move |verdict: &Verdict| Some(trial(verdict)).filter(Trial::is_avoided).map(|trial| trial.least_gap);
        [
            AVOIDS.of(name, move |row| verdict(row).map(|verdict| trial(&verdict).is_avoided())),
            MOVED.of(name, move |row| verdict(row).map(|verdict| trial(&verdict).moved)),
            MARGIN.of(name, move |row| verdict(row).and_then(|verdict| margin(&verdict))),
            SPEED_REDUCTION.of(name, move |row| verdict(row).map(|verdict| verdict.reduction(reference))),
            FALSE_BRAKE.of(name, move |row| alarms(row).map(|alarms| alarms.braked(reference))),
            FALSE_STOP.of(name, move |row| alarms(row).map(|alarms| alarms.stopped(reference))),
        ]
    };
    Reference::ALL.into_iter().flat_map(of).collect()
}

/// The names of these columns for a reference driver.
fn names(reference: Reference) -> [String; 6] {
    let name = reference.name();
    [
        AVOIDS.name(name),
        MOVED.name(name),
        MARGIN.name(name),
        SPEED_REDUCTION.name(name),
        FALSE_BRAKE.name(name),
        FALSE_STOP.name(name),
    ]
}

/// Whether a column of episodes is in this table instead of the table of episodes.
pub fn is_of_reference_driver(column: &str) -> bool {
    Reference::ALL.into_iter().any(|reference| names(reference).iter().any(|name| name == column))
}

/// A row for each reference driver of each collision, and of each other episode in which it would have braked needlessly, of a table that has
/// their columns.
///
/// # Errors
/// A column is missing.
pub fn reference_drivers(episodes: &DataFrame) -> PolarsResult<DataFrame> {
    let mut all = DataFrame::default();
    for reference in Reference::ALL {
        let mut of_driver = episodes.select([RUN_ID.name, EPISODE.name])?;
        of_driver.with_column(Values::new(DRIVER.name.into(), vec![reference.name(); episodes.height()]))?;
        for (column, name) in references().columns[3..].iter().zip(names(reference)) {
            of_driver.with_column(episodes.column(&name)?.clone().with_name(column.name.as_ref().into()))?;
        }
        all = if all.width() == 0 { of_driver } else { all.vstack(&of_driver)? };
    }
    let (rows, drivers) = (episodes.height() as u32, Reference::COUNT as u32);
    let (avoids, braked) = (bare(AVOIDS.name("")), bare(FALSE_BRAKE.name("")));
    let judged = all.column(&avoids)?.is_not_null();
    let braked = all.column(&braked)?.bool()?;
    let known = |place: &u32| judged.get(*place as usize) == Some(true) || braked.get(*place as usize) == Some(true);
    let places = (0..rows).flat_map(|row| (0..drivers).map(move |driver| driver * rows + row)).filter(known);
    all.take(&IdxCa::new("".into(), places.collect::<Vec<_>>()))
}

/// The name of a family without the name of a member.
fn bare(name: String) -> String {
    name.trim_start_matches('_').to_owned()
}

/// The documentation of the table.
pub fn references() -> TableReference {
    let of =
        |reference: ColumnReference| ColumnReference { name: bare(reference.name.into_owned()).into(), ..reference };
    let columns = vec![
        RUN_ID.reference(),
        ColumnReference { doc: "number of the episode, or of the failure of a search".into(), ..EPISODE.reference() },
        DRIVER.reference(),
        of(AVOIDS.reference("")),
        of(MOVED.reference("")),
        of(MARGIN.reference("")),
        of(SPEED_REDUCTION.reference("")),
        of(FALSE_BRAKE.reference("")),
        of(FALSE_STOP.reference("")),
    ];
    TableReference {
        name: REFERENCE_DRIVERS,
        doc: "One row for each reference driver of each collision and of each failure of a search, and of each other episode in which it would have \
              braked needlessly.",
        columns,
    }
}
