//! All tables of a report with their columns.

use super::failure_table::failure_table;
use super::metric_table::metric_table_reference;
use super::{actors, aggregate, infer};
use crate::jobs::KINDS;
use crate::record::{TableReference, episode_references};

/// The tables of a report with their columns, in the order of `reports/README.md`.
pub fn catalogue() -> Vec<TableReference> {
    let mut all = vec![
        aggregate::results_table().reference(),
        metric_table_reference(),
        episode_references(),
        failure_table().reference(),
        aggregate::requirement_table().reference(),
        infer::comparison_table().reference(),
    ];
    all.extend(KINDS.iter().flat_map(|kind| (kind.references)()));
    all.extend([
        actors::actor_reference(),
        aggregate::protocol_table().reference(),
        aggregate::tick_table().reference(),
    ]);
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fmt::Write;
    use std::path::Path;

    use super::*;
    use crate::record::ColumnReference;
    use crate::report::metric_table::{METRICS, metric_references};

    /// The part of `reports/README.md` that is generated here.
    const MARKS: (&str, &str) = ("<!-- columns: written by a test -->\n", "<!-- end of columns -->\n");

    /// The reference of all columns of reports as Markdown: those that several tables have, once, then a heading and a list for each table.
    fn column_reference() -> String {
        let tables: Vec<TableReference> =
            catalogue().into_iter().filter(|table| table.name != aggregate::tick_table().name).collect();
        let is_shared = |column: &ColumnReference| {
            let is_same = |other: &ColumnReference| (&other.name, &other.doc) == (&column.name, &column.doc);
            tables.iter().filter(|table| table.columns.iter().any(is_same)).count() > 1
        };
        let mut shared: Vec<ColumnReference> = Vec::new();
        for column in tables.iter().flat_map(|table| &table.columns).filter(|column| is_shared(column)) {
            if shared.iter().all(|known| known.name != column.name || known.doc != column.doc) {
                shared.push(column.clone());
            }
        }
        let mut text = "### Columns of several tables\n\n".to_owned();
        list(&mut text, &shared);
        for table in &tables {
            let _ = write!(text, "### `{}`\n\n{}\n\n", table.name, table.doc);
            let (common, own): (Vec<_>, Vec<_>) = table.columns.iter().cloned().partition(|column| is_shared(column));
            let names: Vec<String> = common.iter().map(|column| format!("`{}`", column.name)).collect();
            let _ = write!(text, "Of several tables: {}.\n\n", names.join(", "));
            list(&mut text, &own);
            if table.name == METRICS {
                text.push_str("The metrics:\n\n");
                list(&mut text, &metric_references());
            }
        }
        text
    }

    /// A list of names with their meanings, as far as the first sentence or semicolon: `falsify explain` has all. Consecutive ones of one meaning share
    /// a line.
    fn list(text: &mut String, all: &[ColumnReference]) {
        for group in all.chunk_by(|one, next| one.doc == next.doc) {
            let names: Vec<String> = group.iter().map(|each| format!("`{}`", each.name)).collect();
            let first = group[0].doc.split(". ").flat_map(|sentence| sentence.split("; ")).next().unwrap_or_default();
            let _ = writeln!(text, "- {}: {first}", names.join(", "));
        }
        text.push('\n');
    }

    #[test]
    fn the_page_about_reports_has_the_reference_of_all_columns() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reports/README.md");
        let page = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = page.split_once(MARKS.0).expect("the page has the mark of the columns");
        let (written, after) = rest.split_once(MARKS.1).expect("the page has the mark of their end");
        let wanted = column_reference();
        if std::env::var_os("UPDATE_REFERENCE").is_some() {
            std::fs::write(&path, format!("{before}{}{wanted}{}{after}", MARKS.0, MARKS.1)).unwrap();
        } else {
            assert_eq!(written, wanted, "run the test again with UPDATE_REFERENCE=1");
        }
    }

    #[test]
    fn a_table_has_no_column_twice_and_every_column_is_explained() {
        for table in catalogue() {
            let mut names = BTreeSet::new();
            for column in &table.columns {
                assert!(names.insert(column.name.clone()), "{} twice in {}", column.name, table.name);
                assert!(!column.doc.is_empty() && !column.doc.contains('|'), "{} of {}", column.name, table.name);
            }
        }
    }
}
