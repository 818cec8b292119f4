use std::collections::BTreeMap;

use crate::env::TestCriterion;
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Colour, ProtocolCell};

/// How to read the tables.
const READING: &str = "A cell is the impact speed (km/h) at the test speed of its column; 0 is no contact. Along the path it is the speed \
     of the car less that of the target. `!` marks a test speed that the driver did not hold within 1 km/h. A test is over when the car has \
     stopped, the target has left its path, or, along the path, the car is slower than the target. Euro NCAP's tests show colours; their \
     *score* is the mean of the colours' shares of the points (green 1, yellow 0.75, orange 0.5, brown 0.25, red 0), and a cell without \
     points is not passed. Others pass without contact, or below the limit in the head of the column (UN R152, M1 and N1 in running order).";
/// What a test does not say.
const LIMITS: &str = "**This is no rating.** The tests repeat the speeds, places and release of a protocol. Not modelled: light and weather, \
     the car's sensors unless the scenario gives them, warnings to a driver, tyres and brakes beyond the car's blueprint, repeated runs and \
     tolerances of test tracks, turning and reversing tests. The target is a disc of its width in the world; its box only states the impact \
     point. Euro NCAP's colours are published for 60 km/h, and the same shares are taken at other speeds.";

/// The results of drivers in the tests of a protocol, and the worst ones within its layers; none without a test.
pub fn protocol(cells: &[ProtocolCell], layers: &[ProtocolCell]) -> Option<Section> {
    if cells.is_empty() && layers.is_empty() {
        return None;
    }
    let mut tables = Vec::new();
    let mut tests: BTreeMap<usize, Vec<&ProtocolCell>> = BTreeMap::new();
    let mut names: Vec<&str> = Vec::new();
    for cell in cells {
        let number = names.iter().position(|name| *name == cell.test).unwrap_or_else(|| {
            names.push(&cell.test);
            names.len() - 1
        });
        tests.entry(number).or_default().push(cell);
    }
    tables.extend(tests.iter().map(|(number, cells)| of_test(names[*number], cells)));
    if !layers.is_empty() {
        tables.push(of_layers(cells, layers));
    }
    let notes = vec![READING.into(), LIMITS.into()];
    Some(Section {
        id: "protocol",
        name: "Protocol",
        title: "How did the drivers do in the protocol's tests?",
        tables,
        notes,
    })
}

/// Rows of drivers and overlaps, columns of test speeds.
fn of_test(test: &str, cells: &[&ProtocolCell]) -> Table {
    let mut speeds: Vec<f64> = cells.iter().map(|cell| cell.test_speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let coloured = cells.iter().any(|cell| cell.criterion == TestCriterion::EuroNcap);
    let title = |speed: &f64| {
        let limit = cells.iter().find(|cell| cell.test_speed == *speed).map_or(0.0, |cell| cell.limit() * 3.6);
        let limit = if coloured || limit <= 0.0 { String::new() } else { format!(" (≤ {limit:.0})") };
        Column::number(format!("{:.0} km/h{limit}", speed * 3.6))
    };
    let mut head = vec![Column::text("driver"), Column::number("overlap")];
    head.extend(speeds.iter().map(title));
    head.extend(coloured.then(|| Column::number("score")));
    head.push(Column::number("passed"));
    let mut keys: Vec<(&str, f64)> = Vec::new();
    for cell in cells {
        if !keys.contains(&(&cell.policy, cell.overlap)) {
            keys.push((&cell.policy, cell.overlap));
        }
    }
    let row = |(policy, overlap): &(&str, f64)| {
        let of: Vec<&&ProtocolCell> =
            cells.iter().filter(|cell| cell.policy == *policy && cell.overlap == *overlap).collect();
        let mut row = vec![Value::Code((*policy).into()), Value::Percent(*overlap)];
        row.extend(speeds.iter().map(|speed| {
            let cell = of.iter().find(|cell| cell.test_speed == *speed);
            cell.map_or_else(|| "–".into(), |cell| shown(cell))
        }));
        let passed = of.iter().filter(|cell| cell.passes() == Some(true)).count() as u64;
        row.extend(coloured.then(|| Value::Number(score(of.iter().map(|cell| **cell)), 2)));
        row.push(Value::Of(passed, of.len() as u64));
        row
    };
    Table { title: test.to_string(), head, rows: keys.iter().map(row).collect(), ..Table::default() }
}

/// The nominal result of each cell beside the worst that each search found.
fn of_layers(cells: &[ProtocolCell], layers: &[ProtocolCell]) -> Table {
    let mut searches: Vec<&str> = Vec::new();
    let mut keys: Vec<&ProtocolCell> = Vec::new();
    for cell in layers {
        let name = cell.falsifier.as_deref().unwrap_or_default();
        if !searches.contains(&name) {
            searches.push(name);
        }
        if !keys.iter().any(|key| key.is_same_case(cell)) {
            keys.push(cell);
        }
    }
    let mut head = vec![
        Column::text("driver"),
        Column::text("test"),
        Column::number("overlap"),
        Column::number("test speed (km/h)"),
        Column::text("nominal"),
        Column::text("worst"),
        Column::text("change"),
    ];
    head.extend(searches.iter().map(|name| Column::text(*name).detail()));
    let row = |key: &&ProtocolCell| {
        let nominal = cells.iter().find(|cell| cell.is_same_case(key));
        let of: Vec<&ProtocolCell> = layers.iter().filter(|cell| cell.is_same_case(key)).collect();
        let worst =
            of.iter().copied().max_by(|a, b| a.impact_speed.unwrap_or(0.0).total_cmp(&b.impact_speed.unwrap_or(0.0)));
        let colour = |cell: Option<&ProtocolCell>| cell.and_then(ProtocolCell::colour);
        let change = match (colour(nominal), colour(worst)) {
            (Some(before), Some(after)) if after > before => format!("{} → {}", before.name(), after.name()),
            (Some(before), Some(after)) if after == before => "same".into(),
            (Some(_), Some(_)) => "better".into(),
            _ => "–".into(),
        };
        let text = |cell: Option<&ProtocolCell>| cell.map_or_else(|| "–".into(), shown);
        let mut row = vec![
            Value::Code(key.policy.clone()),
            Value::Text(key.test.clone()),
            Value::Percent(key.overlap),
            Value::Number(Some(key.test_speed * 3.6), 0),
            text(nominal),
            text(worst),
            Value::Text(change),
        ];
        row.extend(
            searches.iter().map(|name| text(of.iter().copied().find(|cell| cell.falsifier.as_deref() == Some(name)))),
        );
        row
    };
    let note = "The worst result that a search found within the layers of a test, beside the nominal test. All searches had the same budget.";
    Table {
        title: "Robustness: worst results within the layers".into(),
        head,
        rows: keys.iter().map(row).collect(),
        notes: vec![note.into()],
    }
}

/// `0 green`, `23.4 red !`, `5.0 fails`.
fn shown(cell: &ProtocolCell) -> Value {
    let (Some(impact), Some(passes)) = (cell.impact_speed, cell.passes()) else { return "error".into() };
    let speed = if impact > 0.0 { format!("{:.1}", impact * 3.6) } else { "0".into() };
    let mark = if cell.is_held() == Some(false) { " !" } else { "" };
    let word = cell.colour().map_or(if passes { "passes" } else { "fails" }, Colour::name);
    let tone = cell.colour().unwrap_or(if passes { Colour::Green } else { Colour::Red });
    Value::Toned(format!("{speed} {word}{mark}"), tone.name())
}

/// The mean of the scores of cells.
fn score<'a>(cells: impl Iterator<Item = &'a ProtocolCell>) -> Option<f64> {
    let scores: Vec<f64> = cells.filter_map(ProtocolCell::colour).map(Colour::score).collect();
    (!scores.is_empty()).then(|| scores.iter().sum::<f64>() / scores.len() as f64)
}
