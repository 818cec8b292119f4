use std::collections::BTreeMap;

use crate::jobs::percent_above;
use crate::report::render::table::{Column, Mark, Place, Section, Table, Value};
use crate::report::{Colour, Findings, ProtocolCell, score};
use episode::TestCriterion;

/// How to read the tables.
const READING: &str = "A cell is the impact speed (km/h) at the test speed of its column, or without a collision a word alone. Along the path it is the speed \
     of the car less that of the target. *Not tested* is a cell whose test speed the driver did not hold within 1 km/h, with the speed that it drove (km/h), `–` a case that was not run, or that also a car passes that never brakes. A test is over when the car has \
     stopped, the target has left its path, or, along the path, the car is slower than the target. Euro NCAP's tests show colours; their \
     *score* is the mean of the colours' shares of the points (green 1, yellow 0.75, orange 0.5, brown 0.25, red 0), a cell without \
     points is not passed, and a row with a case that was not run has no score. Others pass without a collision, or below the limit in the head of the column (UN R152, M1 and N1 in running order). \
     Where different episodes of a case were run, the worst speed stands there, and below it how many of them were not passed and the one-sided 95 % upper bound of their \
     share: \"0 of 20: at most 14 %\". Episodes that are equal to the bit are one.";
/// Shown below the tables in a terminal.
const LEGEND: [&str; 2] = [
    "cells: impact speed (km/h) of a collision; not tested: it did not hold the test speed, but drove this; –: not run, or passed also by a car that never brakes",
    "passed: cells with points, or below the limit; a driver can pass a cell with a collision",
];
/// Why colours, passes and verdicts differ.
const JUDGES: &str = "*Passed* counts the cells that get points: green has all of them, brown still a quarter, red none. \
     So a driver can pass a cell with a collision. The colour judges the speed alone. A verdict of the failures below judges something else: whether \
     careful humans would have avoided the collision. So a red cell can be *contested*: some reference drivers avoid it and some do not.";
/// What a test does not say.
const LIMITS: &str = "**This is not a rating.** The tests repeat the speeds, places and release of a protocol. Not modelled: light and weather, \
     the car's sensors unless the scenario gives them, warnings to a driver, tyres and brakes beyond the car's blueprint, repeated runs and \
     tolerances of test tracks, turning and reversing tests. The target is a disc of its width in the world; its box only states the impact \
     point.";

/// The results of drivers in the tests of a protocol, and the worst ones within its layers; `None` without a test.
pub fn protocol(found: &Findings<'_>) -> Option<Section> {
    let (cells, layers) = (&found.gathered.protocol, &found.layers);
    if cells.is_empty() && layers.is_empty() {
        return None;
    }
    let mut tables = if layers.is_empty() { Vec::new() } else { of_layers(cells, layers) };
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
    let is_coloured = cells.iter().chain(layers).any(|cell| cell.criterion == TestCriterion::EuroNcap);
    if let Some(first) = tables.first_mut().filter(|_| is_coloured) {
        first.notes.push(JUDGES.into());
    }
    tables.iter_mut().for_each(|table| table.place = Place::Everywhere);
    Some(Section {
        id: "protocol",
        name: "Protocol",
        title: "How did the drivers do in the protocol's tests?",
        tables,
        notes: vec![READING.into(), LIMITS.into()],
        lines: LEGEND.map(String::from).into(),
        ..Section::default()
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
    let mut head = vec![Column::text("driver"), Column::number("overlap").key()];
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
        let of: Vec<&ProtocolCell> =
            cells.iter().copied().filter(|cell| cell.policy == *policy && cell.overlap == *overlap).collect();
        let mut row = vec![Value::code(*policy), Value::Percent(*overlap)];
        row.extend(speeds.iter().map(|speed| {
            let cell = of.iter().find(|cell| cell.test_speed == *speed);
            cell.map_or_else(|| "–".into(), |cell| played(cell))
        }));
        let passed = of.iter().filter(|cell| cell.is_tested() && cell.passes() == Some(true)).count();
        let caveats = ProtocolCell::caveats(&of);
        row.extend(coloured.then(|| match score(of.iter().copied()) {
            Some(score) if !caveats.is_empty() => Value::warning(format!("{score:.2}: {caveats}")),
            score => Value::number(score, 2),
        }));
        row.push(passes(passed, &of, if coloured { "" } else { &caveats }));
        row
    };
    Table { title: test.to_string(), head, rows: keys.iter().map(row).collect(), ..Table::default() }
}

/// How many cells of a row were passed, of those that were run, and how many of these had a collision: `3 of 3, 1 with a collision, 3 not run`;
/// then what else is to be said.
fn passes(passed: usize, of: &[&ProtocolCell], caveats: &str) -> Value {
    let tested = || of.iter().filter(|cell| cell.is_tested());
    let hit = tested().filter(|cell| cell.passes() == Some(true) && cell.impact_speed > Some(0.0)).count();
    let run = of.iter().filter(|cell| cell.is_run()).count();
    let other = run - tested().count();
    let mut text = format!("{passed} of {}", tested().count());
    for (count, what) in [(hit, "with a collision"), (other, "not at the test speed"), (of.len() - run, "not run")] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    if !caveats.is_empty() {
        text += &format!(", {caveats}");
    }
    Value::text(text)
}

/// A cell of a test within its layers.
struct Layered<'a> {
    /// The nominal test; `None` if it was not run.
    nominal: Option<&'a ProtocolCell>,
    /// The worst result of each search.
    found: Vec<&'a ProtocolCell>,
}

impl<'a> Layered<'a> {
    /// The cells of the searches, each once.
    fn all(cells: &'a [ProtocolCell], layers: &'a [ProtocolCell]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for found in layers {
            match all.iter_mut().find(|known| known.key().is_same_case(found)) {
                Some(known) => known.found.push(found),
                None => {
                    let nominal = cells.iter().find(|cell| cell.is_same_case(found) && cell.is_run());
                    all.push(Self { nominal, found: vec![found] });
                }
            }
        }
        all
    }

    /// Any of its results: they have the same driver and case.
    fn key(&self) -> &'a ProtocolCell {
        self.found[0]
    }

    /// The result of a search.
    fn found_by(&self, falsifier: &str) -> Option<&'a ProtocolCell> {
        self.found.iter().copied().find(|cell| cell.falsifier.as_deref() == Some(falsifier))
    }

    /// The worst result of the searches and the nominal test, which is one of the variations.
    fn worst(&self) -> &'a ProtocolCell {
        let speed = |cell: &ProtocolCell| cell.impact_speed.unwrap_or(0.0);
        let mut worst = self.nominal.unwrap_or(self.found[0]);
        for cell in &self.found {
            if speed(cell) > speed(worst) {
                worst = cell;
            }
        }
        worst
    }

    /// Whether its colour, or whether it passes, is worse than that of the nominal test.
    fn is_worse(&self) -> bool {
        let rank = |cell: &ProtocolCell| (cell.passes() == Some(false), cell.colour());
        self.nominal.is_some_and(|nominal| rank(self.worst()) > rank(nominal))
    }

    fn value(&self) -> Value {
        let worst = || played(self.worst());
        match self.nominal {
            Some(nominal) if self.is_worse() => Value::Change(Box::new(played(nominal)), Box::new(worst())),
            Some(nominal) => played(nominal),
            None => worst(),
        }
    }
}

/// The tables of the layers: one row for each driver, the cells of each driver, the searches, and the cells that got worse.
fn of_layers(cells: &[ProtocolCell], layers: &[ProtocolCell]) -> Vec<Table> {
    let all = Layered::all(cells, layers);
    let mut drivers: Vec<&str> = Vec::new();
    for each in &all {
        if !drivers.contains(&each.key().policy.as_str()) {
            drivers.push(&each.key().policy);
        }
    }
    let of = |driver: &str| all.iter().filter(|each| each.key().policy == driver).collect::<Vec<_>>();
    let mut tables = vec![robustness(&drivers, of)];
    tables.extend(drivers.iter().map(|driver| of_driver(driver, &of(driver))));
    tables.push(of_searches(&all));
    tables.extend(changes(&all));
    tables
}

/// How far each driver's nominal result is true within the layers.
fn robustness<'a>(drivers: &[&'a str], of: impl Fn(&str) -> Vec<&'a Layered<'a>>) -> Table {
    let names = ["cells", "worse within the layers", "red, nominal", "red, worst", "score, nominal", "score, worst"];
    let row = |driver: &&str| {
        let of = of(driver);
        let red = |cell: &ProtocolCell| cell.colour() == Some(Colour::Red);
        let nominal: Vec<&ProtocolCell> = of.iter().filter_map(|each| each.nominal).collect();
        let worst: Vec<&ProtocolCell> = of.iter().map(|each| each.worst()).collect();
        let count = |number: usize| Value::Count(number as u64);
        vec![
            Value::code(*driver),
            count(of.len()),
            count(of.iter().filter(|each| each.is_worse()).count()),
            count(nominal.iter().filter(|cell| red(cell)).count()),
            count(worst.iter().filter(|cell| red(cell)).count()),
            Value::number(score(nominal.iter().copied()), 2),
            Value::number(score(worst.iter().copied()), 2),
        ]
    };
    let note = "A cell is a test, an overlap and a test speed. *Worse*: a variation of the target within the layers has a worse colour than the \
         nominal test. *Score*: the mean of the colours' shares of the points, 1 when all cells are green.";
    Table {
        title: "Robustness: is the nominal result true within the layers?".into(),
        head: std::iter::once(Column::text("driver")).chain(names.map(Column::number)).collect(),
        rows: drivers.iter().map(row).collect(),
        notes: vec![headline(drivers, &of), note.into()],
        ..Table::default()
    }
}

/// Which drivers touch no target in the nominal tests, and which within the layers.
fn headline<'a>(drivers: &[&'a str], of: &impl Fn(&str) -> Vec<&'a Layered<'a>>) -> String {
    let without = |touches: &dyn Fn(&Layered<'_>) -> bool| {
        let clean = drivers.iter().filter(|driver| !of(driver).into_iter().any(touches));
        match clean.map(|driver| format!("`{driver}`")).collect::<Vec<_>>() {
            names if names.is_empty() => "no driver".to_string(),
            names => names.join(", "),
        }
    };
    let touched = |cell: &ProtocolCell| cell.impact_speed.is_none_or(|speed| speed > 0.0);
    format!(
        "**Without a collision in all nominal tests: {}. Without a collision within the layers: {}.**",
        without(&|each| each.nominal.is_some_and(touched)),
        without(&|each| touched(each.worst())),
    )
}

/// The nominal colour of each cell of a driver, and the worst one within the layers where that is worse.
fn of_driver(driver: &str, of: &[&Layered<'_>]) -> Table {
    let mut speeds: Vec<f64> = of.iter().map(|each| each.key().test_speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let mut keys: Vec<(&str, f64)> = Vec::new();
    for each in of {
        let key = (each.key().test.as_str(), each.key().overlap);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let mut head = vec![Column::text("test"), Column::number("overlap").key()];
    head.extend(speeds.iter().map(|speed| Column::number(format!("{:.0} km/h", speed * 3.6))));
    let row = |(test, overlap): &(&str, f64)| {
        let here = |each: &&&Layered<'_>| each.key().test == *test && each.key().overlap == *overlap;
        let name = of.iter().find(here).and_then(|each| each.nominal).map_or(*test, |nominal| nominal.test.as_str());
        let mut row = vec![Value::code(name), Value::Percent(*overlap)];
        row.extend(speeds.iter().map(|speed| {
            let cell = of.iter().filter(here).find(|each| each.key().test_speed == *speed);
            cell.map_or_else(|| "–".into(), |each| each.value())
        }));
        row
    };
    Table {
        title: format!("{driver}: nominal → worst within the layers, impact speed (km/h)"),
        head,
        rows: keys.iter().map(row).collect(),
        ..Table::default()
    }
}

/// In how many cells each search found the worst result.
fn of_searches(all: &[Layered<'_>]) -> Table {
    let mut searches: Vec<&str> = Vec::new();
    for name in all.iter().flat_map(|each| &each.found).filter_map(|cell| cell.falsifier.as_deref()) {
        if !searches.contains(&name) {
            searches.push(name);
        }
    }
    let row = |name: &&str| {
        let worse: Vec<_> = all.iter().filter(|each| each.is_worse()).collect();
        let as_bad =
            |each: &&&Layered<'_>| each.found_by(name).is_some_and(|cell| cell.colour() == each.worst().colour());
        let searched = all.iter().filter(|each| each.found_by(name).is_some()).count() as u64;
        let found = worse.iter().filter(as_bad).count() as u64;
        vec![Value::code(*name), Value::Count(searched), Value::Of(found, worse.len() as u64)]
    };
    let names = ["cells searched", "worst colour found, of the worse cells"];
    Table {
        title: "Searches, each with the same budget".into(),
        head: std::iter::once(Column::text("search")).chain(names.map(Column::number)).collect(),
        rows: searches.iter().map(row).collect(),
        ..Table::default()
    }
}

/// The cells that got worse, with the names of their collisions; `None` if no cell did.
fn changes(all: &[Layered<'_>]) -> Option<Table> {
    let numbers = ["overlap", "test speed (km/h)"].map(Column::number);
    let words = |names: [&'static str; 4]| names.map(Column::text);
    let head = ["driver", "test"].map(Column::text).into_iter().chain(numbers);
    let head: Vec<Column> = head.chain(words(["nominal", "worst", "found by", "replay"])).collect();
    let row = |each: &Layered<'_>| {
        let worst = each.worst();
        vec![
            Value::code(worst.policy.clone()),
            Value::code(each.nominal.unwrap_or(worst).test.clone()),
            Value::Percent(worst.overlap),
            Value::number(Some(worst.test_speed * 3.6), 0),
            each.nominal.map_or_else(|| "–".into(), shown),
            played(worst),
            Value::code(worst.falsifier.clone().unwrap_or_default()),
            Value::code(worst.worst.clone().unwrap_or_default()),
        ]
    };
    let rows: Vec<_> = all.iter().filter(|each| each.is_worse()).map(row).collect();
    let title = "Cells that are worse within the layers".into();
    (!rows.is_empty()).then(|| Table { title, head, rows, ..Table::default() })
}

/// The result of a cell with its failure.
fn played(cell: &ProtocolCell) -> Value {
    let worst = match &cell.worst {
        Some(failure) => Value::Played(Box::new(shown(cell)), failure.clone()),
        None => shown(cell),
    };
    match cell.not_passed_at_most() {
        Some(most) => {
            let sure = format!("{} of {}: at most {}", cell.not_passed, cell.episodes, percent_above(most));
            Value::Lines(vec![worst, sure.into()])
        }
        None => worst,
    }
}

/// `green`, `23.4 red`, `5.0 fails`, or that the test speed was not held.
fn shown(cell: &ProtocolCell) -> Value {
    let (Some(impact), Some(passes)) = (cell.impact_speed, cell.passes()) else {
        // Without any episode it was not tried, as in a run with `--smoke`.
        return if cell.failed { "error" } else { "–" }.into();
    };
    if let Some(driven) = cell.driven_speed.filter(|_| cell.is_held() == Some(false)) {
        return Value::warning(format!("not tested: {:.0} km/h", driven * 3.6));
    }
    let word = cell.colour().map_or(if passes { "passes" } else { "fails" }, Colour::name);
    let tone = cell.colour().unwrap_or(if passes { Colour::Green } else { Colour::Red });
    let speed = if impact > 0.0 { format!("{:.1} ", impact * 3.6) } else { String::new() };
    Value::Text(format!("{speed}{word}"), Mark::Tone(tone.name()))
}
