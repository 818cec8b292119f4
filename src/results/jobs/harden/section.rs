use super::{Row, Totals, lost_progress};
use crate::report::Findings;
use crate::report::table::{Column, Place, Section, Selection, Table, Value};
use base::signature::short;
use base::statistics::wilson;
use compile::Planned;
use search::hardening::{Round, Tested};

/// What hardenings changed: a row for each driver and run, and each test; `None` without any.
pub fn hardened(found: &Findings<'_>) -> Option<Section> {
    let rows: Vec<Row<'_>> = found.finished.found_if_any()?;
    let written = rows.iter().map(|(job, found)| (job, job.written.line(&found.values)));
    let lines = written.clone().map(|(job, line)| format!("*{}:* `{line}`", job.title()));
    let reading = [
        "A round attacks the driver as it is, keeps the failures and the pedestrians that it ended with, and searches the keys of the driver. The tests are in \
         other towns, from fresh starts; *new faults* are at starts without a fault before. Starts of a search are those that it tried against both.",
        "*Progress* is the mean speed in encounters with natural pedestrians in the towns of the test. *Hard braking* is the share of these encounters in which \
         the car slowed down harder than stated over half a second. The limits were kept in the towns of the rounds; here they are estimates.",
    ];
    Some(Section {
        id: "hardened",
        name: "Hardened",
        title: "Drivers before and after repairs",
        tables: vec![summary(&rows), tests(&rows), rounds(&rows)],
        notes: lines.chain(reading.map(String::from)).collect(),
        lines: written.map(|(_, line)| line).collect(),
        ..Section::default()
    })
}

/// The driver and the run.
fn jobs<'a>() -> Selection<'a, Row<'a>> {
    Selection::new()
        .text("driver", |(job, _): &Row<'_>| job.written.name.clone())
        .number("run", |(job, _)| job.origin.run)
}

fn summary(rows: &[Row<'_>]) -> Table {
    let keys = |(job, found): &Row<'_>| {
        let keys = job.hardening.driver.keys.iter().zip(&found.values).zip(&job.written.varied);
        let key = keys.map(|((key, after), varied)| {
            format!("{} {} → {} {}", key.name, short(key.before), short(*after), varied.unit()).trim_end().to_string()
        });
        key.collect::<Vec<_>>().join(", ")
    };
    let shown = jobs()
        .column(Column::text("keys").page_only(), keys)
        .number("faults before", |(_, found)| Totals::of(found).before)
        .number("after", |(_, found)| Totals::of(found).after)
        .number("new", |(_, found)| Totals::of(found).new)
        .number("starts", |(_, found)| Totals::of(found).starts)
        .number("progress lost", |(_, found)| lost_progress(&found.traffic).map(Value::Percent))
        .number("hard braking before", |(_, found)| found.traffic[0].braking_rate().map(Value::Percent))
        .number("after", |(_, found)| found.traffic[1].braking_rate().map(Value::Percent));
    Table { place: Place::Everywhere, ..shown.table(rows) }
}

fn tests(rows: &[Row<'_>]) -> Table {
    let tests: Vec<(Row<'_>, &Tested)> =
        rows.iter().flat_map(|row| row.1.tests.iter().map(|test| (*row, test))).collect();
    let shown = jobs()
        .of(|row: &(Row<'_>, &Tested)| &row.0)
        .text("town", |(_, test)| test.town.clone())
        .text("attacked by", |(_, test)| test.attacker.clone())
        .text("faults before", |(_, test)| Value::Of(test.before, test.starts))
        .text("after", |(_, test)| Value::Of(test.after, test.starts))
        .text("95 % interval after", |(_, test)| {
            let (low, high) = wilson(test.after, test.starts);
            format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high)
        })
        .number("new", |(_, test)| test.new);
    shown.table(&tests)
}

fn rounds(rows: &[Row<'_>]) -> Table {
    let rounds = rows.iter().flat_map(|row| (1_u64..).zip(&row.1.rounds).map(|(number, round)| (*row, number, round)));
    let rounds: Vec<(Row<'_>, u64, &Round)> = rounds.collect();
    let shown = jobs()
        .of(|row: &(Row<'_>, u64, &Round)| &row.0)
        .number("round", |(_, number, _)| *number)
        .text("starts with a fault in the attack", |(.., round)| Value::Of(round.faulty, round.attacked))
        .number("failures kept", |(.., round)| round.kept)
        .text("faults of the original in all kept", |(.., round)| Value::Of(round.faults_before, round.starts))
        .text("after the repair", |(.., round)| Value::Of(round.faults_after, round.starts))
        .text("candidates within the limits", |(.., round)| Value::Of(round.within, round.candidates));
    shown.table(&rounds)
}
