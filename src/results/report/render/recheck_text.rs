//! A recheck as tables for a terminal.

use super::table::{Column, Table, Value};
use crate::report::{CrossedStarts, Encounter, Met, Recheck, RecheckedFailures, StartFaults};

/// The text for a terminal of this width (columns). `shown` is the number of encounters in each list.
pub fn recheck_for_terminal(recheck: &Recheck, shown: usize, width: u16) -> String {
    let mut text = format!("before  {}\n", recheck.report.display());
    let files: Vec<String> = recheck.files.iter().map(|file| file.display().to_string()).collect();
    text.push_str(&format!("after   {}\n", if files.is_empty() { "the same files".into() } else { files.join(" ") }));
    recheck.notes.iter().for_each(|note| text.push_str(&format!("note    {note}\n")));
    text.push_str("\nfailures of the report, met again by the new driver\n");
    if recheck.failures.is_empty() {
        text.push_str("the report has none of these drivers\n");
    } else {
        text.push_str(&failures(&recheck.failures).to_terminal(width));
    }
    for row in &recheck.crossings {
        text.push_str(&format!(
            "\n{}: {} crossings from each of {} starts\n",
            crossed_title(row),
            row.crossings,
            row.starts().len()
        ));
        text.push_str(&crossings(row).to_terminal(width));
        text.push_str(&verdict(row));
    }
    text.push_str(&list("still a fault", &faults_after(recheck, true), shown, width));
    text.push_str(&list("turned into a fault", &faults_after(recheck, false), shown, width));
    text.push_str(&list("new faults on the fixed list", &new_faults(recheck), shown, width));
    text
}

/// The drivers, the town and the source of failures that were met again.
pub fn rechecked_title(row: &RecheckedFailures) -> String {
    let (found_in, walked_by) = (row.found_in.name(), row.walked_by.name());
    format!("{} in {}, failures of the {found_in}, by {walked_by}", drivers(&row.policies), row.town)
}

/// The drivers and the town of a part of the fixed list.
pub fn crossed_title(row: &CrossedStarts) -> String {
    let setup = if row.setup == 0 { String::new() } else { format!(", setup {}", row.setup) };
    format!("{} in {}{setup}", drivers(&row.policies), row.town)
}

fn drivers([before, after]: &[String; 2]) -> String {
    if before == after { before.clone() } else { format!("{before} and {after}") }
}

fn failures(rows: &[RecheckedFailures]) -> Table {
    let mut head = vec![Column::text("driver"), Column::text("town"), Column::text("found in"), Column::text("by")];
    head.extend(
        ["failures", "faults", "still faults", "turned faults", "still collisions", "gone"].map(Column::number),
    );
    let row = |row: &RecheckedFailures| {
        let count = |is: fn(&Met, &Met) -> bool| Value::Count(row.count(is));
        vec![
            drivers(&row.policies).into(),
            row.town.clone().into(),
            row.found_in.name().to_owned().into(),
            row.walked_by.name().to_owned().into(),
            count(|_, _| true),
            count(|before, _| before.fault),
            count(|before, after| before.fault && after.fault),
            count(|before, after| !before.fault && after.fault),
            count(|_, after| after.is_collision()),
            count(|_, after| !after.is_collision()),
        ]
    };
    Table { head, rows: rows.iter().map(row).collect(), ..Table::default() }
}

fn crossings(row: &CrossedStarts) -> Table {
    let mut head = vec![Column::text("")];
    head.extend(["before", "after", "new", "fixed", "same", "p"].map(Column::number));
    let count = |count: Option<u64>| count.map_or(Value::Text("–".into()), Value::Count);
    let p = |p: Option<f64>| {
        Value::Text(p.map_or("–".into(), |p| if p < 0.001 { "<0.001".into() } else { format!("{p:.3}") }))
    };
    let none = || Value::Text(String::new());
    let faults = vec![
        "faults".to_owned().into(),
        count(row.count(|before, _| before.fault)),
        Value::Count(row.valid().filter(|encounter| encounter.after.fault).count() as u64),
        count(row.count(|before, after| !before.fault && after.fault)),
        count(row.count(|before, after| before.fault && !after.fault)),
        count(row.count(|before, after| before.fault && after.fault)),
        none(),
    ];
    let starts = vec![
        "starts with a fault".to_owned().into(),
        count(row.count_starts(|faults| faults.before > 0)),
        Value::Count(row.fault_starts_after()),
        count(row.count_starts(|faults| faults.is_new())),
        count(row.count_starts(|faults| faults.is_fixed())),
        count(row.count_starts(|faults| faults.before > 0 && faults.after > 0)),
        p(row.holm),
    ];
    let injury = |value: Option<f64>| Value::Number(value, 2);
    let injuries = vec![
        "avoidable severe injuries in 1,000 crossings".to_owned().into(),
        injury(row.avoidable_injury_before()),
        injury(row.avoidable_injury_after()),
        none(),
        none(),
        none(),
        p(row.p_starts()),
    ];
    // All collisions, also those that nobody avoids: the first to show that a driver is worse.
    let all_injuries = vec![
        "severe injuries in all collisions, after less before".to_owned().into(),
        none(),
        injury(row.injury_difference()),
        none(),
        none(),
        none(),
        none(),
    ];
    Table { head, rows: vec![faults, starts, injuries, all_injuries], ..Table::default() }
}

/// What the fixed list says, in a sentence.
fn verdict(row: &CrossedStarts) -> String {
    let counts = row.count_starts(StartFaults::is_worse).zip(row.count_starts(StartFaults::is_better));
    let errors = match row.errors() {
        0 => String::new(),
        errors => format!("a driver failed as a program in {errors} encounters, which are left out\n"),
    };
    let said = match counts {
        None => String::new(),
        Some((0, 0)) if row.count(|before, after| before.fault || after.fault) == Some(0) => {
            "no crossing is a fault of either driver, so the list says nothing about faults; --starts N looks at more\n"
                .into()
        }
        Some((0, 0)) => "from every start the new driver's faults weigh as much as those of the old one\n".into(),
        Some((worse, better)) => {
            format!("the new driver's faults weigh more from {worse} starts, and less from {better}\n")
        }
    };
    said + &errors
}

/// Encounters with what they belong to.
type Listed<'a> = (String, &'a Encounter);

/// The failures that are a fault of the new driver, and were one of the old one, or were none.
fn faults_after(recheck: &Recheck, were_faults: bool) -> Vec<Listed<'_>> {
    let of_row = |row: &'_ RecheckedFailures| (row.walked_by.name(), drivers(&row.policies));
    let rows = recheck.failures.iter().flat_map(|row| row.encounters.iter().map(move |each| (of_row(row), each)));
    let still = rows
        .filter(|(_, each)| !each.is_error() && each.after.fault && (each.fault_before() == Some(true)) == were_faults);
    sorted(still.map(|((by, drivers), each)| (format!("{drivers}, by {by}"), each)).collect())
}

fn new_faults(recheck: &Recheck) -> Vec<Listed<'_>> {
    let rows = recheck.crossings.iter().flat_map(|row| row.valid().map(move |each| (crossed_title(row), each)));
    sorted(rows.filter(|(_, each)| each.after.fault && each.fault_before() == Some(false)).collect())
}

/// The fastest first.
fn sorted(mut all: Vec<Listed<'_>>) -> Vec<Listed<'_>> {
    let speed = |each: &Encounter| each.after.impact_speed.unwrap_or_default();
    all.sort_by(|(_, a), (_, b)| speed(b).total_cmp(&speed(a)));
    all
}

fn list(what: &str, all: &[Listed<'_>], shown: usize, width: u16) -> String {
    if all.is_empty() {
        return String::new();
    }
    let head = vec![
        Column::text("encounter"),
        Column::number("m/s before"),
        Column::number("m/s after"),
        Column::text("driver"),
    ];
    let speed = |met: Option<Met>| Value::Number(met.and_then(|met| met.impact_speed), 1);
    let row = |(drivers, each): &Listed<'_>| {
        let name = match each.name.as_str() {
            "" => Value::Text(format!("start {}, crossing {}", each.start, each.crossing)),
            name => Value::Code(name.to_owned()),
        };
        vec![name, speed(each.before), speed(Some(each.after)), drivers.clone().into()]
    };
    let table = Table { head, rows: all.iter().take(shown).map(row).collect(), ..Table::default() };
    format!("\n{what}: {}, the fastest first\n{}", all.len(), table.to_terminal(width))
}
