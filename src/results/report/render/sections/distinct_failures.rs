use crate::report::render::table::{Column, Depth, Section, Table, Value};
use crate::report::{DistinctFailure, Findings, MAX_SHRUNK};
use verdict::cause::Cause;

/// Each distinct failure once, with its cause; `None` without a failure.
pub fn distinct_failures(found: &Findings<'_>) -> Option<Section> {
    let row = |DistinctFailure { failure, merged, alike, cause, .. }: &DistinctFailure| {
        vec![
            Value::text(failure.key.cell.policy.clone()),
            failure.word().into(),
            failure.kind().into(),
            Value::Count(*merged as u64),
            Value::Count(*alike as u64),
            Value::failure(failure.name()),
            cause.as_ref().map_or_else(|| "–".into(), Cause::sentence).into(),
        ]
    };
    let mut head = ["driver", "verdict", "kind"].map(Column::text).to_vec();
    head.extend(["failures", "alike"].map(Column::number));
    head.extend(["the first", "cause"].map(Column::text));
    let shown = found.distinct.iter().map(row).collect();
    (!found.distinct.is_empty()).then(|| Section {
        id: "distinct",
        name: "Distinct failures",
        title: "Distinct failures",
        depth: Depth::Summary,
        tables: vec![Table { head, rows: shown, ..Table::default() }],
        notes: vec![format!(
            "The first {MAX_SHRUNK} failures, shrunk to the fewest commands that 600 runs find, if driver and simulator are built in; those of one kind are one row, with the cause of the first. *Alike* are the failures of its driver's list that are in its cluster: the same side and action, \
             and near in speed, time in sight and latest reaction (DBSCAN). The worst of each cluster comes first. \
             `falsify failures REPORT --distinct --why` has all."
        )],
        ..Section::default()
    })
}
