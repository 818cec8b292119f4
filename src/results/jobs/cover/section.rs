use super::Row;
use super::picture::pictures;
use crate::jobs::Said;
use crate::report::Findings;
use crate::report::table::{Column, Place, Section, Selection, Table, Value};

/// What covers show: a row for each driver and town; `None` without a cover.
pub fn covers(found: &Findings<'_>) -> Option<Section> {
    let rows: Vec<Row<'_>> = found.finished.found_if_any()?;
    let reading = [
        "The *box* are the ranges of the spawn rule; equal parts of it are equally likely. Places on the road, what the pedestrian draws and what drivers draw \
         are chance: a part of the bound, not of the box. A point of the box for which the road has no place counts as passed.",
        "The *picture* is a local regression over the episodes before the check. The *check* runs fresh episodes, uniform in the box, and counts those that fail \
         where the picture says that they pass. The bound is Clopper and Pearson's, one-sided; all checks of a box share the 5 %, so the last one may be \
         believed. *Shown as failing* is the other side: a picture that shows everything as failing is never wrong, and says nothing. *Never braking* is the share of the box in which a car fails that never brakes: that a driver \
         passes in the rest says nothing of it.",
        "It is about this box, this pedestrian and these towns. It says nothing about other starts or about people.",
    ];
    Some(Section {
        id: "covers",
        name: "Covered",
        title: "What was not missed",
        figures: pictures(&rows).into_iter().collect(),
        tables: vec![table(&rows)],
        notes: reading.map(String::from).into(),
        ..Section::default()
    })
}

/// What each cover shows.
pub fn answer(found: &Findings<'_>) -> Vec<Said> {
    let rows: Option<Vec<Row<'_>>> = found.finished.found_if_any();
    let said = |row: &Row<'_>| {
        let text = format!("{} in {}, box {}: {}", row.0.policy, row.0.town, row.0.spawn, statement(row));
        let is_of_faults = row.0.failure_name() == "fault";
        Said { driver: row.0.policy.clone(), text, fails: is_of_faults && row.1.coverage.failures() > 0 }
    };
    rows.iter().flatten().map(said).collect()
}

/// What is shown, as a sentence without its end.
pub fn statement((cover, found): &Row<'_>) -> String {
    let Some(bound) = found.bound() else { return "Nothing is shown: it ended before its first check".into() };
    let which = if found.coverage.failures() == 0 { "" } else { " that the picture does not show" };
    let enough = match found.is_covered(cover) {
        true => String::new(),
        false => format!(", more than the {} asked for", percent_above(cover.epsilon)),
    };
    let (failure, bound) = (cover.failure_name(), percent_above(bound));
    format!("With 95 % confidence no {failure}{which} occupies more than {bound} of the box{enough}")
}

/// A share in percent with two digits, rounded up.
pub fn percent_above(share: f64) -> String {
    let percent = share * 100.0;
    let digits = if percent >= 10.0 {
        0
    } else if percent >= 1.0 {
        1
    } else {
        2
    };
    let unit = libm::pow(10.0, f64::from(digits));
    format!("{:.*} %", digits as usize, (percent * unit - 1e-9).ceil() / unit)
}

fn table(rows: &[Row<'_>]) -> Table {
    let shown = Selection::new()
        .text("driver", |(cover, _): &Row<'_>| cover.policy.clone())
        .text("town", |(cover, _)| cover.town.clone())
        .text("box", |(cover, _)| format!("{}: {}", cover.spawn, cover.parameter_names().join(", ")))
        .column(Column::text("pedestrian").detail(), |(cover, _)| cover.pedestrian.clone())
        .column(Column::text("counts").page_only(), |(cover, _)| Value::text(cover.failure_name()))
        .text("not shown: at most", |(cover, found)| match found.bound().map(percent_above) {
            Some(bound) if !found.is_covered(cover) => {
                Value::warning(format!("{bound}, asked {}", percent_above(cover.epsilon)))
            }
            bound => bound.into(),
        })
        .column(Column::text("worse than shown").page_only(), |(_, found)| {
            found.coverage.best().map(|look| Value::Of(look.worse, look.points))
        })
        .column(Column::text("better than shown").detail(), |(_, found)| {
            found.coverage.best().map(|look| Value::Of(look.better, look.points))
        })
        .number("shown as failing", |(_, found)| found.shown.map(Value::Percent))
        .number("never braking", |(_, found)| Value::Percent(found.unbraked_share()))
        .number("failures", |(_, found)| found.coverage.failures())
        .number("episodes", |(_, found)| found.coverage.points.len())
        .column(Column::number("checks").detail(), |(_, found)| found.coverage.looks.len());
    Table { place: Place::Everywhere, ..shown.table(rows) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_rounded_up() {
        let shares = [0.0098, 0.00981, 0.01, 0.0123, 0.139, 0.5];
        assert_eq!(shares.map(percent_above), ["0.98 %", "0.99 %", "1.0 %", "1.3 %", "14 %", "50 %"]);
    }
}
