use std::fmt::Write;

use super::super::{Gate, Judged, Manifest, TrainingRecord};
use super::sections::{place, who};
use crate::tables::metrics::{EPISODES, ERRORS, MEAN, RUNS};
use crate::tables::{Cell, Cells, METRICS, Rows};
use compile::SearchKey;

/// The results of a campaign for a server of continuous integration.
#[derive(Debug, Clone)]
pub struct Suite {
    /// The manifest of the run.
    pub manifest: Manifest,
    /// Its cells, in the order of their table.
    pub cells: Cells,
    /// The cells of its searches, in the order of their table.
    pub searches: Rows<SearchKey>,
    /// The gates, each with its result for each row of the table that it is about.
    pub gates: Vec<(Gate, Vec<Judged>)>,
}

/// Writes campaigns as JUnit XML: a test suite for each campaign, a test case for each cell, each cell of searches and each training that failed.
///
/// A cell fails when a gate is broken, and is skipped when a gate finds no value. It is in error when a driver failed as a program. Its
/// figures are properties of the suite, `CELL / FIGURE`.
///
/// # Source
/// `junit-10.xsd` of Jenkins' xUnit plug-in.
pub fn junit(suites: &[Suite]) -> String {
    let mut page = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let cases: Vec<_> = suites.iter().map(cases).collect();
    let sum = |place: usize| cases.iter().map(|cases| counts(cases)[place]).sum::<usize>();
    let time: f64 = suites.iter().map(|suite| suite.manifest.wall_time_s).sum();
    let _ = writeln!(
        page,
        "<testsuites name=\"falsify\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{time:.3}\">",
        sum(0),
        sum(1),
        sum(2)
    );
    for (suite, cases) in suites.iter().zip(&cases) {
        one(&mut page, suite, cases);
    }
    page.push_str("</testsuites>\n");
    page
}

fn one(page: &mut String, suite: &Suite, cases: &[(String, Vec<Finding>)]) {
    let (manifest, [tests, failures, errors, skipped]) = (&suite.manifest, counts(cases));
    let _ = writeln!(
        page,
        "  <testsuite name=\"{}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\" \
         time=\"{:.3}\">\n    <properties>",
        escaped(&manifest.campaign),
        manifest.wall_time_s
    );
    property(page, "falsify version", &manifest.version);
    property(page, "seed", &manifest.seed.to_string());
    for (gate, _) in &suite.gates {
        property(page, "fail-if", gate.text());
    }
    for cell in suite.cells.iter() {
        for (name, value) in figures(cell) {
            property(page, &format!("{} / {name}", cell.key.in_full()), &value);
        }
    }
    page.push_str("    </properties>\n");
    cases.iter().for_each(|(name, findings)| case(page, &manifest.campaign, name, findings));
    page.push_str("  </testsuite>\n");
}

/// The name of a cell's test case: the controller, the town, the driver, and only so much else as tells the cells of the campaign apart.
fn short_name(cell: &Cell, cells: &Cells) -> String {
    let rewards = !cell.key.is_trained() && cells.iter().any(|other| other.key.reward != cell.key.reward);
    let reward = if rewards { format!(" ({})", cell.key.reward) } else { String::new() };
    format!("{}{reward} in {} against {}", who(cell, cells), place(cell, cells), cell.key.policy)
}

/// The test cases of a campaign, by their names.
fn cases(suite: &Suite) -> Vec<(String, Vec<Finding>)> {
    let cells = suite.cells.iter().enumerate();
    let cells = cells.map(|(row, cell)| (short_name(cell, &suite.cells), findings(suite, row)));
    let searches = suite.searches.iter().enumerate().map(|(row, cell)| (cell.in_full(), of_gates(suite, true, row)));
    let failed = suite.manifest.trainings.iter().filter(|training| !training.error.is_empty());
    let trainings = failed.map(|TrainingRecord { reward, town, driver: policy, run, error, .. }| {
        let name = format!("training of {reward} in {town} against {policy}, run {run}");
        (name, vec![("error", "training", error.clone())])
    });
    cells.chain(searches).chain(trainings).collect()
}

/// Numbers of tests, failures, errors and skipped tests.
fn counts(cases: &[(String, Vec<Finding>)]) -> [usize; 4] {
    let of = |kind: &str| cases.iter().filter(|(_, found)| found.iter().any(|finding| finding.0 == kind)).count();
    [cases.len(), of("failure"), of("error"), of("skipped")]
}

/// The element, its type and its message.
type Finding = (&'static str, &'static str, String);

/// The element of a cell: an error, else the broken gates, else the gates without a value.
fn findings(suite: &Suite, row: usize) -> Vec<Finding> {
    let cell = &suite.cells[row];
    if cell.count(&ERRORS) > 0 {
        let all = cell.count(&ERRORS) + cell.count(&EPISODES);
        return vec![(
            "error",
            "driver",
            format!("the driver or the pedestrian failed in {} of {all} episodes", cell.count(&ERRORS)),
        )];
    }
    of_gates(suite, false, row)
}

/// The elements that the gates on a cell or on the searches of a falsifier make.
fn of_gates(suite: &Suite, searches: bool, row: usize) -> Vec<Finding> {
    let about = suite.gates.iter().filter(move |(gate, _)| gate.is_about_searches() == searches);
    let judged = || about.clone().filter_map(|(gate, rows)| Some((gate.text(), rows.get(row)?)));
    let broken = judged().filter(|(_, judged)| judged.fails());
    let broken = broken.filter_map(|(gate, judged)| Some(("failure", "fail-if", message(gate, judged)?)));
    let broken: Vec<Finding> = broken.collect();
    if !broken.is_empty() {
        return broken;
    }
    let mut missing = judged().filter(|(_, judged)| matches!(judged, Judged::NoValue(_)));
    missing.find_map(|(gate, judged)| Some(("skipped", "", message(gate, judged)?))).into_iter().collect()
}

fn message(gate: &str, judged: &Judged) -> Option<String> {
    Some(format!("{gate}: {}", judged.reason("")?))
}

fn case(page: &mut String, campaign: &str, name: &str, findings: &[Finding]) {
    let head = format!("    <testcase classname=\"{}\" name=\"{}\"", escaped(campaign), escaped(name));
    if findings.is_empty() {
        let _ = writeln!(page, "{head}/>");
        return;
    }
    let _ = writeln!(page, "{head}>");
    for (element, kind, message) in findings {
        let kind = if kind.is_empty() { String::new() } else { format!(" type=\"{kind}\"") };
        let _ = writeln!(page, "      <{element} message=\"{}\"{kind}/>", escaped(message));
    }
    page.push_str("    </testcase>\n");
}

fn property(page: &mut String, name: &str, value: &str) {
    let _ = writeln!(page, "      <property name=\"{}\" value=\"{}\"/>", escaped(name), escaped(value));
}

/// The counts, means and shares of a cell.
fn figures(cell: &Cell) -> Vec<(String, String)> {
    let counts = METRICS.into_iter().filter(|metric| metric.is_count());
    let counts = counts.map(|metric| (metric.name.to_string(), cell.count(metric).to_string()));
    let means = METRICS.into_iter().filter(|metric| !metric.is_count());
    let means = means.filter_map(|metric| Some((MEAN.name(metric.name), format!("{:.6}", cell.value(metric)?))));
    [(RUNS.name.to_string(), cell.runs().to_string())].into_iter().chain(counts).chain(means).collect()
}

/// Text for an attribute; characters that XML does not allow become question marks.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' | '\r' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('?'),
            c => out.push(c),
        }
    }
    out
}
