//! How the requirements of a campaign fared in an episode, as a column of stored episodes.

use polars::prelude::{Column as Values, DataFrame, PolarsResult};

use super::{Column, EpisodeRow};
use world::requirement::Degree;

/// The column of the degrees in stored episodes of a campaign with requirements; no file of a report has it.
pub const DEGREES: Column<String> = Column::new(
    "degrees",
    "",
    "the degree of each requirement: robustness, sample and part, as `-0.25@31#0`; missing of an episode in error",
);

/// The degrees of an episode as text, from which [`parse`] reads the same bits; none without any.
fn text(degrees: &[Degree]) -> Option<String> {
    (!degrees.is_empty()).then(|| degrees.iter().map(Degree::to_string).collect::<Vec<_>>().join(";"))
}

/// The degrees of an episode; none where the text has another form.
pub fn parse(text: &str) -> Option<Vec<Degree>> {
    text.split(';').map(|one| one.parse().ok()).collect()
}

/// Adds the column to episodes if one of them has degrees.
pub(super) fn add(table: &mut DataFrame, rows: &[EpisodeRow]) -> PolarsResult<()> {
    if rows.iter().any(|row| !row.degrees.is_empty()) {
        table.with_column(DEGREES.of(|row: &EpisodeRow| text(&row.degrees)).values(rows))?;
    }
    Ok(())
}

/// Gives a table the column, without values, if it lacks it.
///
/// # Errors
/// Those of polars; none for a table of episodes.
pub fn with_degrees(table: &mut DataFrame) -> PolarsResult<()> {
    if table.get_column_index(DEGREES.name).is_none() {
        let none = Values::full_null(DEGREES.name.into(), table.height(), &polars::prelude::DataType::String);
        table.with_column(none)?;
    }
    Ok(())
}

/// Appends rows to a table, of which either may lack the column.
pub(super) fn append(table: &mut DataFrame, mut rows: DataFrame) -> PolarsResult<()> {
    if table.width() != rows.width() {
        with_degrees(table)?;
        with_degrees(&mut rows)?;
    }
    table.vstack_mut(&rows)?;
    table.rechunk_mut();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_return_bit_for_bit() {
        let degree = |robustness, sample, part| Degree { robustness, sample, part };
        let all = [
            degree(-0.1 - 0.2, 31, Some(0)),
            degree(-0.0, 0, Some(65535)),
            degree(f64::INFINITY, u32::MAX, None),
            degree(f64::MIN_POSITIVE, 7, Some(2)),
        ];
        let read = parse(&text(&all).unwrap()).unwrap();
        let bits = |all: &[Degree]| all.iter().map(|each| each.robustness.to_bits()).collect::<Vec<_>>();
        assert_eq!((read.as_slice(), bits(&read)), (&all[..], bits(&all)));
        assert_eq!((text(&[]), parse("x@1"), parse("1@1#")), (None, None, None));
    }
}
