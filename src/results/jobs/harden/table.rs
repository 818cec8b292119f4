use super::Row;
use crate::record::columns::{DRIVER, RUN, RUN_ID};
use crate::record::{Table, entries};
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
    .columns(entries! { row: &Changed<'_>;
        RUN_ID = row.job.origin.id.to_string();
        DRIVER = row.job.written.name.clone();
        RUN = row.job.origin.run;
        /// `key`: a varied key, in SI. `pedestrian`, `method`: starts with a fault in a test with a pedestrian or a search. `progress`, `comfort`: natural
        /// encounters in the towns of the test
        about: String = row.about.to_string();
        /// the key, the pedestrian or search that attacks, or the figure
        name: String = row.name.clone();
        /// town of the test
        town: String = row.town.clone();
        /// starts that count, for both where they are pairs
        starts: u64 = row.starts;
        /// value before
        before: f64 = row.before;
        /// value after
        after: f64 = row.after;
        /// starts with a fault after and none before
        new_faults: u64 = row.new;
        /// episodes in which a program failed
        errors: u64 = row.errors;
    })
}
