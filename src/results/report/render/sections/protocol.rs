use crate::jobs::percent_above;
use crate::report::grouped::grouped;
use crate::report::render::table::{Column, Mark, Place, Section, Selection, Table, Value, unique};
use crate::report::{Colour, Findings, ProtocolCell, score};
use episode::TestCriterion;

/// How to read the tables.
const READING: &str = "A cell is the impact speed (km/h) at the test speed of its column, or without a collision a word alone. Along the path it is the speed \
     of the car less that of the target. *Not tested* is a cell whose test speed the driver did not hold within 1 km/h, with the speed that it drove (km/h), `–` a case that was not run, or that also a car passes that never brakes. A test is over when the car has \
     stopped, the target has left its path, or, along the path, the car is slower than the target. Euro NCAP's tests show colours; their \
     *score* is the mean of the colours' shares of the points (green 1, yellow 0.75, orange 0.5, brown 0.25, red 0), a cell without \
     points is not passed, and a row with a case that was not run or not tested has no score. Others pass without a collision, or below the limit in the head of the column (UN R152, M1 and N1 in running order). \
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
     careful drivers would have avoided the collision. So a red cell can be *contested*: some reference drivers avoid it and some do not.";
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
    let tests = grouped(cells, |cell| cell.test.as_str());
    tables.extend(tests.iter().map(|cells| of_test(cells)));
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

/// The test speeds, which are the columns.
fn speeds<'a>(cells: impl Iterator<Item = &'a ProtocolCell>) -> Vec<f64> {
    let mut speeds: Vec<f64> = cells.map(|cell| cell.test_speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds
}

/// Rows of drivers and overlaps, columns of test speeds.
fn of_test(cells: &[&ProtocolCell]) -> Table {
    let coloured = cells.iter().any(|cell| cell.criterion == TestCriterion::EuroNcap);
    let title = |speed: &f64| {
        let limit = cells.iter().find(|cell| cell.test_speed == *speed).map_or(0.0, |cell| cell.limit() * 3.6);
        let limit = if coloured || limit <= 0.0 { String::new() } else { format!(" (≤ {limit:.0})") };
        Column::number(format!("{:.0} km/h{limit}", speed * 3.6))
    };
    let shown = Selection::new()
        .text("driver", |of: &Vec<&ProtocolCell>| Value::code(&of[0].policy))
        .column(Column::number("overlap").key(), |of| Value::Percent(of[0].overlap))
        .each(speeds(cells.iter().copied()), title, |speed, of| {
            of.iter().find(|cell| cell.test_speed == *speed).map(|cell| played(cell))
        })
        .when(coloured, |shown| {
            shown.number("score", |of| match (score(of.iter().copied()), ProtocolCell::caveats(of)) {
                (Some(score), caveats) if !caveats.is_empty() => Value::warning(format!("{score:.2}: {caveats}")),
                (score, _) => Value::number(score, 2),
            })
        })
        .number("passed", |of| passes(of, if coloured { String::new() } else { ProtocolCell::caveats(of) }));
    let rows = grouped(cells.iter().copied(), |cell| (&cell.policy, cell.overlap.to_bits()));
    Table { title: cells[0].test.clone(), ..shown.table(&rows) }
}

/// How many cells of a row were passed, of those that were run, and how many of these had a collision: `3 of 3, 1 with a collision, 3 not run`;
/// then what else is to be said.
fn passes(of: &[&ProtocolCell], caveats: String) -> String {
    let tested = || of.iter().filter(|cell| cell.is_tested());
    let passed = || tested().filter(|cell| cell.passes() == Some(true));
    let hit = passed().filter(|cell| cell.impact_speed > Some(0.0)).count();
    let run = of.iter().filter(|cell| cell.is_run()).count();
    let other = run - tested().count();
    let mut text = format!("{} of {}", passed().count(), tested().count());
    for (count, what) in [(hit, "with a collision"), (other, "not at the test speed"), (of.len() - run, "not run")] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    if caveats.is_empty() { text } else { text + ", " + &caveats }
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
    let drivers = grouped(&all, |each| &each.key().policy);
    let of_drivers = drivers.iter().map(|of| of_driver(of));
    let tables = std::iter::once(robustness(&drivers)).chain(of_drivers).chain([of_searches(&all)]);
    tables.chain(changes(&all)).collect()
}

/// How far each driver's nominal result is true within the layers.
fn robustness(drivers: &[Vec<&Layered<'_>>]) -> Table {
    let reds = |cell: &&ProtocolCell| cell.colour() == Some(Colour::Red);
    let shown = Selection::new()
        .text("driver", |of: &Vec<&Layered<'_>>| Value::code(&of[0].key().policy))
        .number("cells", Vec::len)
        .number("worse within the layers", |of| of.iter().filter(|each| each.is_worse()).count())
        .number("red, nominal", |of| of.iter().filter_map(|each| each.nominal).filter(reds).count())
        .number("red, worst", |of| of.iter().map(|each| each.worst()).filter(reds).count())
        .number("score, nominal", |of| Value::number(score(of.iter().filter_map(|each| each.nominal)), 2))
        .number("score, worst", |of| Value::number(score(of.iter().map(|each| each.worst())), 2));
    let note = "A cell is a test, an overlap and a test speed. *Worse*: a variation of the target within the layers has a worse colour than the \
         nominal test. *Score*: the mean of the colours' shares of the points, 1 when all cells are green.";
    Table {
        title: "Robustness: is the nominal result true within the layers?".into(),
        notes: vec![headline(drivers), note.into()],
        ..shown.table(drivers)
    }
}

/// Which drivers touch no target in the nominal tests, and which within the layers.
fn headline(drivers: &[Vec<&Layered<'_>>]) -> String {
    let without = |touches: &dyn Fn(&Layered<'_>) -> bool| {
        let clean = drivers.iter().filter(|of| !of.iter().any(|each| touches(each)));
        match clean.map(|of| format!("`{}`", of[0].key().policy)).collect::<Vec<_>>() {
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
fn of_driver(of: &[&Layered<'_>]) -> Table {
    let shown = Selection::new()
        .text("test", |here: &Vec<&Layered<'_>>| Value::code(&here[0].nominal.unwrap_or(here[0].key()).test))
        .column(Column::number("overlap").key(), |here| Value::Percent(here[0].key().overlap))
        .each(
            speeds(of.iter().map(|each| each.key())),
            |speed| Column::number(format!("{:.0} km/h", speed * 3.6)),
            |speed, here| here.iter().find(|each| each.key().test_speed == *speed).map(|each| each.value()),
        );
    let rows = grouped(of.iter().copied(), |each| (&each.key().test, each.key().overlap.to_bits()));
    Table {
        title: format!("{}: nominal → worst within the layers, impact speed (km/h)", of[0].key().policy),
        ..shown.table(&rows)
    }
}

/// In how many cells each search found the worst result.
fn of_searches(all: &[Layered<'_>]) -> Table {
    let searches = unique(all.iter().flat_map(|each| &each.found).filter_map(|cell| cell.falsifier.as_deref()));
    let worse: Vec<&Layered<'_>> = all.iter().filter(|each| each.is_worse()).collect();
    let as_bad =
        |each: &Layered<'_>, name| each.found_by(name).is_some_and(|cell| cell.colour() == each.worst().colour());
    let shown = Selection::new()
        .text("search", |name: &&str| Value::code(*name))
        .number("cells searched", |name| all.iter().filter(|each| each.found_by(name).is_some()).count())
        .number("worst colour found, of the worse cells", |name| {
            Value::Of(worse.iter().filter(|each| as_bad(each, name)).count() as u64, worse.len() as u64)
        });
    Table { title: "Searches, each with the same budget".into(), ..shown.table(&searches) }
}

/// The cells that got worse, with the names of their collisions; `None` if no cell did.
fn changes(all: &[Layered<'_>]) -> Option<Table> {
    let shown = Selection::new()
        .text("driver", |each: &Layered<'_>| Value::code(&each.worst().policy))
        .text("test", |each| Value::code(&each.nominal.unwrap_or(each.worst()).test))
        .number("overlap", |each| Value::Percent(each.worst().overlap))
        .number("test speed (km/h)", |each| Value::number(Some(each.worst().test_speed * 3.6), 0))
        .text("nominal", |each| each.nominal.map(shown))
        .text("worst", |each| played(each.worst()))
        .text("found by", |each| Value::code(each.worst().falsifier.clone().unwrap_or_default()))
        .text("replay", |each| Value::code(each.worst().worst.clone().unwrap_or_default()));
    let table = shown.table(all.iter().filter(|each| each.is_worse()));
    (!table.rows.is_empty()).then(|| Table { title: "Cells that are worse within the layers".into(), ..table })
}

/// The result of a cell with its failure.
fn played(cell: &ProtocolCell) -> Value {
    let worst = match &cell.worst {
        Some(failure) => Value::Played(Box::new(shown(cell)), failure.clone()),
        None => shown(cell),
    };
    match cell.not_passed_at_most() {
        Some(most) => {
            let sure =
                format!("{} of {}: at most {} (95 %, one-sided)", cell.not_passed, cell.episodes, percent_above(most));
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
