use crate::jobs::HardenResult;
use crate::report::Findings;
use crate::report::aggregate::{HardenedTotals, lost_progress};
use crate::report::render::table::{Column, Place, Section, Table, Value};
use base::signature::short;
use base::statistics::wilson;
use world::hardening::Hardened;

/// What hardenings changed: a row for each driver and run, and each test.
pub fn hardened(found: &Findings<'_>) -> Option<Section> {
    let results = found.finished.all::<HardenResult>();
    if results.is_empty() {
        return None;
    }
    let lines = results.iter().filter_map(|result| {
        let found = result.found.as_ref()?;
        Some(format!("*{}:* `{}`", result.key, result.written.line(&found.values)))
    });
    let reading = [
        "A round attacks the driver as it is, keeps the failures and the pedestrians that it ended up with, and searches the keys of the driver. The tests are in \
         other towns, from fresh starts; *new faults* are at starts without a fault before. Starts of a falsifier are those that it tried against both.",
        "*Progress* is the mean speed in encounters with natural pedestrians in the towns of the test. *Hard braking* is the share of these encounters in which \
         the car slowed down harder than stated over half a second. The limits were kept in the towns of the rounds; here they are estimates.",
    ];
    Some(Section {
        id: "hardened",
        name: "Hardened",
        title: "Drivers before and after repairs",
        tables: vec![summary(results), tests(results), rounds(results)],
        notes: lines.chain(reading.map(String::from)).collect(),
        lines: self::found(results).map(|(result, found)| result.written.line(&found.values)).collect(),
        ..Section::default()
    })
}

fn found(results: &[HardenResult]) -> impl Iterator<Item = (&HardenResult, &Hardened)> {
    results.iter().filter_map(|result| Some((result, result.found.as_ref()?)))
}

fn percent(share: Option<f64>) -> Value {
    share.map_or_else(|| Value::from("–"), Value::Percent)
}

fn summary(results: &[HardenResult]) -> Table {
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
    let row = |(result, found): (&HardenResult, &Hardened)| {
        let totals = HardenedTotals::of(found);
        let keys = result.plan.driver.keys.iter().zip(&found.values).zip(&result.written.varied);
        let keys: Vec<String> = keys
            .map(|((key, after), varied)| {
                format!("{} {} → {} {}", key.name, short(key.before), short(*after), varied.unit())
                    .trim_end()
                    .to_string()
            })
            .collect();
        let [before, after] = &found.traffic;
        vec![
            Value::from(&result.key.policy),
            Value::Count(result.key.run.into()),
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
    Table { place: Place::Everywhere, head, rows: self::found(results).map(row).collect(), ..Table::default() }
}

fn tests(results: &[HardenResult]) -> Table {
    let head = vec![
        Column::text("driver"),
        Column::number("run"),
        Column::text("town"),
        Column::text("attacker"),
        Column::text("faults before"),
        Column::text("after"),
        Column::text("95 % interval after"),
        Column::number("new"),
    ];
    let rows = found(results).flat_map(|(result, found)| {
        found.tests.iter().map(move |test| {
            let (low, high) = wilson(test.after, test.starts);
            vec![
                Value::from(&result.key.policy),
                Value::Count(result.key.run.into()),
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

fn rounds(results: &[HardenResult]) -> Table {
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
    let rows = found(results).flat_map(|(result, found)| {
        (1..).zip(&found.rounds).map(move |(number, round)| {
            vec![
                Value::from(&result.key.policy),
                Value::Count(result.key.run.into()),
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
