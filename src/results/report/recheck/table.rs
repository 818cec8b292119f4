use std::borrow::Cow;

use polars::prelude::{
    Column as Values, DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, LazyFrame, MaintainOrderJoin, NULL,
    PolarsResult, col, lit, when,
};

use super::{CrossedStarts, Encounter, Encounters, RecheckedFailures, RerunOutcome};
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::record::{Column, ColumnReference, Role, Table, TableReference, columns, entries};
use crate::tables::pairs::{PAIRS, ROW, START, after, before, fixed, new, same, sides, starts, sums};
use crate::tables::{adjusted, interval, statistic};
use base::statistics::{clopper_pearson, mcnemar};

// The events of a pair.
const COLLISION: &str = "collision";
const FAULT: &str = "fault";
/// A collision that counts more against its driver than that of the other driver.
const WORSE: &str = "worse";
/// No touch, and none with a driver that sees nobody.
const MISSED: &str = "missed";
/// Expected severe injuries, and those that another driver would have spared.
const INJURY: &str = "injury";
const AVOIDABLE: &str = "avoidable_injury";

/// Whether a driver failed as a program, so that the pair says nothing.
const ERROR: &str = "error";
/// Whether the old driver was run.
const KNOWN: &str = "known";

/// The column of the number of failures that a new driver did not meet.
pub const NOT_MET: &str = "not_met";

/// What a column is counted of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    Pairs,
    /// The starts of the pairs, with the sums over each.
    Starts,
    /// The rows of the table, when the others are there.
    Rows,
}

/// A column: what it is, and what becomes of the pairs, or of the starts, of a row.
#[derive(Clone)]
struct Counted {
    column: ColumnReference,
    of: Of,
    value: Expr,
}

/// Columns that are counted; the comment of each is its meaning.
macro_rules! counted {
    ($($(#[doc = $doc:literal])+ $name:ident: $count:ident($($with:expr),+);)*) => {
        [$($count(stringify!($name), concat!($($doc),+).trim_ascii(), $($with),+)),*].concat()
    };
}

/// A number that is known without the old driver.
fn count_new(of: Of, name: &'static str, doc: &'static str, is: Expr) -> Vec<Counted> {
    vec![Counted { column: Column::<u64>::new(name, "", doc).reference(), of, value: is.cast(DataType::UInt64).sum() }]
}

/// A number of pairs, or of starts; missing if the old driver was not run.
fn count(of: Of, name: &'static str, doc: &'static str, is: Expr) -> Vec<Counted> {
    count_new(of, name, doc, is).into_iter().map(|each| Counted { value: if_known(each.value), ..each }).collect()
}

/// A sum, a mean or a probability.
fn number(of: Of, column: Column<f64>, value: Expr) -> Vec<Counted> {
    vec![Counted { column: column.reference(), of, value }]
}

/// A part of a whole, with its interval.
fn share(name: &'static str, doc: &'static str, counts: [Expr; 2]) -> Vec<Counted> {
    const LOW: &str = "its interval (95 %, Clopper and Pearson): lower end";
    const HIGH: &str = "upper end";
    let sums =
        |counts: [&[f64]; 2]| Some(counts.map(|count| count.iter().sum::<f64>())).filter(|[_, whole]| *whole > 0.0);
    let ratio = statistic(counts.clone(), move |counts| sums(counts).map(|[part, whole]| part / whole));
    let [low, high] = interval(name, counts, move |counts| {
        sums(counts).map(|[part, whole]| clopper_pearson(part as u64, whole as u64, 0.05))
    });
    let parts =
        [("", doc, Role::Share, ratio), ("_low", LOW, Role::LowerBound, low), ("_high", HIGH, Role::UpperBound, high)];
    let column = |(end, doc, role, value): (&str, &'static str, Role, Expr)| {
        let name: Cow<'static, str> = format!("{name}{end}").into();
        let own = Column::<f64>::new("", "", doc).with_role(role).reference();
        Counted { column: ColumnReference { figure: name.clone(), name, ..own }, of: Of::Pairs, value }
    };
    parts.map(column).into()
}

/// Missing if the old driver was not run.
fn if_known(value: Expr) -> Expr {
    when(col(KNOWN).all(true)).then(value).otherwise(lit(NULL))
}

/// Whether the driver before has an event, and whether the driver after has.
fn was(event: &str) -> Expr {
    before(event).gt(lit(0))
}

fn is(event: &str) -> Expr {
    after(event).gt(lit(0))
}

/// A quantity of the driver before and of the driver after.
fn quantity(name: &str) -> [Expr; 2] {
    sides(name).map(col)
}

/// In 1,000 episodes.
fn per_thousand(value: Expr) -> Expr {
    lit(1000.0) * value.mean()
}

/// What is counted of the failures of a report that were met again.
fn of_failures() -> Vec<Counted> {
    let pairs = |name, doc, is| count(Of::Pairs, name, doc, is);
    let sum = |name, doc, value: Expr| number(Of::Pairs, Column::new(name, "", doc), value.sum());
    let [injuries_before, injuries_after] = quantity(AVOIDABLE);
    let is_met = || is(MISSED).not();
    counted! {
        /// collisions in the report, met again; with --sample near misses, too
        failures: pairs(is_valid());
        /// of them faults of the old driver
        old_faults: pairs(was(FAULT));
        /// of these faults, those that the new driver still has
        still_faults: pairs(same(FAULT));
        /// `still_faults` as a share of the `old_faults` that were met
        still_fault_share: share([same(FAULT), was(FAULT).and(is_met())]);
        /// failures that were no fault of the old driver and are one of the new
        turned_faults: pairs(new(FAULT));
        /// `turned_faults` as a share of the `failures` that were met, without `old_faults`
        turned_fault_share: share([new(FAULT), was(FAULT).not().and(is_met())]);
        /// failures that are still collisions with the new driver
        still_collisions: pairs(is(COLLISION));
        /// of these, those that are at least 1 m/s faster, a fault only now, or faster and therefore no fault any more
        still_collisions_worse: pairs(is(WORSE));
        /// of these, those that are at least 1 m/s slower, or no fault any more, and not worse
        still_collisions_better: pairs(fixed(WORSE));
        /// failures that are none any more since the new driver reacts; a pedestrian may bump into the standing car
        gone: pairs(fixed(COLLISION).and(is_met()));
        /// failures of which nothing is known: the pedestrian would miss the new driver even if that saw nobody
        not_met: pairs(was(COLLISION).and(is(MISSED)));
        /// expected severe injuries (AIS 4 or more, or death) in the old driver's faults
        avoidable_injuries_before: sum(injuries_before);
        /// the same in the new driver's
        avoidable_injuries_after: sum(injuries_after);
    }
}

const STARTS: &str = "starts";
const P: &str = "p";
const P_STARTS: &str = "p_starts";

/// What is counted of the fixed list: starts, episodes and starts with a fault, and by how much faults weigh.
fn of_crossings() -> Vec<Counted> {
    let [[injury_before, injury_after], [avoidable_before, avoidable_after]] = [quantity(INJURY), quantity(AVOIDABLE)];
    let difference = per_thousand(avoidable_after.clone()) - per_thousand(avoidable_before.clone());
    let [fixed_start, new_start] = [was(FAULT).and(is(FAULT).not()), was(FAULT).not().and(is(FAULT))];
    let [before, after] = [avoidable_before.clone(), avoidable_after.clone()];
    let [worse, better] = [after.clone().gt(before.clone()), after.lt(before)];
    // McNemar's test, or the sign test, of two numbers of starts.
    let exact = |starts: [Expr; 2]| {
        let sum = |starts: &[f64]| starts.iter().sum::<f64>() as u64;
        if_known(statistic(starts, move |[fixed, new]| Some(mcnemar(sum(fixed), sum(new)))))
    };
    let tested =
        when((col("fault_starts_new") + col("fault_starts_fixed")).gt(lit(0))).then(col(P)).otherwise(lit(NULL));
    let episodes = |name, doc, is| count(Of::Pairs, name, doc, is);
    let episodes_new = |name, doc, is| count_new(Of::Pairs, name, doc, is);
    let starts = |name, doc, is| count(Of::Starts, name, doc, is);
    let starts_new = |name, doc, is| count_new(Of::Starts, name, doc, is);
    let share = |name, doc, value| number(Of::Starts, Column::new(name, "", doc).with_role(Role::Share), value);
    let p = |name, doc, of, value| number(of, Column::new(name, "", doc).with_role(Role::AdjustedP), value);
    let injuries = |name, doc, value| number(Of::Pairs, Column::new(name, "1/1000", doc), value);
    counted! {
        /// starts
        starts: starts_new(col(PAIRS).gt(lit(0)));
        /// episodes that are a fault of the old driver
        faults_before: episodes(was(FAULT));
        /// episodes that are a fault of the new driver
        faults_after: episodes_new(is(FAULT));
        /// of the new driver only
        faults_new: episodes(new(FAULT));
        /// of the old driver only
        faults_fixed: episodes(fixed(FAULT));
        /// of both
        faults_same: episodes(same(FAULT));
        /// starts from which an episode is a fault of the old driver
        fault_starts_before: starts(was(FAULT));
        /// the same of the new driver
        fault_starts_after: starts_new(is(FAULT));
        /// such starts of the new driver only
        fault_starts_new: starts(new_start.clone());
        /// such starts of the old driver only
        fault_starts_fixed: starts(fixed_start.clone());
        /// such starts of both
        fault_starts_same: starts(was(FAULT).and(is(FAULT)));
        /// share of the starts with a fault of the old driver
        fault_share_before: share(if_known(was(FAULT).mean()));
        /// the same of the new driver
        fault_share_after: share(is(FAULT).mean());
        /// probability of such a change of the share by chance: McNemar's exact test over starts
        p: p(Of::Starts, exact([fixed_start, new_start]));
        /// the same, adjusted by Holm's method for all rows in which a start differs; else 1
        p_holm: p(Of::Rows, adjusted(tested).fill_null(col(P)));
        /// starts from which the new driver's faults weigh more (avoidable injury)
        starts_worse: starts(worse.clone());
        /// starts from which they weigh less
        starts_better: starts(better.clone());
        /// probability of a difference at least this large between the numbers of worse and better starts by chance: the exact sign test
        p_starts: p(Of::Starts, exact([better, worse]));
        /// expected severe injuries (AIS 4 or more, or death) in the old driver's faults, for 1,000 episodes
        avoidable_injury_before: injuries(per_thousand(avoidable_before));
        /// the same in the new driver's
        avoidable_injury_after: injuries(per_thousand(avoidable_after));
        /// after less before
        avoidable_injury_difference: injuries(difference);
        /// expected severe injuries in all collisions of the new driver, avoidable or not, less the old driver's
        injury_difference: injuries(per_thousand(injury_after - injury_before));
    }
}

columns! {
    /// episodes left out, since a driver, a pedestrian or the world failed as a program
    FAILED: Column<u64> = "failed_encounters";
    /// name of the new driver
    OTHER_DRIVER: Column<String> = "other_driver";
}

/// The first columns of the failures that were met again.
fn failures_key() -> Table<'static, RecheckedFailures> {
    Table::new("recheck_failures", "One row for each driver, town, world, source of failures and walk.").columns(
        entries! { row: &RecheckedFailures;
            DRIVER = row.policies[0].clone();
            OTHER_DRIVER = row.policies[1].clone();
            TOWN = row.town.clone();
            WORLD = row.world.clone();
            /// `evaluation` or `search`
            found_in: String = row.found_in.name();
            /// what moves the pedestrian: `pedestrian`, or the recorded `commands`
            walked_by: String = row.walked_by.name();
        },
    )
}

/// The first columns of the fixed list.
fn crossings_key() -> Table<'static, CrossedStarts> {
    Table::new(
        "recheck_crossings",
        "One row for each driver, town and setup: an episode for every walk of a grid, from the same starts.",
    )
    .columns(entries! { row: &CrossedStarts;
        DRIVER = row.policies[0].clone();
        OTHER_DRIVER = row.policies[1].clone();
        TOWN = row.town.clone();
        WORLD = row.world.clone();
        /// number of the spawn, episode and pedestrian in the town, from 0
        setup: u64 = row.setup;
        /// episodes from each start
        crossings: u64 = row.crossings;
    })
}

/// The columns of a table with this key.
fn reference(key: TableReference, counted: &[Counted]) -> TableReference {
    let counted = counted.iter().map(|counted| counted.column.clone());
    TableReference { columns: key.columns.into_iter().chain(counted).chain([FAILED.reference()]).collect(), ..key }
}

/// The columns of [`rechecked_table`].
pub fn rechecked_reference() -> TableReference {
    reference(failures_key().reference(), &of_failures())
}

/// The columns of [`crossed_table`].
pub fn crossed_reference() -> TableReference {
    let key = crossings_key().reference();
    let before_crossings = key.columns.len() - 1;
    let mut table = reference(key, &of_crossings());
    // The starts come before their episodes.
    table.columns.swap(before_crossings, before_crossings + 1);
    table
}

/// The failures of a report that were met again as a table, one row for each set.
pub fn rechecked_table(rows: &[RecheckedFailures]) -> DataFrame {
    let encounters = rows.iter().map(|row| &row.encounters);
    counted_table(failures_key().frame(rows), encounters, &of_failures(), &rechecked_reference()).expect(HAS_COLUMNS)
}

/// The fixed list as a table, one row for each driver, town and setup.
pub fn crossed_table(rows: &[CrossedStarts]) -> DataFrame {
    let encounters = rows.iter().map(|row| &row.encounters);
    counted_table(crossings_key().frame(rows), encounters, &of_crossings(), &crossed_reference()).expect(HAS_COLUMNS)
}

const HAS_COLUMNS: &str = "a table of pairs has a column for each event";

/// Rows with what is counted of their encounters.
fn counted_table<'a>(
    rows: DataFrame,
    encounters: impl Iterator<Item = &'a Encounters>,
    counted: &[Counted],
    reference: &TableReference,
) -> PolarsResult<DataFrame> {
    let values = |of: Of| -> Vec<Expr> {
        let own = counted.iter().filter(|counted| counted.of == of);
        own.map(|counted| counted.value.clone().alias(&*counted.column.name)).collect()
    };
    let all = pairs(encounters);
    let valid = all.clone().filter(is_valid());
    let weights = sides(AVOIDABLE).map(|side| col(&side).sum().alias(side));
    let starts = starts(valid.clone(), sums(FAULT).into_iter().chain(weights).chain([col(KNOWN).all(true)]));
    let failed = vec![col(ERROR).cast(DataType::UInt64).sum().alias(FAILED.name), col(KNOWN).all(true)];
    let mut table = rows.lazy().with_row_index(ROW, None);
    for (part, values) in [(valid, values(Of::Pairs)), (starts, values(Of::Starts)), (all, failed)] {
        let order = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Left) };
        table = table.join(part.group_by_stable([col(ROW)]).agg(values), [col(ROW)], [col(ROW)], order);
    }
    let mut columns = counted.iter().map(|counted| counted.column.clone()).collect::<Vec<_>>();
    columns.push(FAILED.reference());
    table
        .with_columns(columns.iter().filter_map(of_no_pair).collect::<Vec<_>>())
        .with_columns(values(Of::Rows))
        .select(reference.columns.iter().map(|column| col(&*column.name)).collect::<Vec<_>>())
        .collect()
}

/// What a row has whose pairs are all in error: its counts are 0, and nothing tells its drivers apart. Without any pair it has no starts.
fn of_no_pair(column: &ColumnReference) -> Option<Expr> {
    let name = &*column.name;
    let value = match column.holds {
        DataType::UInt64 => lit(0_u64),
        _ if [P, P_STARTS].contains(&name) => lit(1.0),
        _ => return None,
    };
    let is_none = col(name).is_null().and(col(KNOWN).or(lit([STARTS, FAILED.name].contains(&name))));
    Some(when(is_none).then(value).otherwise(col(name)).alias(name))
}

/// The pairs of several rows.
fn pairs<'a>(rows: impl Iterator<Item = &'a Encounters>) -> LazyFrame {
    let of_row = |(row, encounters): (u32, &'a Encounters)| encounters.0.iter().map(move |each| (row, each));
    let all: Vec<(u32, &Encounter)> = (0..).zip(rows).flat_map(of_row).collect();
    let flags = |name: &str, is: &dyn Fn(&Encounter) -> Option<bool>| {
        Values::new(name.into(), all.iter().map(|(_, each)| is(each)).collect::<Vec<_>>())
    };
    let mut columns = vec![
        Values::new(ROW.into(), all.iter().map(|(row, _)| *row).collect::<Vec<_>>()),
        Values::new(START.into(), all.iter().map(|(_, each)| each.start).collect::<Vec<_>>()),
        flags(KNOWN, &|each| Some(each.before.is_some())),
        flags(ERROR, &|each| Some(each.is_error())),
    ];
    for side in 0..2 {
        let ends = |each: &Encounter| {
            let ends = [each.before, Some(each.after)];
            [ends[side], ends[1 - side]]
        };
        let name = |event: &str| sides(event)[side].clone();
        let quantities = |event: &str, of: fn(&RerunOutcome) -> f64| {
            let values = all.iter().map(|(_, each)| ends(each)[0].as_ref().map(of));
            Values::new(name(event).into(), values.collect::<Vec<_>>())
        };
        let is_worse = |each: &Encounter| {
            let [own, other] = ends(each).map(|end| end.map(|end| end.collision()));
            Some(own?.zip(other?).is_some_and(|(own, other)| own.is_worse_than(&other)))
        };
        columns.extend([
            flags(&name(COLLISION), &|each| Some(ends(each)[0]?.is_collision())),
            flags(&name(FAULT), &|each| Some(ends(each)[0]?.fault)),
            flags(&name(MISSED), &|each| Some(ends(each)[0]?.is_missed)),
            flags(&name(WORSE), &is_worse),
            quantities(INJURY, RerunOutcome::injury),
            quantities(AVOIDABLE, RerunOutcome::avoidable_injury),
        ]);
    }
    DataFrame::new(all.len(), columns).expect(HAS_COLUMNS).lazy()
}

fn is_valid() -> Expr {
    col(ERROR).not()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A start for each word; each letter is a crossing: `n`ew, `f`ixed, `s`ame, `e`rror, or none.
    fn crossed(starts: &[&str]) -> CrossedStarts {
        let met = |fault: bool| RerunOutcome { impact_speed: fault.then_some(10.0), fault, ..RerunOutcome::default() };
        let encounter = |start: usize, crossing: usize, letter: char| Encounter {
            name: String::new(),
            start: start as u64,
            crossing: crossing as u64,
            before: Some(met(matches!(letter, 'f' | 's'))),
            after: if letter == 'e' { RerunOutcome::error() } else { met(matches!(letter, 'n' | 's')) },
            incident: None,
        };
        let of = |(start, word): (usize, &&str)| -> Vec<Encounter> {
            word.chars().enumerate().map(|(crossing, letter)| encounter(start, crossing, letter)).collect()
        };
        CrossedStarts {
            policies: ["old".into(), "new".into()],
            town: "harbour".into(),
            world: "here".into(),
            setup: 0,
            crossings: 4,
            encounters: Encounters(starts.iter().enumerate().flat_map(of).collect()),
        }
    }

    fn number(table: &DataFrame, row: usize, column: &str) -> Option<f64> {
        table.column(column).unwrap().get(row).unwrap().extract()
    }

    #[test]
    fn starts_and_crossings_are_counted_apart() {
        let table = crossed_table(&[crossed(&["n...", "nn..", "ns..", "f...", "ff.s", "...e"])]);
        let counts = [
            ("starts", 6.0),
            ("fault_starts_new", 2.0),
            ("fault_starts_fixed", 1.0),
            ("fault_starts_after", 4.0),
            ("faults_new", 4.0),
            ("faults_fixed", 3.0),
            ("failed_encounters", 1.0),
            ("p", 1.0), // two against one
            ("fault_share_after", 4.0 / 6.0),
        ];
        for (column, count) in counts {
            assert_eq!(number(&table, 0, column), Some(count), "{column}");
        }
        let risk = verdict::severe_injury_risk(10.0);
        let near = |column: &str, value: f64| assert!((number(&table, 0, column).unwrap() - value).abs() < 1e-9);
        near("avoidable_injury_after", 1000.0 * risk * 6.0 / 23.0);
        // Six collisions now, and five before.
        near("injury_difference", 1000.0 * risk * 1.0 / 23.0);
    }

    #[test]
    fn six_starts_that_are_all_worse_are_no_chance() {
        // A start from which there was a fault before can be worse, too.
        let lists = [&["n"; 6], &["sn"; 6]].map(|starts| crossed(starts));
        let table = crossed_table(&lists);
        assert!((number(&table, 0, "p").unwrap() - 2.0 / 64.0).abs() < 1e-12);
        assert_eq!((number(&table, 1, "p"), number(&table, 1, "p_holm")), (Some(1.0), Some(1.0)));
        assert!((number(&table, 1, "p_starts").unwrap() - 2.0 / 64.0).abs() < 1e-12);
    }

    #[test]
    fn without_the_old_driver_nothing_is_new() {
        let mut alone = crossed(&["n", "s"]);
        alone.encounters.0.iter_mut().for_each(|encounter| encounter.before = None);
        let table = crossed_table(&[alone, crossed(&[])]);
        let unknown = [
            "p",
            "p_holm",
            "p_starts",
            "fault_starts_new",
            "faults_before",
            "fault_share_before",
            "avoidable_injury_before",
            "injury_difference",
        ];
        for column in unknown {
            assert_eq!(number(&table, 0, column), None, "{column}");
        }
        let known = ["fault_starts_after", "faults_after", "starts", "fault_share_after"]
            .map(|column| number(&table, 0, column));
        assert_eq!(known, [Some(2.0), Some(2.0), Some(2.0), Some(1.0)]);
        // Of no episode nothing is known.
        assert_eq!((number(&table, 1, "starts"), number(&table, 1, "p")), (Some(0.0), None));
    }

    #[test]
    fn where_all_are_in_error_nothing_is_counted() {
        let table = crossed_table(&[crossed(&["ee"])]);
        let counts = ["failed_encounters", "starts", "faults_before", "fault_starts_new", "p"];
        let counts = counts.map(|column| number(&table, 0, column));
        assert_eq!(counts, [Some(2.0), Some(0.0), Some(0.0), Some(0.0), Some(1.0)]);
    }

    #[test]
    fn the_columns_are_those_of_the_reference() {
        let list = crossed_table(&[]);
        let names: Vec<_> = crossed_reference().columns.iter().map(|column| column.name.to_string()).collect();
        assert_eq!(list.get_column_names_owned(), names);
        for column in crossed_reference().columns {
            assert_eq!(*list.column(&column.name).unwrap().dtype(), column.holds, "{}", column.name);
        }
    }
}
