use super::{Kind, Measurement};
use crate::campaign::{Part, TaskError};
use crate::record::columns::{DRIVER, RUN_ID, TOWN};
use crate::record::{Table, columns, entries, interval};
use base::statistics::wilson;
use compile::Pricing;
use verdict::Price;

columns! {
    /// way of the car without a pedestrian, as a share of the way of a car that drives as fast as limits and bends (2 m/s²) allow from the same starts; traffic lights are off
    pub PROGRESS: Column<f64> = "progress";
    /// encounters with a natural pedestrian whom the car passes with 2 m or more to spare, as it drives without anybody
    pub SPARED: Column<u64> = "spared_encounters";
}
/// The name of the table.
pub const PRICES: &str = "prices";
/// The share of these in which the car is delayed.
pub const NEEDLESS: &str = "needless_braking";

pub(super) const KIND: Kind = Kind {
    doing: ["pricing", "priced"],
    unit: "starts",
    seconds: 1e-3,
    references: || vec![columns().reference()],
    tables: |found| Some(vec![(PRICES, columns().frame(&found.finished.found_if_any()?))]),
    ..Kind::new::<Pricing>("price", "prices", "price")
};

impl Measurement for Pricing {
    type Found = Price;

    const KIND: &'static Kind = &KIND;

    fn units_of(&self, found: Option<&Price>) -> u64 {
        found.map_or(0, |_| self.starts.into())
    }

    fn note(&self, found: &Price) -> String {
        let progress = found.progress().map(|(share, _)| format!("progress {share:.2}, ")).unwrap_or_default();
        format!("{progress}{} of {} encounters braked needlessly", found.delayed, found.spared)
    }

    fn errors(found: &Price) -> u64 {
        found.errors
    }

    fn measure(&self, part: &Part<'_>) -> (Option<Price>, Option<TaskError>) {
        let mut stop = |started: u32| {
            part.progress(started.into());
            part.is_late()
        };
        match Price::new(&self.scenario, &self.free, self.starts, &self.drawn(part.seed), &mut stop) {
            None => (None, part.own_limit()),
            found => (found, None),
        }
    }
}

/// The columns of the table: a row for each driver and town.
pub fn columns<'a>() -> Table<'a, (&'a Pricing, &'a Price)> {
    type Row<'a> = (&'a Pricing, &'a Price);
    Table::<Row<'a>>::new(
        PRICES,
        "One row for each driver and town: what the driver gives for safety. Its episodes are those of the first setting in which the campaign tries it, with one natural pedestrian \
         or none, for up to 30 s.",
    )
    .columns(entries! { row: &Row<'_>;
        RUN_ID = row.0.origin.id.to_string();
        TOWN = row.0.town.clone();
        DRIVER = row.0.policy.clone();
        /// starts
        starts: u64 = row.1.starts;
        PROGRESS = row.1.progress().map(|(share, _)| share);
    })
    .columns(interval(PROGRESS.name, PROGRESS.name, "95 % interval over starts", |row: &Row<'_>| row.1.progress()?.1))
    .columns(entries! { row: &Row<'_>;
        SPARED = row.1.spared;
        /// share of these in which it needs a second longer for its way than without anybody
        named(NEEDLESS): f64 as Share = row.1.needless();
    })
    .columns(interval(NEEDLESS, NEEDLESS, "Wilson's 95 % interval", |row: &Row<'_>| {
        (row.1.spared > 0).then(|| wilson(row.1.delayed, row.1.spared))
    }))
}
