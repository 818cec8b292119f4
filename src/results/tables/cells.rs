use std::ops::Deref;

use polars::prelude::{DataFrame, DataType, Expr, IntoLazy, PolarsResult, SortMultipleOptions, col, len, lit};

use super::metrics::{MEAN, METRICS, RUNS};
use super::requirements::APPLIED;
use super::statistics::{interval, over_runs};
use super::{Metric, Rate, Row, Rows};
use crate::record::{CellKey, Column, ColumnReference, Role, Table, cell_key};
use base::statistics::{ClusteredCount, wilson};

/// Whether the episodes of a run are the cases of a test, each once. They are no sample, and nothing has an interval.
pub const IS_FIXED_CASES: Column<bool> =
    Column::new("is_fixed_cases", "", "whether the episodes are the cases of a test");
/// Whether an untrained pedestrian walked the same for an earlier reward of the campaign.
pub(super) const IS_COPY: Column<bool> =
    Column::new("is_copy", "", "whether only the reward differs from an earlier row");

/// The cells of a campaign, in the order of first appearance: all runs that differ in their number alone.
#[derive(Debug, Clone, Default)]
pub struct Cells {
    rows: Rows<CellKey>,
    varied: Varied,
}

/// A row of the table of cells.
pub type Cell = Row<CellKey>;

/// Which parts of the key differ between cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct Varied {
    pub vehicle: bool,
    pub adversary: bool,
    pub world: bool,
    /// Town or driver of trainings.
    pub training: bool,
}

impl Cells {
    /// The cells of a table of runs, or one for each value of further columns of them. Of each metric they have the sum over the runs, or mean, deviation and the
    /// values of the runs; of a share, the interval over the starts, which the runs share.
    ///
    /// # Errors
    /// Those of polars; none for a table of runs.
    pub(super) fn new(runs: &DataFrame, metrics: &[&Metric], by: &[&str]) -> PolarsResult<Self> {
        if runs.height() == 0 {
            return Ok(Self::default());
        }
        let keys = key_columns();
        let groups =
            keys.iter().map(String::as_str).chain([IS_FIXED_CASES.name, IS_COPY.name]).chain(by.iter().copied());
        let groups: Vec<Expr> = groups.map(col).collect();
        Self::of(runs.clone().lazy().group_by_stable(groups).agg(aggregates(metrics)).collect()?)
    }

    /// The rows of a table.
    fn of(table: DataFrame) -> PolarsResult<Self> {
        let rows = Rows::new(table, CellKey::read)?;
        let varied = Varied::of(&rows);
        Ok(Self { rows, varied })
    }

    /// Those that count, and those of untrained pedestrians that walked the same for an earlier reward, which would count twice.
    ///
    /// # Errors
    /// Those of polars; none.
    pub(super) fn without_copies(&self) -> PolarsResult<[Self; 2]> {
        if self.is_empty() {
            return Ok([Self::default(), Self::default()]);
        }
        let of = |rows: Expr| Self::of(self.table().clone().lazy().filter(rows).collect()?);
        Ok([of(col(IS_COPY.name).not())?, of(col(IS_COPY.name))?])
    }

    /// Sums of counts over all cells that agree in these parts of the key, in the order of the parts' values.
    ///
    /// # Panics
    /// Never: the table has these columns.
    pub fn sums(&self, by: &[Column<String>], counts: &[&Metric]) -> Rows<()> {
        if self.is_empty() {
            return Rows::default();
        }
        let keys: Vec<Expr> = by.iter().map(|column| col(column.name)).collect();
        let sums: Vec<Expr> = counts.iter().map(|count| col(count.name).cast(DataType::UInt64).sum()).collect();
        let sums = self.table().clone().lazy().group_by_stable(keys.clone()).agg(sums);
        let sums = sums.sort_by_exprs(keys, SortMultipleOptions::default()).collect();
        sums.and_then(|sums| Rows::new(sums, |_, _| Ok(()))).expect("the table has these columns")
    }

    /// Which parts of the key differ.
    pub fn varied(&self) -> Varied {
        self.varied
    }
}

impl Varied {
    fn of(cells: &[Cell]) -> Self {
        let differs = |part: fn(&CellKey) -> (&str, &str), all: fn(&CellKey) -> bool| {
            let mut parts = cells.iter().map(|cell| &cell.key).filter(|key| all(key)).map(part);
            parts.next().is_some_and(|first| parts.any(|other| other != first))
        };
        Self {
            vehicle: differs(|key| (&key.vehicle, ""), |_| true),
            adversary: differs(|key| (&key.adversary, ""), |_| true),
            world: differs(|key| (&key.world, ""), |_| true),
            training: differs(|key| (&key.train_town, &key.train_policy), CellKey::is_trained),
        }
    }
}

impl Deref for Cells {
    type Target = Rows<CellKey>;

    fn deref(&self) -> &Rows<CellKey> {
        &self.rows
    }
}

fn key() -> Vec<ColumnReference> {
    Table::<CellKey>::new("", "").columns(cell_key(|key: &CellKey| key)).reference().columns
}

/// The names of the columns of a cell's key.
pub fn key_columns() -> Vec<String> {
    key().into_iter().map(|column| column.name.into_owned()).collect()
}

/// The columns of the table of cells: the key, the number of runs, sums, means, deviations, and intervals of shares.
pub fn cell_columns() -> Vec<ColumnReference> {
    let mut all = key();
    all.push(RUNS.reference());
    all.extend(METRICS.into_iter().filter(|metric| metric.is_count()).map(Metric::reference));
    for metric in METRICS.into_iter().filter(|metric| !metric.is_count()) {
        let own = metric.reference();
        let of = |name: String, role| ColumnReference {
            name: name.into(),
            unit: "".into(),
            doc: "".into(),
            role,
            ..own.clone()
        };
        all.push(ColumnReference { doc: MEAN.doc().into(), ..of(MEAN.name(metric.name), own.role) });
        all.push(of(format!("{}_sd", metric.name), Role::Deviation));
        if metric.is_share() {
            all.push(of(format!("{}_wilson_low", metric.name), Role::LowerBound));
            all.push(of(format!("{}_wilson_high", metric.name), Role::UpperBound));
        }
    }
    all
}

/// What becomes of the runs of a cell.
fn aggregates(metrics: &[&Metric]) -> Vec<Expr> {
    let of = |metric: &&Metric| {
        let part = || col(metric.part_column());
        let Some(whole) = metric.whole else { return vec![part().sum()] };
        let mut all = vec![part().sum()];
        all.extend(over_runs(metric.name, col(metric.name)));
        if metric.is_share() {
            let counts = [part(), col(whole.name), col(IS_FIXED_CASES.name)];
            // A run in which a requirement never applied says nothing about it.
            let counts = match *whole == APPLIED {
                true => counts.map(|count| count.filter(col(whole.name).gt(lit(0)))),
                false => counts,
            };
            all.extend(interval(&format!("{}_wilson", metric.name), counts, wilson_of_runs));
        }
        all
    };
    std::iter::once(len().alias(RUNS.name)).chain(metrics.iter().flat_map(of)).collect()
}

/// Wilson's interval of a share in the runs of a cell; none of the cases of a test. The runs share their starts, so a start counts once.
fn wilson_of_runs([parts, wholes, is_fixed_cases]: [&[f64]; 3]) -> Option<(f64, f64)> {
    let sum = |counts: &[f64]| ClusteredCount::from(counts.iter().sum::<f64>() as u64).of_clusters(counts.len() as f64);
    (is_fixed_cases.first() == Some(&0.0)).then(|| wilson(sum(parts), sum(wholes)))
}

impl Row<CellKey> {
    /// Whether its episodes are the cases of a test: its rates have no interval.
    pub fn is_fixed_cases(&self) -> bool {
        self.holds(&IS_FIXED_CASES)
    }

    pub fn runs(&self) -> u32 {
        self.whole_number(RUNS.name) as u32
    }

    /// A count over all runs.
    pub fn count(&self, metric: &Metric) -> u32 {
        self.whole_number(metric.name) as u32
    }

    /// The sum of which a share is the ratio.
    pub fn part(&self, metric: &Metric) -> u32 {
        self.whole_number(&metric.part_column()) as u32
    }

    /// The sum to which a metric is a ratio.
    pub fn whole(&self, metric: &Metric) -> u32 {
        metric.whole.map_or(0, |whole| self.count(whole))
    }

    /// A mean or a share over the runs, with its interval over the starts.
    pub fn rate(&self, metric: &Metric) -> Rate {
        self.figure(metric.name, "_wilson")
    }

    /// The mean of a metric over the runs.
    pub fn value(&self, metric: &Metric) -> Option<f64> {
        self.number(&MEAN.name(metric.name))
    }
}

#[cfg(test)]
impl Row<CellKey> {
    /// A cell with these counts and these means, which is neither a test nor a copy.
    pub fn example(key: CellKey, counts: &[(&Metric, u32)], rates: &[(&Metric, Rate)]) -> Self {
        use polars::prelude::{Column as Values, NamedFrom, Series};
        let mut table =
            Table::<CellKey>::new("", "").columns(cell_key(|key: &CellKey| key)).frame(std::slice::from_ref(&key));
        let mut add = |column: Series| table.with_column(Values::from(column)).map(|_| ()).unwrap();
        for flag in [IS_FIXED_CASES.name, IS_COPY.name] {
            add(Series::new(flag.into(), [false]));
        }
        add(Series::new(RUNS.name.into(), [1_u32]));
        for metric in METRICS {
            if metric.is_count() {
                let count = counts.iter().find(|(known, _)| known.name == metric.name).map_or(0, |(_, count)| *count);
                add(Series::new(metric.name.into(), [count]));
                continue;
            }
            let rate = rates.iter().find(|(known, _)| known.name == metric.name);
            let rate = rate.map(|(_, rate)| rate.clone()).unwrap_or_default();
            add(Series::new(MEAN.name(metric.name).into(), [rate.value]));
            add(Series::new(format!("{}_sd", metric.name).into(), [rate.sd]));
            add(Series::new(format!("{}_wilson_low", metric.name).into(), [rate.interval.map(|ends| ends.0)]));
            add(Series::new(format!("{}_wilson_high", metric.name).into(), [rate.interval.map(|ends| ends.1)]));
        }
        Cells::of(table).unwrap()[0].clone()
    }
}

#[cfg(test)]
impl Cells {
    /// A table of these cells.
    pub fn example(cells: &[Cell]) -> Self {
        let mut table = cells[0].table().clone();
        cells[1..].iter().for_each(|cell| table.vstack_mut(cell.table()).map(|_| ()).unwrap());
        table.rechunk_mut();
        Self::of(table).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{EpisodeRow, RunKey, episodes};
    use crate::tables::Runs;
    use crate::tables::metrics::{
        COLLISION_RATE, COLLISIONS, EPISODE_REWARD, EPISODES, ERRORS, FAULT_RATE, FORESEEABLE_COLLISIONS, FRONT_RATE,
        IMPACT_SPEED, LABELLED, PREVENTABLE_RATE, PREVENTABLE_SHARE, TOUCH_RATE,
    };
    use episode::Ending;
    use verdict::{ContactSide, Label, Verdict};
    use world::av::Fault;

    fn row(run: u32, episode: u32, hit: Option<(bool, f64)>) -> EpisodeRow {
        let ending = hit.map_or(Ending::Timeout, |(front, impact_speed)| Ending::Touch {
            pedestrian: 0,
            front,
            moving: impact_speed > 0.1,
            impact_speed,
            bearing: 0.5,
        });
        let mut row = crate::record::tests::row(episode, ending);
        row.key = RunKey { id: format!("{run:08x}").parse().unwrap(), run, ..RunKey::clone(&row.key) }.into();
        (row.judged.outcome.reward, row.judged.outcome.ticks) = (hit.map_or(0.0, |(_, speed)| 1.0 + speed), 10);
        // Frontal collisions are preventable; the others are bumps.
        row.judged.verdict = row.judged.verdict.zip(hit).map(|(verdict, (front, impact_speed))| Verdict {
            label: if front { Label::Preventable } else { Label::Bump },
            side: ContactSide::Front,
            walked_into: false,
            foreseeable: front,
            impact_speed,
            ..verdict
        });
        row
    }

    /// The table of runs of parts of episodes.
    fn runs(parts: &[&[EpisodeRow]]) -> DataFrame {
        let mut runs = Runs::default();
        let mut last = None;
        for part in parts {
            if last.replace(part[0].key.clone()).as_ref() != Some(&part[0].key) {
                runs.begin(&part[0].key, false, false);
            }
            runs.add(&episodes(part)).unwrap();
        }
        runs.table().unwrap()
    }

    /// The cells of the runs of these episodes.
    fn cells_of(rows: &[EpisodeRow]) -> Cells {
        let parts: Vec<&[EpisodeRow]> = rows.chunk_by(|one, next| one.key == next.key).collect();
        Cells::new(&runs(&parts), &METRICS, &[]).unwrap()
    }

    #[test]
    fn episodes_become_runs_and_runs_become_cells() {
        let rows = [
            row(0, 0, Some((true, 4.0))),
            row(0, 1, Some((false, 0.0))),
            row(0, 2, None),
            row(0, 3, None),
            row(1, 0, Some((true, 6.0))),
            row(1, 1, None),
            row(1, 2, None),
            row(1, 3, None),
        ];
        let cells = cells_of(&rows);
        let [cell] = &**cells else { panic!("one cell") };
        assert_eq!((cell.runs(), cell.count(&EPISODES)), (2, 8));
        let near = |metric: &Metric, mean: f64, sd: f64| {
            let rate = cell.rate(metric);
            assert!((rate.value.unwrap() - mean).abs() < 1e-12, "{rate:?}");
            assert!((rate.sd.unwrap() - sd).abs() < 1e-12, "{rate:?}");
        };
        near(&TOUCH_RATE, 0.375, 0.125 * 2.0_f64.sqrt());
        near(&FRONT_RATE, 0.75, 0.25 * 2.0_f64.sqrt());
        near(&COLLISION_RATE, 0.25, 0.0);
        near(&IMPACT_SPEED, 5.0, 2.0_f64.sqrt());
        near(&PREVENTABLE_RATE, 0.25, 0.0);
        near(&PREVENTABLE_SHARE, 1.0, 0.0);
        assert_eq!(cell.rate(&COLLISION_RATE).by_run, [0.25, 0.25]);
        // Its two runs share four starts.
        for (metric, interval) in
            [(&COLLISION_RATE, wilson(1, 4)), (&PREVENTABLE_RATE, wilson(1, 4)), (&PREVENTABLE_SHARE, wilson(1, 1))]
        {
            assert_eq!(cell.rate(metric).interval, Some(interval), "{}", metric.name);
        }
        assert_eq!((cell.part(&COLLISION_RATE), cell.whole(&COLLISION_RATE)), (2, 8));
        assert_eq!(LABELLED.map(|metric| cell.count(metric)), [2, 0, 0, 0, 1]);
        assert_eq!((cell.count(&COLLISIONS), cell.count(&FORESEEABLE_COLLISIONS)), (2, 2));
        // Every preventable collision of these is foreseeable.
        assert_eq!(cell.rate(&FAULT_RATE), cell.rate(&PREVENTABLE_RATE));
    }

    #[test]
    fn episodes_in_error_count_as_errors_and_nowhere_else() {
        let failed = |run, episode| {
            let mut row = row(run, episode, None);
            row.judged.outcome.ending = Ending::Error(Fault::Ended(world::av::Exit::Unknown));
            row.judged.outcome.reward = 100.0;
            row
        };
        let cells = cells_of(&[row(0, 0, Some((true, 4.0))), failed(0, 1), row(0, 2, None), failed(1, 0)]);
        let cell = &cells[0];
        assert_eq!((cell.runs(), cell.count(&EPISODES), cell.count(&ERRORS)), (2, 2, 2));
        let collision = cell.rate(&COLLISION_RATE);
        assert_eq!((collision.value, collision.sd), (Some(0.5), None), "a run of errors alone has no rate");
        assert_eq!(cell.value(&EPISODE_REWARD), Some(2.5));
        let starts = |count: u64| ClusteredCount::from(count).of_clusters(2.0);
        assert_eq!(collision.interval.unwrap(), wilson(starts(1), starts(2)));
    }

    #[test]
    fn parts_of_a_run_and_any_number_of_threads_give_the_same_bits() {
        let rows: Vec<_> = (0..2_000)
            .map(|n| row(n / 1_000, n % 1_000, (n % 3 == 0).then(|| (n % 2 == 0, 0.1 * f64::from(n)))))
            .collect();
        let whole: Vec<&[EpisodeRow]> = rows.chunks(1_000).collect();
        let wanted = runs(&whole);
        assert_eq!(wanted.height(), 2);
        for size in [1, 8, 500] {
            assert!(runs(&rows.chunks(size).collect::<Vec<_>>()).equals_missing(&wanted), "{size}");
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| runs(&whole)).equals_missing(&wanted), "{threads}");
        }
        assert_eq!(Runs::default().table().unwrap().height(), 0);
    }

    #[test]
    fn a_run_without_collisions_has_no_front_rate() {
        let cells = cells_of(&[row(0, 0, None)]);
        assert_eq!((cells[0].value(&FRONT_RATE), cells[0].value(&COLLISION_RATE)), (None, Some(0.0)));
    }

    #[test]
    fn the_columns_of_the_table_are_those_that_are_documented() {
        let cells = cells_of(&[row(0, 0, None)]);
        let is_missing = |column: &ColumnReference| cells.table().get_column_index(&column.name).is_none();
        let missing: Vec<_> = cell_columns().into_iter().filter(is_missing).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}
