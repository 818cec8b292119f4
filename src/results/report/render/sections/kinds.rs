use crate::analysis::Rule;
use crate::report::Findings;
use crate::report::failure_modes::{CellModes, MAX_CASES, MAX_FAILURES, MAX_REPEATED, Mode, Target};
use crate::report::render::table::{Column, Section, Table, Value};
use base::statistics::wilson;

/// Modes of a cell that the table names.
const NAMED: usize = 3;

/// The kinds of failure and which starts lead to them; `None` without a collision.
pub fn kinds(found: &Findings<'_>) -> Option<Section> {
    let cells = &found.modes;
    if cells.iter().all(|cell| cell.modes.is_empty()) {
        return None;
    }
    let cut = cells.iter().filter(|cell| cell.sampled.0 < cell.all.0).count();
    let mut notes = vec![format!(
        "A kind is where the car was hit, whether it moved, which reference drivers would have avoided it, whether the pedestrian came into sight too \
         late, and what the driver did at the touch. Within a kind, modes are clusters of the last seconds before the touch, of at most {MAX_REPEATED} collisions. \
         The examples are medoids. `failure_modes.csv` has all modes."
    )];
    if cut > 0 {
        notes.push(format!(
            "**In {cut} of these cells only about the first {MAX_FAILURES} collisions were analysed**, the same number of each run."
        ));
    }
    Some(Section {
        id: "kinds",
        name: "Kinds",
        title: "Kinds of failure",
        tables: [table(cells)].into_iter().chain(rules(cells)).collect(),
        notes,
        ..Section::default()
    })
}

fn table(cells: &[CellModes]) -> Table {
    let mode = |mode: &Mode| {
        let (share, speed) = (percent(mode.mode.share), mode.mode.impact_speed[1]);
        Value::Lines(vec![
            format!("{share} {}, {speed:.1} m/s", mode.mode.kind).into(),
            Value::Failure(mode.example.name()),
        ])
    };
    let row = |cell: &CellModes| {
        vec![
            Value::Text(cell.key.to_string()),
            Value::Count(cell.all.1),
            Value::Count(cell.kinds()),
            Value::Lines(cell.modes.iter().take(NAMED).map(mode).collect()),
        ]
    };
    let mut head = vec![Column::text("cell")];
    head.extend(["collisions", "kinds"].map(Column::number));
    head.push(Column::text("commonest modes: share, impact speed, example"));
    let rows = cells.iter().filter(|cell| !cell.modes.is_empty()).map(row).collect();
    Table { head, rows, ..Table::default() }
}

/// The most and the least dangerous rule of each cell; `None` without any rule.
fn rules(cells: &[CellModes]) -> Option<Table> {
    let mut rows = Vec::new();
    for cell in cells {
        for (target, found) in &cell.explanations {
            let what = match target {
                Target::Collision => "a collision",
                Target::Preventable => "a preventable one",
            };
            let several = found.rules.len() > 1;
            let rule = |rule: Option<&Rule>| Value::Text(rule.filter(|_| several).map_or("–".into(), worded));
            rows.push(vec![
                Value::Text(cell.key.to_string()),
                what.into(),
                percent(found.overall.0 as f64 / found.overall.1.max(1) as f64).into(),
                rule(found.rules.first()),
                rule(found.rules.last()),
                Value::Number(Some(found.skill), 2),
            ]);
        }
    }
    let mut head: Vec<Column> = ["cell", "ends in"].map(Column::text).into();
    head.push(Column::number("of all"));
    head.extend(["most often when", "least often when"].map(Column::text));
    head.push(Column::number("skill"));
    let notes = vec![format!(
        "Rules are learnt from the episodes with even numbers. Their rates, with Wilson's 95 %, are those of the episodes with odd numbers; at most {MAX_CASES} \
         episodes of a cell are used. *Skill* is the share of the variance of the odd episodes that the rules explain; rules of skill 0 explain nothing. A rule \
         shows what occurs together, not what causes it. `turned away` is the angle at the start between where the pedestrian faces and the car. \
         `explanations.csv` has all rules."
    )];
    (!rows.is_empty()).then(|| Table { title: "Which starts fail".into(), head, rows, notes, ..Table::default() })
}

fn worded(rule: &Rule) -> String {
    let (hits, all) = rule.held_out;
    let (low, high) = wilson(hits, all);
    let rate = percent(hits as f64 / all.max(1) as f64);
    format!("{rule}: {rate} ({low:.2}..{high:.2}, n = {all})")
}

/// A fraction as a percentage.
fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
