use polars::prelude::DataFrame;

use crate::jobs::HardenResult;
use crate::record::columns::{POLICY, RUN_ID};
use crate::record::{Column, Table};
use compile::HardenKey;
use world::hardening::{Hardened, Tested, Traffic};

/// The stem of the file of the table.
pub const HARDENED: &str = "hardened";

/// What a hardening changed, of one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct HardenedRow {
    pub key: HardenKey,
    /// `key`, `walker`, `falsifier`, `progress` or `comfort`.
    pub about: &'static str,
    /// The key, the pedestrian, the falsifier, or the unit.
    pub name: String,
    /// The town of the test.
    pub town: Option<String>,
    /// Starts or encounters that count.
    pub starts: Option<u64>,
    pub before: Option<f64>,
    pub after: Option<f64>,
    /// Starts with a fault after and none before.
    pub new: Option<u64>,
    /// Episodes in which a program failed.
    pub errors: Option<u64>,
}

/// Starts with a fault of all tests together, and what they cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HardenedTotals {
    pub starts: u64,
    pub before: u64,
    pub after: u64,
    pub new: u64,
}

impl HardenedTotals {
    /// Adds up the tests.
    pub fn of(found: &Hardened) -> Self {
        found.tests.iter().fold(Self::default(), |all, test| Self {
            starts: all.starts + test.starts,
            before: all.before + test.before,
            after: all.after + test.after,
            new: all.new + test.new,
        })
    }
}

/// Share of the mean speed in natural traffic that is lost; negative when it is gained.
pub fn lost_progress([before, after]: &[Traffic; 2]) -> Option<f64> {
    let before = before.speed().filter(|speed| *speed > 0.0)?;
    Some(1.0 - after.speed()? / before)
}

/// The rows of a hardening.
fn rows(result: &HardenResult) -> Vec<HardenedRow> {
    let Some(found) = &result.found else { return Vec::new() };
    let row = |about, name: String| HardenedRow {
        key: result.key.clone(),
        about,
        name,
        town: None,
        starts: None,
        before: None,
        after: None,
        new: None,
        errors: None,
    };
    let keys = result.plan.driver.keys.iter().zip(&found.values).map(|(key, after)| HardenedRow {
        before: Some(key.before),
        after: Some(*after),
        ..row("key", key.name.clone())
    });
    let tests = found.tests.iter().map(|test: &Tested| HardenedRow {
        town: Some(test.town.clone()),
        starts: Some(test.starts),
        before: Some(test.before as f64),
        after: Some(test.after as f64),
        new: Some(test.new),
        errors: Some(test.errors),
        ..row(if test.searches { "falsifier" } else { "walker" }, test.attacker.clone())
    });
    let [before, after] = &found.traffic;
    let natural = |about, name: &str, figure: fn(&Traffic) -> Option<f64>| HardenedRow {
        starts: Some(after.episodes),
        before: figure(before),
        after: figure(after),
        errors: Some(before.errors + after.errors),
        ..row(about, name.into())
    };
    let traffic = [
        natural("progress", "mean speed (m/s)", Traffic::speed),
        natural("comfort", "share with hard braking", Traffic::braking_rate),
        natural("comfort", "faults in natural traffic", |traffic| Some(traffic.faults as f64)),
    ];
    keys.chain(tests).chain(traffic).collect()
}

/// The columns of `hardened`.
pub fn hardened_columns<'a>() -> Table<'a, HardenedRow> {
    let (count, number, text) = (Column::<u64>::new, Column::<f64>::new, Column::<String>::new);
    Table::new(
        HARDENED,
        "Several rows for each `harden` of a driver: its keys before and after, and what held-out tests show. Starts of a test are equal before and after.",
    )
    .column(RUN_ID.of(|row: &HardenedRow| row.key.id.to_string()))
    .column(POLICY.of(|row: &HardenedRow| row.key.policy.clone()))
    .column(count("block", "", "number of the `harden` block in its campaign, from 0").of(|row: &HardenedRow| u64::from(row.key.block)))
    .column(count("run", "", "number of the run, from 0").of(|row: &HardenedRow| u64::from(row.key.run)))
    .column(text("about", "", "`key`: a varied key, in SI. `walker`, `falsifier`: starts with a fault in a test with a pedestrian or a search. `progress`, `comfort`: natural encounters in the towns of the test").of(|row: &HardenedRow| row.about.to_string()))
    .column(text("name", "", "the key, who attacks, or the figure").of(|row: &HardenedRow| row.name.clone()))
    .column(text("town", "", "town of the test").of(|row: &HardenedRow| row.town.clone()))
    .column(count("starts", "", "starts that count, for both where they are pairs").of(|row: &HardenedRow| row.starts))
    .column(number("before", "", "value before").of(|row: &HardenedRow| row.before))
    .column(number("after", "", "value after").of(|row: &HardenedRow| row.after))
    .column(count("new_faults", "", "starts with a fault after and none before").of(|row: &HardenedRow| row.new))
    .column(count("errors", "", "episodes in which a program failed").of(|row: &HardenedRow| row.errors))
}

/// The table `hardened`.
pub fn hardened_table(results: &[HardenResult]) -> DataFrame {
    let all: Vec<HardenedRow> = results.iter().flat_map(rows).collect();
    hardened_columns().frame(&all)
}

/// What a hardening came to, as a short line for a terminal.
pub fn hardened_in_words(result: &HardenResult) -> String {
    let Some(found) = &result.found else { return String::new() };
    let HardenedTotals { starts, before, after, new } = HardenedTotals::of(found);
    let lost =
        lost_progress(&found.traffic).map_or(String::new(), |lost| format!(", {:.1} % less progress", 100.0 * lost));
    format!("faults {before} -> {after} of {starts} starts ({new} new){lost}")
}
