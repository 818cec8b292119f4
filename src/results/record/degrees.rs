//! How the requirements of a campaign fared in an episode, as a column of stored episodes.

use polars::prelude::{Column as Values, DataFrame, PolarsResult};

use super::{Column, EpisodeRow};
use verdict::{JudgedDegree, ViolationVerdict};

/// The column of the degrees in stored episodes of a campaign with requirements; no file of a report has it.
pub const DEGREES: Column<String> = Column::new(
    "degrees",
    "",
    "the degree of each requirement: robustness, sample and part, as `-0.25@31#0`, `~` if it never applied, and of a violation the verdict: `!`, `p` if it is preventable, `f` if \
     it is foreseeable, `x` if it is a fault, and the sample at which the danger starts; missing of an episode in error",
);

/// The degree of a requirement, with the verdict on its violation, as text.
fn degree_text(JudgedDegree { degree, verdict }: &JudgedDegree) -> String {
    let Some(ViolationVerdict { preventable, foreseeable, fault, danger }) = *verdict else {
        return degree.to_string();
    };
    let letter = |is: bool, letter: &'static str| if is { letter } else { "" };
    let letters = [letter(preventable, "p"), letter(foreseeable, "f"), letter(fault, "x")].concat();
    format!("{degree}!{letters}{danger}")
}

fn parse_degree(text: &str) -> Option<JudgedDegree> {
    let Some((degree, verdict)) = text.split_once('!') else {
        return Some(JudgedDegree { degree: text.parse().ok()?, verdict: None });
    };
    let letters = verdict.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let has = |letter: char| letters.contains(letter);
    let verdict = ViolationVerdict {
        preventable: has('p'),
        foreseeable: has('f'),
        fault: has('x'),
        danger: verdict[letters.len()..].parse().ok()?,
    };
    Some(JudgedDegree { degree: degree.parse().ok()?, verdict: Some(verdict) })
}

/// The degrees of an episode as text, from which [`parse`] reads the same bits; `None` without any.
fn text(degrees: &[JudgedDegree]) -> Option<String> {
    (!degrees.is_empty()).then(|| degrees.iter().map(degree_text).collect::<Vec<_>>().join(";"))
}

/// The degrees of an episode; `None` if the text has another form.
pub fn parse(text: &str) -> Option<Vec<JudgedDegree>> {
    text.split(';').map(parse_degree).collect()
}

/// Adds the column to episodes if one of them has degrees.
pub(super) fn add(table: &mut DataFrame, rows: &[EpisodeRow]) -> PolarsResult<()> {
    if rows.iter().any(|row| !row.judged.degrees.is_empty()) {
        table.with_column(DEGREES.of(|row: &EpisodeRow| text(&row.judged.degrees)).values(rows))?;
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
    use episode::requirement::Degree;

    #[test]
    fn degrees_and_verdicts_return_bit_for_bit() {
        let degree = |robustness, sample, part, verdict| JudgedDegree {
            degree: Degree { robustness, sample, part, applies: true },
            verdict,
        };
        let verdict = |preventable, foreseeable, fault, danger| {
            Some(ViolationVerdict { preventable, foreseeable, fault, danger })
        };
        let never = JudgedDegree { degree: Degree { applies: false, ..Degree::constant(true, 3) }, verdict: None };
        let all = [
            never,
            degree(-0.1 - 0.2, 31, Some(0), verdict(true, true, true, 12)),
            degree(-0.0, 0, Some(65535), verdict(false, false, false, 0)),
            degree(f64::INFINITY, u32::MAX, None, None),
            degree(f64::NEG_INFINITY, 7, Some(2), verdict(true, false, false, u32::MAX)),
            degree(f64::MIN_POSITIVE, 7, Some(2), None),
        ];
        let read = parse(&text(&all).unwrap()).unwrap();
        let bits = |all: &[JudgedDegree]| all.iter().map(|each| each.degree.robustness.to_bits()).collect::<Vec<_>>();
        assert_eq!((read.as_slice(), bits(&read)), (&all[..], bits(&all)));
        assert_eq!((text(&[]), parse("x@1"), parse("1@1#"), parse("1@1#0!p")), (None, None, None, None));
    }
}
