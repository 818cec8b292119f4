use crate::report::render::table::{Depth, Section, Selection, Value};
use crate::report::{DistinctFailure, Findings, MAX_SHRUNK};
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
    (!found.distinct.is_empty()).then(|| Section {
        id: "distinct",
        name: "Distinct failures",
        title: "Distinct failures",
        depth: Depth::Summary,
        tables: vec![shown.table(&found.distinct)],
        notes: vec![format!(
            "The first {MAX_SHRUNK} failures, shrunk to the fewest commands that 600 runs find, if driver and simulator are built in; those of one kind are one row, with the cause of the first. *Alike* are the failures of its driver's list that are in its cluster: the same side and action, \
             and near in speed, time in sight and latest reaction (DBSCAN). The worst of each cluster comes first. \
             `falsify failures REPORT --distinct --why` has all."
        )],
        ..Section::default()
    })
}
