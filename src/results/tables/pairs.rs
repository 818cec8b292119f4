//! Pairs of episodes of two drivers from equal starts: what a comparison and a recheck count.
//!
//! A row is a pair. It has the row of the result that it belongs to, the number of its start, and of each event whether it is in the episode of the driver
//! before and in that of the driver after. Summed over the pairs of a start, the events are counts, and the same expressions hold.

use polars::prelude::{DataFrame, DataType, Expr, IntoLazy, LazyFrame, PolarsResult, col, len, lit};

/// The column of the row of the result.
pub const ROW: &str = "row";
/// The column of the number of the start.
pub const START: &str = "start_number";
/// The column of the number of pairs of a start.
pub const PAIRS: &str = "pairs";

/// The columns of an event: in the episode before, and in that after.
pub fn sides(event: &str) -> [String; 2] {
    ["before", "after"].map(|side| format!("{event}_{side}"))
}

/// How often the driver before has an event; missing if that was not run.
pub fn before(event: &str) -> Expr {
    count(event, 0)
}

/// How often the driver after has an event.
pub fn after(event: &str) -> Expr {
    count(event, 1)
}

fn count(event: &str, side: usize) -> Expr {
    col(&sides(event)[side]).cast(DataType::UInt32)
}

/// Whether the driver before has it more often.
pub fn fixed(event: &str) -> Expr {
    before(event).gt(after(event))
}

/// Whether the driver after has it more often.
pub fn new(event: &str) -> Expr {
    after(event).gt(before(event))
}

/// Whether both have it, and as often.
pub fn same(event: &str) -> Expr {
    before(event).eq(after(event)).and(after(event).gt(lit(0)))
}

/// How often each side has an event.
pub fn sums(event: &str) -> [Expr; 2] {
    let [was, is] = sides(event);
    [before(event).sum().alias(was), after(event).sum().alias(is)]
}

/// The starts of each row: the number of their pairs, and sums over these.
pub fn starts(pairs: LazyFrame, sums: impl IntoIterator<Item = Expr>) -> LazyFrame {
    let all: Vec<Expr> = std::iter::once(len().alias(PAIRS)).chain(sums).collect();
    pairs.group_by_stable([col(ROW), col(START)]).agg(all)
}

/// The number of rows with an event on one side or on both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Changed {
    /// On the first side only, or more often.
    pub fixed: u64,
    /// On the second side only, or more often.
    pub new: u64,
    /// On both sides alike.
    pub same: u64,
}

impl Changed {
    /// Of pairs, or of starts, for each event.
    ///
    /// # Errors
    /// Those of polars; none for a table with these events.
    pub fn of(rows: &DataFrame, events: &[String]) -> PolarsResult<Vec<Self>> {
        let sums = |(place, event): (usize, &String)| {
            let sum = |is: Expr, name: &str| is.cast(DataType::UInt64).sum().alias(format!("{place} {name}"));
            [sum(fixed(event), "fixed"), sum(new(event), "new"), sum(same(event), "same")]
        };
        let found =
            rows.clone().lazy().select(events.iter().enumerate().flat_map(sums).collect::<Vec<_>>()).collect()?;
        let changed = |place: usize| {
            let count = |name: &str| -> PolarsResult<u64> {
                Ok(found.column(&format!("{place} {name}"))?.u64()?.get(0).unwrap_or_default())
            };
            Ok(Self { fixed: count("fixed")?, new: count("new")?, same: count("same")? })
        };
        (0..events.len()).map(changed).collect()
    }

    /// Adds other rows.
    pub fn add(&mut self, other: Self) {
        self.fixed += other.fixed;
        self.new += other.new;
        self.same += other.same;
    }

    /// Counts an event of a pair.
    pub fn count(&mut self, before: bool, after: bool) {
        match (before, after) {
            (false, false) => {}
            (true, true) => self.same += 1,
            (true, false) => self.fixed += 1,
            (false, true) => self.new += 1,
        }
    }

    /// Whether no row differs.
    pub fn is_same(self) -> bool {
        self.fixed + self.new == 0
    }
}
