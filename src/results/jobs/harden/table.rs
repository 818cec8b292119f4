use super::Row;
use crate::record::Table;
use crate::record::columns::{DRIVER, RUN, RUN_ID};
use compile::Harden;
use search::hardening::Tested;
use verdict::Traffic;

/// What a hardening changed, of one figure.
pub struct Changed<'a> {
    job: &'a Harden,
    /// `key`, `pedestrian`, `method`, `progress` or `comfort`.
    about: &'static str,
    /// The key, the pedestrian, the falsifier, or the unit.
    name: String,
    /// The town of the test.
    town: Option<String>,
    /// Starts or encounters that count.
    starts: Option<u64>,
    before: Option<f64>,
    after: Option<f64>,
    /// Starts with a fault after and none before.
    new: Option<u64>,
    /// Episodes in which a program failed.
    errors: Option<u64>,
}

/// The rows of a hardening.
pub fn rows<'a>((job, found): Row<'a>) -> Vec<Changed<'a>> {
    let row = |about, name: &str, [before, after]: [Option<f64>; 2]| {
        let name = name.to_string();
        Changed { job, about, name, town: None, starts: None, before, after, new: None, errors: None }
    };
    let keys = job.hardening.driver.keys.iter().zip(&found.values);
    let keys = keys.map(|(key, after)| row("key", &key.name, [Some(key.before), Some(*after)]));
    let tests = found.tests.iter().map(|test: &Tested| Changed {
        town: Some(test.town.clone()),
        starts: Some(test.starts),
        new: Some(test.new),
        errors: Some(test.errors),
        ..row(
            if test.searches { "method" } else { "pedestrian" },
            &test.attacker,
            [test.before, test.after].map(|faults| Some(faults as f64)),
        )
    });
    let [before, after] = &found.traffic;
    let natural = |about, name: &str, figure: fn(&Traffic) -> Option<f64>| Changed {
        starts: Some(after.episodes),
        errors: Some(before.errors + after.errors),
        ..row(about, name, [figure(before), figure(after)])
    };
    let traffic = [
        natural("progress", "mean speed (m/s)", Traffic::speed),
        natural("comfort", "share with hard braking", Traffic::braking_rate),
        natural("comfort", "faults in natural traffic", |traffic| Some(traffic.faults as f64)),
    ];
    keys.chain(tests).chain(traffic).collect()
}

/// The columns of `hardened`.
pub fn columns<'a>() -> Table<'a, Changed<'a>> {
    Table::new(
        "hardened",
        "Several rows for each `harden` of a driver: its keys before and after, and what held-out tests show. Starts of a test are equal before and after.",
    )
    .column(RUN_ID.of(|row: &Changed<'_>| row.job.origin.id.to_string()))
    .column(DRIVER.of(|row: &Changed<'_>| row.job.written.name.clone()))
    .column(RUN.of(|row: &Changed<'_>| row.job.origin.run))
    .text(
        "about",
        "`key`: a varied key, in SI. `pedestrian`, `method`: starts with a fault in a test with a pedestrian or a \
         search. `progress`, `comfort`: natural encounters in the towns of the test",
        |row| row.about.to_string(),
    )
    .text("name", "the key, the pedestrian or search that attacks, or the figure", |row| row.name.clone())
    .text("town", "town of the test", |row| row.town.clone())
    .count("starts", "starts that count, for both where they are pairs", |row| row.starts)
    .number("before", "value before", |row| row.before)
    .number("after", "value after", |row| row.after)
    .count("new_faults", "starts with a fault after and none before", |row| row.new)
    .count("errors", "episodes in which a program failed", |row| row.errors)
}
