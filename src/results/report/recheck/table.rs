use polars::prelude::{
    Column as Values, DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, LazyFrame, MaintainOrderJoin, NULL,
    NamedFrom, PolarsResult, Series, col, lit, when,
};

use super::{CrossedStarts, Encounter, Encounters, RecheckedFailures, RerunOutcome};
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::record::{Column, ColumnReference, Entry, Role, Table, TableReference};
use crate::tables::pairs::{PAIRS, ROW, START, after, before, fixed, new, same, sides, starts, sums};
use base::statistics::{clopper_pearson, holm, mcnemar};

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
/// The failures that were met: faults of the old driver, and the others.
const MET_FAULTS: &str = "met_faults";
const MET_OTHERS: &str = "met_others";

/// The column of the number of failures that a new driver did not meet.
pub const NOT_MET: &str = "not_met";

/// A column: what it is, and what becomes of the pairs, or of the starts, of a row.
struct Counted {
    column: ColumnReference,
    value: Expr,
}

/// A number of pairs, or of starts; missing if the old driver was not run.
fn count(name: &'static str, doc: &'static str, is: Expr) -> Counted {
    let counted = count_new(name, doc, is);
    Counted { value: when(col(KNOWN).all(true)).then(counted.value).otherwise(lit(NULL)), ..counted }
}

/// A number that is known without the old driver.
fn count_new(name: &'static str, doc: &'static str, is: Expr) -> Counted {
    Counted { column: Column::<u64>::new(name, "", doc).reference(), value: is.cast(DataType::UInt64).sum() }
}

/// A sum or a mean over the pairs.
fn measure(name: &'static str, unit: &'static str, doc: &'static str, value: Expr) -> Counted {
    Counted { column: Column::<f64>::new(name, unit, doc).reference(), value }
}

/// What follows from counts.
const fn derived(name: &'static str, doc: &'static str, role: Role) -> Column<f64> {
    Column::new(name, "", doc).with_role(role)
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

const LOW: &str = "its interval (95 %, Clopper and Pearson): lower end";
const HIGH: &str = "upper end";
const STILL: [Column<f64>; 3] = [
    derived("still_fault_share", "`still_faults` as a share of the `old_faults` that were met", Role::Share),
    derived("still_fault_share_low", LOW, Role::LowerBound),
    derived("still_fault_share_high", HIGH, Role::UpperBound),
];
const TURNED: [Column<f64>; 3] = [
    derived(
        "turned_fault_share",
        "`turned_faults` as a share of the `failures` that were met, without `old_faults`",
        Role::Share,
    ),
    derived("turned_fault_share_low", LOW, Role::LowerBound),
    derived("turned_fault_share_high", HIGH, Role::UpperBound),
];

/// What is counted of the failures of a report that were met again: faults, and those that were none.
fn of_failures() -> [Vec<Counted>; 3] {
    let [injuries_before, injuries_after] = quantity(AVOIDABLE);
    let faults = vec![
        count("failures", "collisions in the report, met again; with --sample near misses, too", is_valid()),
        count("old_faults", "of them faults of the old driver", was(FAULT)),
        count("still_faults", "of these faults, those that the new driver still has", same(FAULT)),
    ];
    let turned = vec![count(
        "turned_faults",
        "failures that were no fault of the old driver and are one of the new",
        new(FAULT),
    )];
    let collisions = vec![
        count("still_collisions", "failures that are still collisions with the new driver", is(COLLISION)),
        count(
            "still_collisions_worse",
            "of these, those that are at least 1 m/s faster, a fault only now, or faster and therefore no fault any more",
            is(WORSE),
        ),
        count(
            "still_collisions_better",
            "of these, those that are at least 1 m/s slower, or no fault any more, and not worse",
            fixed(WORSE),
        ),
        count(
            "gone",
            "failures that are none any more since the new driver reacts; a pedestrian may bump into the standing car",
            fixed(COLLISION).and(is(MISSED).not()),
        ),
        count(
            NOT_MET,
            "failures of which nothing is known: the pedestrian would miss the new driver even if that saw nobody",
            was(COLLISION).and(is(MISSED)),
        ),
        measure(
            "avoidable_injuries_before",
            "",
            "expected severe injuries (AIS 4 or more, or death) in the old driver's faults",
            injuries_before.sum(),
        ),
        measure("avoidable_injuries_after", "", "the same in the new driver's", injuries_after.sum()),
    ];
    [faults, turned, collisions]
}

/// What is counted of the episodes of the fixed list: faults, and injuries.
fn of_episodes() -> [Vec<Counted>; 2] {
    let [[injury_before, injury_after], [avoidable_before, avoidable_after]] = [quantity(INJURY), quantity(AVOIDABLE)];
    let difference = per_thousand(avoidable_after.clone()) - per_thousand(avoidable_before.clone());
    let faults = vec![
        count("faults_before", "episodes that are a fault of the old driver", was(FAULT)),
        count_new("faults_after", "episodes that are a fault of the new driver", is(FAULT)),
        count("faults_new", "of the new driver only", new(FAULT)),
        count("faults_fixed", "of the old driver only", fixed(FAULT)),
        count("faults_same", "of both", same(FAULT)),
    ];
    let injuries = vec![
        measure(
            "avoidable_injury_before",
            "1/1000",
            "expected severe injuries (AIS 4 or more, or death) in the old driver's faults, for 1,000 episodes",
            per_thousand(avoidable_before),
        ),
        measure("avoidable_injury_after", "1/1000", "the same in the new driver's", per_thousand(avoidable_after)),
        measure("avoidable_injury_difference", "1/1000", "after less before", difference),
        measure(
            "injury_difference",
            "1/1000",
            "expected severe injuries in all collisions of the new driver, avoidable or not, less the old driver's",
            per_thousand(injury_after - injury_before),
        ),
    ];
    [faults, injuries]
}

/// What is counted of its starts: those with a fault, and by how much their faults weigh.
fn of_starts() -> [Vec<Counted>; 2] {
    let [weight_before, weight_after] = quantity(AVOIDABLE);
    let faults = vec![
        count("fault_starts_before", "starts from which an episode is a fault of the old driver", was(FAULT)),
        count_new("fault_starts_after", "the same of the new driver", is(FAULT)),
        count("fault_starts_new", "such starts of the new driver only", was(FAULT).not().and(is(FAULT))),
        count("fault_starts_fixed", "such starts of the old driver only", was(FAULT).and(is(FAULT).not())),
        count("fault_starts_same", "such starts of both", was(FAULT).and(is(FAULT))),
    ];
    let weights = vec![
        count(
            "starts_worse",
            "starts from which the new driver's faults weigh more (avoidable injury)",
            weight_after.clone().gt(weight_before.clone()),
        ),
        count("starts_better", "starts from which they weigh less", weight_after.lt(weight_before)),
    ];
    [faults, weights]
}

const SHARES: [Column<f64>; 2] = [
    derived("fault_share_before", "share of the starts with a fault of the old driver", Role::Share),
    derived("fault_share_after", "the same of the new driver", Role::Share),
];
const P: Column<f64> = derived(
    "p",
    "probability of such a change of the share by chance: McNemar's exact test over starts",
    Role::AdjustedP,
);
const P_HOLM: Column<f64> = derived(
    "p_holm",
    "the same, adjusted by Holm's method for all rows in which a start differs; else 1",
    Role::AdjustedP,
);
const P_STARTS: Column<f64> = derived(
    "p_starts",
    "probability of a difference at least this large between the numbers of worse and better starts by chance: the exact sign test",
    Role::AdjustedP,
);
const STARTS: Column<u64> = Column::new("starts", "", "starts");
const FAILED: Column<u64> = Column::new(
    "failed_encounters",
    "",
    "episodes left out, since a driver, a pedestrian or the world failed as a program",
);

/// The first columns of the failures that were met again.
fn failures_key() -> Table<'static, RecheckedFailures> {
    type Row = RecheckedFailures;
    Table::new("recheck_failures", "One row for each driver, town, world, source of failures and walk.")
        .column(DRIVER.of(|row: &Row| row.policies[0].clone()))
        .column(OTHER_DRIVER.of(|row: &Row| row.policies[1].clone()))
        .column(TOWN.of(|row: &Row| row.town.clone()))
        .column(WORLD.of(|row: &Row| row.world.clone()))
        .text("found_in", "`evaluation` or `search`", |row| row.found_in.name())
        .text("walked_by", "what moves the pedestrian: `pedestrian`, or the recorded `commands`", |row| {
            row.walked_by.name()
        })
}

const OTHER_DRIVER: Column<String> = Column::new("other_driver", "", "name of the new driver");
const SETUP: Column<u64> = Column::new("setup", "", "number of the spawn, episode and pedestrian in the town, from 0");
const CROSSINGS: Column<u64> = Column::new("crossings", "", "episodes from each start");

/// The first columns of the fixed list.
fn crossings_key() -> Table<'static, CrossedStarts> {
    type Row = CrossedStarts;
    Table::new(
        "recheck_crossings",
        "One row for each driver, town and setup: an episode for every walk of a grid, from the same starts.",
    )
    .column(DRIVER.of(|row: &Row| row.policies[0].clone()))
    .column(OTHER_DRIVER.of(|row: &Row| row.policies[1].clone()))
    .column(TOWN.of(|row: &Row| row.town.clone()))
    .column(WORLD.of(|row: &Row| row.world.clone()))
    .column(SETUP.of(|row: &Row| row.setup))
    .column(CROSSINGS.of(|row: &Row| row.crossings))
}

fn references(counted: &[Counted]) -> impl Iterator<Item = ColumnReference> {
    counted.iter().map(|counted| counted.column.clone())
}

/// The columns of [`rechecked_table`].
pub fn rechecked_reference() -> TableReference {
    let [faults, turned, collisions] = of_failures();
    let mut table = failures_key().reference();
    table.columns.extend(references(&faults).chain(STILL.iter().map(Column::reference)));
    table.columns.extend(references(&turned).chain(TURNED.iter().map(Column::reference)));
    table.columns.extend(references(&collisions).chain([FAILED.reference()]));
    table
}

/// The columns of [`crossed_table`].
pub fn crossed_reference() -> TableReference {
    let ([faults, injuries], [fault_starts, weights]) = (of_episodes(), of_starts());
    let mut table = crossings_key().reference();
    // The starts come before their episodes.
    table.columns.insert(table.columns.len() - 1, STARTS.reference());
    table.columns.extend(references(&faults).chain(references(&fault_starts)));
    table.columns.extend([&SHARES[0], &SHARES[1], &P, &P_HOLM].map(Column::reference));
    table.columns.extend(references(&weights).chain([P_STARTS.reference()]));
    table.columns.extend(references(&injuries).chain([FAILED.reference()]));
    table
}

/// The failures of a report that were met again as a table, one row for each set.
pub fn rechecked_table(rows: &[RecheckedFailures]) -> DataFrame {
    let mut counted: Vec<Counted> = of_failures().into_iter().flatten().collect();
    let is_met = || is(MISSED).not();
    counted.push(count(MET_FAULTS, "", was(FAULT).and(is_met())));
    counted.push(count(MET_OTHERS, "", was(FAULT).not().and(is_met())));
    let made = || {
        let pairs = pairs(rows.iter().map(|row| &row.encounters));
        let table = aggregated(failures_key().frame(rows), pairs.clone().filter(is_valid()), &counted)?;
        let mut table = with_failed(table, pairs)?;
        for (columns, part, whole) in [(&STILL, "still_faults", MET_FAULTS), (&TURNED, "turned_faults", MET_OTHERS)] {
            let share = |[part, whole]: [u64; 2]| {
                let (low, high) = clopper_pearson(part, whole, 0.05);
                (whole > 0).then(|| [part as f64 / whole as f64, low, high])
            };
            derive(&mut table, columns.each_ref(), [part, whole], share)?;
        }
        in_order(table, &rechecked_reference())
    };
    let made: PolarsResult<DataFrame> = made();
    made.expect(HAS_COLUMNS)
}

/// The fixed list as a table, one row for each driver, town and setup.
pub fn crossed_table(rows: &[CrossedStarts]) -> DataFrame {
    let ([faults, injuries], [fault_starts, weights]) = (of_episodes(), of_starts());
    let of_pairs: Vec<Counted> = faults.into_iter().chain(injuries).collect();
    let mut of_starts: Vec<Counted> = fault_starts.into_iter().chain(weights).collect();
    of_starts.push(count_new(STARTS.name, STARTS.doc, col(PAIRS).gt(lit(0))));
    let made = || {
        let all = pairs(rows.iter().map(|row| &row.encounters));
        let valid = all.clone().filter(is_valid());
        let [weight_before, weight_after] = sides(AVOIDABLE).map(|side| col(&side).sum().alias(side));
        let more = [weight_before, weight_after, col(KNOWN).all(true)];
        let starts = starts(valid.clone(), sums(FAULT).into_iter().chain(more));
        let table = aggregated(crossings_key().frame(rows), valid, &of_pairs)?;
        let mut table = with_failed(aggregated(table, starts, &of_starts)?, all)?;
        for (share, part) in SHARES.iter().zip(["fault_starts_before", "fault_starts_after"]) {
            let ratio = |[part, whole]: [u64; 2]| (whole > 0).then(|| [part as f64 / whole as f64]);
            derive(&mut table, [share], [part, STARTS.name], ratio)?;
        }
        let exact = |[fixed, new]: [u64; 2]| Some([mcnemar(fixed, new)]);
        derive(&mut table, [&P], ["fault_starts_fixed", "fault_starts_new"], exact)?;
        derive(&mut table, [&P_STARTS], ["starts_better", "starts_worse"], exact)?;
        adjust(&mut table)?;
        in_order(table, &crossed_reference())
    };
    let made: PolarsResult<DataFrame> = made();
    made.expect(HAS_COLUMNS)
}

const HAS_COLUMNS: &str = "a table of pairs has a column for each event";

/// The pairs of several rows.
fn pairs<'a>(rows: impl Iterator<Item = &'a Encounters>) -> LazyFrame {
    type Row<'a> = (u32, &'a Encounter);
    let of_row =
        |(row, encounters): (usize, &'a Encounters)| encounters.0.iter().map(move |encounter| (row as u32, encounter));
    let all: Vec<Row<'a>> = rows.enumerate().flat_map(of_row).collect();
    let is_worse = |own: Option<RerunOutcome>, other: Option<RerunOutcome>| {
        let (own, other) = (own?.collision(), other?.collision());
        Some(own.zip(other).is_some_and(|(own, other)| own.is_worse_than(&other)))
    };
    let mut table = Table::<Row<'a>>::new("pairs", "")
        .column(Entry::new::<u32, _>(ROW.into(), "".into(), "".into(), |row: &Row<'a>| row.0))
        .count(START, "", |row| row.1.start)
        .column(Entry::new::<bool, _>(KNOWN.into(), "".into(), "".into(), |row: &Row<'a>| row.1.before.is_some()))
        .column(Entry::new::<bool, _>(ERROR.into(), "".into(), "".into(), |row: &Row<'a>| row.1.is_error()));
    for side in 0..2 {
        let end = move |row: &Row<'a>| if side == 0 { row.1.before } else { Some(row.1.after) };
        let other = move |row: &Row<'a>| if side == 0 { Some(row.1.after) } else { row.1.before };
        let name = |event: &str| sides(event)[side].clone().into();
        let flag = |event: &str, is: fn(&RerunOutcome) -> bool| {
            Entry::new::<bool, _>(name(event), "".into(), "".into(), move |row: &Row<'a>| Some(is(&end(row)?)))
        };
        let quantity = |event: &str, of: fn(&RerunOutcome) -> f64| {
            Entry::new::<f64, _>(name(event), "".into(), "".into(), move |row: &Row<'a>| Some(of(&end(row)?)))
        };
        table = table
            .column(flag(COLLISION, RerunOutcome::is_collision))
            .column(flag(FAULT, |end| end.fault))
            .column(flag(MISSED, |end| end.is_missed))
            .column(Entry::new::<bool, _>(name(WORSE), "".into(), "".into(), move |row| is_worse(end(row), other(row))))
            .column(quantity(INJURY, RerunOutcome::injury))
            .column(quantity(AVOIDABLE, RerunOutcome::avoidable_injury));
    }
    table.frame(&all).lazy()
}

fn is_valid() -> Expr {
    col(ERROR).not()
}

/// Rows with what becomes of their pairs.
fn aggregated(rows: DataFrame, pairs: LazyFrame, counted: &[Counted]) -> PolarsResult<DataFrame> {
    let sums: Vec<Expr> = counted.iter().map(|counted| counted.value.clone().alias(&*counted.column.name)).collect();
    beside(rows, pairs.group_by_stable([col(ROW)]).agg(sums))
}

/// Rows with the number of their pairs in error. Where all are, the counts are 0, and so is the number of starts without any pair.
fn with_failed(rows: DataFrame, pairs: LazyFrame) -> PolarsResult<DataFrame> {
    let failed = col(ERROR).cast(DataType::UInt64).sum().alias(FAILED.name);
    let rows = beside(rows, pairs.group_by_stable([col(ROW)]).agg([failed, col(KNOWN).all(true)]))?;
    let is_count = |column: &&Values| *column.dtype() == DataType::UInt64;
    let zero = |column: &Values| {
        let name = column.name().as_str();
        let is_none = col(name).is_null().and(col(KNOWN).or(lit([STARTS.name, FAILED.name].contains(&name))));
        when(is_none).then(lit(0_u64)).otherwise(col(name)).alias(name)
    };
    let counts: Vec<Expr> = rows.columns().iter().filter(is_count).map(zero).collect();
    rows.lazy().with_columns(counts).collect()
}

/// Rows beside what another table has of each.
fn beside(rows: DataFrame, other: LazyFrame) -> PolarsResult<DataFrame> {
    let order = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Left) };
    let numbers: Vec<u32> = (0..rows.height() as u32).collect();
    let mut rows = rows;
    rows.with_column(Values::from(Series::new(ROW.into(), numbers)))?;
    rows.lazy().join(other, [col(ROW)], [col(ROW)], order).collect()?.drop(ROW)
}

/// Adds columns that follow from two counts.
fn derive<const N: usize>(
    table: &mut DataFrame,
    columns: [&Column<f64>; N],
    counts: [&str; 2],
    of: impl Fn([u64; 2]) -> Option<[f64; N]>,
) -> PolarsResult<()> {
    let [first, second] = [table.column(counts[0])?.u64()?, table.column(counts[1])?.u64()?];
    let row = |(first, second): (Option<u64>, Option<u64>)| of([first?, second?]);
    let found: Vec<Option<[f64; N]>> = first.iter().zip(second.iter()).map(row).collect();
    for (place, column) in columns.into_iter().enumerate() {
        let values: Vec<Option<f64>> = found.iter().map(|row| row.map(|row| row[place])).collect();
        table.with_column(Values::from(Series::new(column.name.into(), values)))?;
    }
    Ok(())
}

/// Adds the probabilities of the fixed list, adjusted for all rows in which a start differs.
fn adjust(table: &mut DataFrame) -> PolarsResult<()> {
    let count = |name: &str| Ok::<_, polars::error::PolarsError>(table.column(name)?.u64()?.clone());
    let (new, fixed) = (count("fault_starts_new")?, count("fault_starts_fixed")?);
    let p: Vec<Option<f64>> = P.read(table)?.iter().collect();
    let differs = |row: usize| new.get(row).unwrap_or_default() + fixed.get(row).unwrap_or_default() > 0;
    let tested: Vec<f64> = (0..p.len()).filter(|row| differs(*row)).filter_map(|row| p[row]).collect();
    let mut adjusted = holm(&tested).into_iter();
    let all: Vec<Option<f64>> =
        (0..p.len()).map(|row| if differs(row) && p[row].is_some() { adjusted.next() } else { p[row] }).collect();
    table.with_column(Values::from(Series::new(P_HOLM.name.into(), all)))?;
    Ok(())
}

/// The columns of a table in their order.
fn in_order(table: DataFrame, reference: &TableReference) -> PolarsResult<DataFrame> {
    table.select(reference.columns.iter().map(|column| column.name.as_ref()))
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
