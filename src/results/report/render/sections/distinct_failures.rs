use crate::report::render::table::{Depth, Section, Selection, Table, Value};
use crate::report::{DistinctFailure, DriverResult, Findings, MAX_SHRUNK};
use verdict::cause::Cause;

/// Each distinct failure once, with its cause; `None` without a failure.
pub fn distinct_failures(found: &Findings<'_>) -> Option<Section> {
    let shown = Selection::new()
        .text("driver", |found: &DistinctFailure| found.failure.key.cell.policy.clone())
        .text("verdict", |found| found.failure.word())
        .text("kind", |found| found.failure.kind())
        .number("failures", |found| found.merged)
        .number("alike", |found| found.alike)
        .text("the first", |found| Value::failure(found.failure.name()))
        .text("cause", |found| found.cause.as_ref().map(Cause::sentence));
    let of_programs = of_programs(found);
    let tables: Vec<Table> =
        Some(shown.table(&found.distinct)).filter(|table| !table.rows.is_empty()).into_iter().collect();
    (!tables.is_empty() || !of_programs.is_empty()).then(|| Section {
        lead: of_programs,
        id: "distinct",
        name: "Distinct failures",
        title: "Distinct failures",
        depth: Depth::Summary,
        notes: tables.iter().map(|_| format!(
            "The first {MAX_SHRUNK} failures, shrunk to the fewest commands that 600 runs find, if driver and simulator are built in; those of one kind are one row, with the cause of the first. *Alike* are the failures of its driver's list that are in its cluster: the same side and action, \
             and near in speed, time in sight and latest reaction (DBSCAN). The worst of each cluster comes first. \
             `falsify failures REPORT --distinct --why` has all."
        )).collect(),
        tables,
        ..Section::default()
    })
}

/// What explains the failures of drivers that are programs of the user, which may take long to start.
fn of_programs(found: &Findings<'_>) -> Vec<String> {
    let of = |result: &DriverResult| {
        let driver = &result.driver.name;
        let failures = found.gathered.failures.of(driver).len();
        (failures > 0).then(|| {
            format!(
                "`{driver}` has failures from {failures} starts that are not analysed here, which would start its program again: \
                 `falsify failures REPORT --driver {driver} --allow-external --why`."
            )
        })
    };
    found.drivers.iter().filter(|result| result.driver.is_external()).filter_map(of).collect()
}
