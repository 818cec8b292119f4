use super::{Row, Totals, lost_progress};
use crate::report::Findings;
use crate::report::table::{Column, Place, Section, Table, Value};
use base::signature::short;
use base::statistics::wilson;
use compile::Planned;

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

fn percent(share: Option<f64>) -> Value {
    share.map_or_else(|| Value::from("–"), Value::Percent)
}

fn summary(rows: &[Row<'_>]) -> Table {
    let head = vec![
        Column::text("driver"),
        Column::number("run"),
        Column::text("keys").page_only(),
        Column::number("faults before"),
        Column::number("after"),
        Column::number("new"),
        Column::number("starts"),
        Column::number("progress lost"),
        Column::number("hard braking before"),
        Column::number("after"),
    ];
    let row = |(job, found): &Row<'_>| {
        let totals = Totals::of(found);
        let keys = job.hardening.driver.keys.iter().zip(&found.values).zip(&job.written.varied);
        let keys: Vec<String> = keys
            .map(|((key, after), varied)| {
                format!("{} {} → {} {}", key.name, short(key.before), short(*after), varied.unit())
                    .trim_end()
                    .to_string()
            })
            .collect();
        let [before, after] = &found.traffic;
        vec![
            Value::from(&job.written.name),
            Value::Count(job.origin.run.into()),
            keys.join(", ").into(),
            Value::Count(totals.before),
            Value::Count(totals.after),
            Value::Count(totals.new),
            Value::Count(totals.starts),
            percent(lost_progress(&found.traffic)),
            percent(before.braking_rate()),
            percent(after.braking_rate()),
        ]
    };
    Table { place: Place::Everywhere, head, rows: rows.iter().map(row).collect(), ..Table::default() }
}

fn tests(rows: &[Row<'_>]) -> Table {
    let head = vec![
        Column::text("driver"),
        Column::number("run"),
        Column::text("town"),
        Column::text("attacked by"),
        Column::text("faults before"),
        Column::text("after"),
        Column::text("95 % interval after"),
        Column::number("new"),
    ];
    let rows = rows.iter().flat_map(|(job, found)| {
        found.tests.iter().map(move |test| {
            let (low, high) = wilson(test.after, test.starts);
            vec![
                Value::from(&job.written.name),
                Value::Count(job.origin.run.into()),
                Value::from(&test.town),
                Value::from(&test.attacker),
                Value::Of(test.before, test.starts),
                Value::Of(test.after, test.starts),
                format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high).into(),
                Value::Count(test.new),
            ]
        })
    });
    Table { head, rows: rows.collect(), ..Table::default() }
}

fn rounds(rows: &[Row<'_>]) -> Table {
    let head = vec![
        Column::text("driver"),
        Column::number("run"),
        Column::number("round"),
        Column::text("starts with a fault in the attack"),
        Column::number("failures kept"),
        Column::text("faults of the original in all kept"),
        Column::text("after the repair"),
        Column::text("candidates within the limits"),
    ];
    let rows = rows.iter().flat_map(|(job, found)| {
        (1..).zip(&found.rounds).map(move |(number, round)| {
            vec![
                Value::from(&job.written.name),
                Value::Count(job.origin.run.into()),
                Value::Count(number),
                Value::Of(round.faulty, round.attacked),
                Value::Count(round.kept),
                Value::Of(round.faults_before, round.starts),
                Value::Of(round.faults_after, round.starts),
                Value::Of(round.within, round.candidates),
            ]
        })
    });
    Table { head, rows: rows.collect(), ..Table::default() }
}
