mod section;
mod table;

use super::{Kind, Measurement};
use crate::campaign::{Part, TaskError};
use crate::report::Group;
use compile::Harden;
use search::hardening::{Hardened, harden};
use verdict::Traffic;

pub(super) const KIND: Kind = Kind {
    doing: ["hardening", "hardened"],
    references: || vec![table::columns().reference()],
    tables: |found| {
        let rows: Vec<_> = found.finished.found_if_any()?.into_iter().flat_map(table::rows).collect();
        Some(vec![("hardened", table::columns().frame(&rows))])
    },
    section: Some((Group::Failures, section::hardened)),
    ..Kind::new::<Harden>("harden", "hardenings", "harden")
};

/// A hardening, and what came of it.
type Row<'a> = (&'a Harden, &'a Hardened);

impl Measurement for Harden {
    type Found = Hardened;

    const KIND: &'static Kind = &KIND;

    fn budget(&self) -> u64 {
        Harden::budget(self)
    }

    fn units_of(&self, _: Option<&Hardened>) -> u64 {
        Harden::budget(self)
    }

    fn note(&self, found: &Hardened) -> String {
        let Totals { starts, before, after, new } = Totals::of(found);
        let lost = lost_progress(&found.traffic)
            .map_or(String::new(), |lost| format!(", {:.1} % less progress", 100.0 * lost));
        format!("faults {before} -> {after} of {starts} starts ({new} new){lost}")
    }

    fn errors(found: &Hardened) -> u64 {
        let traffic = found.traffic.iter().map(|traffic| traffic.errors);
        traffic.chain(found.tests.iter().map(|test| test.errors)).sum()
    }

    fn measure(&self, part: &Part<'_>) -> (Option<Hardened>, Option<TaskError>) {
        let found = harden(&self.hardening, &self.seed(part.seed), &|| part.is_late(), &part.counter());
        match (part.own_limit(), found) {
            (Some(limit), _) => (None, Some(limit)),
            (None, Ok(found)) => (found, None),
            (None, Err(error)) => (None, Some(TaskError::Training(error))),
        }
    }
}

/// Starts with a fault of all tests together, and what they cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Totals {
    starts: u64,
    before: u64,
    after: u64,
    new: u64,
}

impl Totals {
    /// Adds up the tests.
    fn of(found: &Hardened) -> Self {
        found.tests.iter().fold(Self::default(), |all, test| Self {
            starts: all.starts + test.starts,
            before: all.before + test.before,
            after: all.after + test.after,
            new: all.new + test.new,
        })
    }
}

/// Share of the mean speed in natural traffic that is lost; negative when it is gained.
fn lost_progress([before, after]: &[Traffic; 2]) -> Option<f64> {
    let before = before.speed().filter(|speed| *speed > 0.0)?;
    Some(1.0 - after.speed()? / before)
}
