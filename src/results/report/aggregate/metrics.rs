use polars::prelude::{Column, DataFrame, PolarsResult};

use super::groups::Groups;
use super::run_totals::to_runs;
use super::{Method, Rate};
use crate::record::metric;
use crate::record::{self, CellKey, ColumnReference, Metric, TableReference};
use base::statistics::{ClusteredCount, wilson};
use world::judge::Label;

/// The tables of metrics.
#[derive(Debug, Clone)]
pub struct Metrics {
    /// One row for each run: a pedestrian of one training in one town against one policy.
    pub runs: DataFrame,
    /// One row for each cell: all runs of the same reward, towns and policies.
    pub cells: DataFrame,
}

/// A cell, for people.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    pub key: CellKey,
    pub runs: u32,
    /// The number of episodes in all runs that count: without those in which the driver failed as a program, and those that are left out.
    pub episodes: u32,
    /// The number of episodes in which the driver failed; no other figure counts them.
    pub errors: u32,
    /// Collisions of all episodes. This and the other rates have Wilson's interval over the starts, which the runs share.
    pub collision: Rate,
    /// Collisions and bumps of all episodes.
    pub touch: Rate,
    /// The share of these in the front sector.
    pub front: Rate,
    /// Reward of an episode.
    pub reward_sum: Rate,
    /// Length of an episode (s).
    pub length: Rate,
    /// Speed of the ego at a collision (m/s).
    pub impact_speed: Rate,
    /// Collisions in all runs.
    pub collisions: u32,
    /// Preventable collisions of all episodes.
    pub preventable: Rate,
    /// Preventable collisions of all collisions.
    pub preventable_share: Rate,
    /// Avoidable injury of an episode: the severe-injury risk that a careful human would have spared.
    pub injury: Rate,
    /// The number of faults.
    pub faults: u32,
    /// Faults of all episodes.
    pub fault: Rate,
    /// The number of touches with each label, in the order of [`Label::ALL`].
    pub labels: [u32; Label::COUNT],
    /// The number of collisions with a foreseeable pedestrian.
    pub foreseeable: u32,
    /// The number of collisions in which the pedestrian walked into the side or the rear.
    pub walked_into: u32,
    /// The number of episodes without error: those that count, and those that are left out.
    pub all: u32,
    /// The number of these that are left out.
    pub left_out: u32,
    /// The number of these in which the car drove past the end of the road.
    pub road_end: u32,
    /// The number of these whose start the driver did not reach.
    pub placed: u32,
    /// The number of these in which the car left the road.
    pub left_road: u32,
    /// The expected rate of collisions that a driver drawn at random would have avoided, of all episodes.
    pub expected_preventable: Rate,
}

/// The stem of the files of the table of runs.
pub const RUNS: &str = "runs";
/// The name of the table of cells, which gates read.
pub const CELLS: &str = "cells";

/// Aggregates episodes to runs and runs to cells, each in the order of first appearance. Episodes in which the driver failed are counted
/// as `errors` and have no influence on other figures.
///
/// # Errors
/// Those of polars; none for a table made by [`episodes`](crate::record::episodes).
pub fn metrics(episodes: &DataFrame) -> PolarsResult<Metrics> {
    Metrics::of_runs(to_runs(episodes, &record::metrics())?)
}

fn to_cells(runs: &DataFrame, metrics: &[Metric]) -> PolarsResult<DataFrame> {
    let groups = Groups::new(runs, record::cell_key_names())?;
    let mut cells = groups.table()?;
    cells.with_column(groups.sizes(metric::RUNS.name))?;
    for metric in metrics {
        if let Metric::Count(count) = *metric {
            let counts = count.read(runs)?;
            cells.with_column(groups.sum(count.name, |row| counts.get(row).unwrap_or_default()))?;
        }
    }
    for name in metrics.iter().filter(|metric| metric.is_averaged()).map(Metric::name) {
        let values = runs.column(name)?.f64()?;
        cells.with_column(groups.mean(&metric::MEAN.name(name), |row| values.get(row)))?;
        cells.with_column(groups.deviation(&metric::SD.name(name), values))?;
    }
    add_intervals(&mut cells, metrics)?;
    Ok(cells)
}

/// Adds Wilson's intervals to cells. The runs of a cell share their starts, so a start counts once.
fn add_intervals(table: &mut DataFrame, metrics: &[Metric]) -> PolarsResult<()> {
    for metric in metrics {
        let Metric::Rate(rate) = *metric else { continue };
        let pairs = clustered(rate.part, table)?.into_iter().zip(clustered(rate.whole, table)?);
        let (low, high): (Vec<f64>, Vec<f64>) = pairs.map(|(hits, trials)| wilson(hits, trials)).unzip();
        table.with_column(Column::new(metric::WILSON_LOW.name(rate.name).into(), low))?;
        table.with_column(Column::new(metric::WILSON_HIGH.name(rate.name).into(), high))?;
    }
    Ok(())
}

/// A count of cells, in clusters of the episodes from one start.
fn clustered(count: metric::Count, cells: &DataFrame) -> PolarsResult<Vec<ClusteredCount>> {
    let counts = count.read(cells)?.into_no_null_iter().zip(metric::RUNS.read(cells)?.into_no_null_iter());
    Ok(counts.map(|(count, runs)| ClusteredCount::from(u64::from(count)).of_clusters(f64::from(runs))).collect())
}

/// The reference of the tables of runs and of cells, without the columns that [`infer`](crate::report::infer) adds to the latter.
pub fn references(metrics: &[Metric]) -> [TableReference; 2] {
    let interval = |metric: &Metric| match *metric {
        Metric::Rate(rate) => vec![metric::WILSON_LOW.reference(rate.name), metric::WILSON_HIGH.reference(rate.name)],
        _ => Vec::new(),
    };
    let is_rate = |metric: &&Metric| matches!(*metric, Metric::Rate(_));
    let is_count = |metric: &&Metric| matches!(*metric, Metric::Count(_));
    let mut runs = record::run_key_references();
    runs.extend(metrics.iter().filter(|metric| !is_rate(metric)).map(Metric::reference));
    runs.extend(metrics.iter().filter(is_rate).map(Metric::reference));
    let mut cells = record::cell_key_references();
    cells.push(Metric::Count(metric::RUNS).reference());
    cells.extend(metrics.iter().filter(is_count).map(Metric::reference));
    for averaged in metrics.iter().filter(|metric| metric.is_averaged()).map(Metric::reference) {
        let over = |family: &record::Family<f64>| {
            let doc = format!("{}: {}", averaged.doc, "mean and sample standard deviation over the runs of the cell");
            ColumnReference { unit: averaged.unit.clone(), doc: doc.into(), ..family.reference(&averaged.name) }
        };
        cells.extend([over(&metric::MEAN), over(&metric::SD)]);
    }
    cells.extend(metrics.iter().flat_map(interval));
    [
        TableReference {
            name: RUNS,
            doc: "One row for each run: a controller of one training in one town against one policy.",
            columns: runs,
        },
        TableReference {
            name: CELLS,
            doc: "One row for each cell: all runs that differ in their number alone.",
            columns: cells,
        },
    ]
}

impl Cell {
    /// The number of preventable collisions in all runs.
    pub fn preventable_collisions(&self) -> u32 {
        self.labels[Label::Preventable as usize]
    }
}

impl Metrics {
    /// Aggregates runs to cells.
    ///
    /// # Errors
    /// Those of polars; none for a table made by `runs`.
    pub fn of_runs(runs: DataFrame) -> PolarsResult<Self> {
        let cells = to_cells(&runs, &record::metrics())?;
        Ok(Self { runs, cells })
    }

    /// The cells, for people.
    ///
    /// # Errors
    /// Those of polars; none for tables made by [`metrics`].
    pub fn cells(&self) -> PolarsResult<Vec<Cell>> {
        let frame = &self.cells;
        let groups = Groups::new(&self.runs, record::cell_key_names())?;
        let count = |count: metric::Count, row: usize| -> PolarsResult<u32> {
            Ok(count.read(frame)?.get(row).unwrap_or_default())
        };
        let figure = |name: &str, row: usize| -> PolarsResult<Rate> {
            let values = self.runs.column(name)?.f64()?;
            let by_run = groups.rows()[row].iter().filter_map(|run| values.get(*run)).collect();
            let (value, sd) = (metric::MEAN.read(name, frame)?.get(row), metric::SD.read(name, frame)?.get(row));
            Ok(Rate { value, sd, by_run, ..Rate::default() })
        };
        let rate = |rate: metric::Rate, row: usize| -> PolarsResult<Rate> {
            let (low, high) = rate.interval(frame)?;
            let interval = (low.get(row).unwrap_or(0.0), high.get(row).unwrap_or(1.0));
            Ok(figure(rate.name, row)?.within(Some(interval), Method::Wilson))
        };
        let cell = |row: usize| {
            let mut labels = [0; Label::COUNT];
            for (found, label) in labels.iter_mut().zip(Label::ALL) {
                *found = count(metric::labelled(label), row)?;
            }
            Ok(Cell {
                injury: figure(metric::AVOIDABLE_INJURY.name, row)?,
                faults: count(metric::FAULT_COLLISIONS, row)?,
                all: count(metric::ALL_EPISODES, row)?,
                left_out: count(metric::LEFT_OUT_EPISODES, row)?,
                road_end: count(metric::ROAD_END_EPISODES, row)?,
                placed: count(metric::PLACED_STARTS, row)?,
                left_road: count(metric::LEFT_ROAD_EPISODES, row)?,
                key: CellKey::read(frame, row)?,
                runs: count(metric::RUNS, row)?,
                episodes: count(metric::EPISODES, row)?,
                errors: count(metric::ERRORS, row)?,
                collision: rate(metric::COLLISION_RATE, row)?,
                touch: rate(metric::TOUCH_RATE, row)?,
                front: rate(metric::FRONT_RATE, row)?,
                reward_sum: figure(metric::EPISODE_REWARD.name, row)?,
                length: figure(metric::EPISODE_LENGTH.name, row)?,
                impact_speed: figure(metric::IMPACT_SPEED.name, row)?,
                collisions: count(metric::COLLISIONS, row)?,
                preventable: rate(metric::PREVENTABLE_RATE, row)?,
                preventable_share: rate(metric::PREVENTABLE_SHARE, row)?,
                fault: rate(metric::FAULT_RATE, row)?,
                labels,
                foreseeable: count(metric::FORESEEABLE_COLLISIONS, row)?,
                walked_into: count(metric::WALKED_INTO_COLLISIONS, row)?,
                expected_preventable: figure(metric::EXPECTED_PREVENTABLE.name, row)?,
            })
        };
        (0..frame.height()).map(cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{EpisodeRow, RunKey, episodes};
    use crate::report::aggregate::run_totals::RunTotals;
    use world::av::{DrivingMode, Fault};
    use world::env::{Ending, Outcome, Spawn};
    use world::geometry::Pose;
    use world::judge::{ContactSide, Judged, Reference, Sight, Trial, Verdict};

    fn row(run: u32, episode: u32, hit: Option<(bool, f64)>) -> EpisodeRow {
        let ending = hit.map_or(Ending::Timeout, |(front, impact_speed)| Ending::Touch {
            front,
            moving: impact_speed > 0.1,
            impact_speed,
            bearing: 0.5,
        });
        let spawn = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let reward = hit.map_or(0.0, |(_, speed)| 1.0 + speed);
        let (least_gap, last_mode) = (1.0, DrivingMode::Cruise);
        // Frontal collisions are preventable; the others are bumps.
        let verdict = hit.map(|(front, impact_speed)| Verdict {
            label: if front { Label::Preventable } else { Label::Bump },
            side: ContactSide::Front,
            walked_into: false,
            latest_reaction: front.then_some(1.0),
            danger_speed: 2.0,
            warning: 2.0,
            foreseeable: front,
            fast: false,
            sight: Sight { hidden: 0.0, seen: 3.0 },
            impact_speed,
            trials: [Trial { impact_speed: None, time: 1.0, least_gap: 0.5, moved: true, braked: true, stopped: true };
                Reference::COUNT],
        });
        let cell = CellKey {
            controller: "trained".into(),
            reward: "r1".into(),
            train_town: "a".into(),
            train_policy: "p".into(),
            town: "b".into(),
            policy: "p".into(),
            vehicle: "v".into(),
            adversary: "w".into(),
            block: 0,
        };
        EpisodeRow {
            key: RunKey { id: format!("{run:08x}").parse().unwrap(), cell, run }.into(),
            episode,
            judged: Judged {
                outcome: Outcome {
                    spawn,
                    start: 0,
                    run_up: 0,
                    left_out: None,
                    ending,
                    reward,
                    ticks: 10,
                    duration: 0.5,
                    least_gap,
                    on_crosswalk: false,
                    last_mode,
                    digest: 7,
                    state_hashes: Default::default(),
                },
                verdict,
                degrees: Vec::new(),
            },
            false_alarms: None,
            near_miss: world::judge::NearMiss::default(),
            lane: None,
            motion: Default::default(),
        }
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
        let metrics = metrics(&episodes(&rows)).unwrap();
        assert_eq!((metrics.runs.height(), metrics.cells.height()), (2, 1));
        let cell = &metrics.cells().unwrap()[0];
        assert_eq!((cell.runs, cell.episodes), (2, 8));
        let near = |rate: &Rate, mean: f64, sd: f64| {
            assert!((rate.value.unwrap() - mean).abs() < 1e-12, "{rate:?}");
            assert!((rate.sd.unwrap() - sd).abs() < 1e-12, "{rate:?}");
        };
        near(&cell.touch, 0.375, 0.125 * 2.0_f64.sqrt());
        near(&cell.front, 0.75, 0.25 * 2.0_f64.sqrt());
        near(&cell.collision, 0.25, 0.0);
        near(&cell.impact_speed, 5.0, 2.0_f64.sqrt());
        assert_eq!(cell.collision.interval, Some(wilson(1, 4)), "its two runs share four starts");
        near(&cell.preventable, 0.25, 0.0);
        near(&cell.preventable_share, 1.0, 0.0);
        let intervals = [&cell.preventable, &cell.preventable_share].map(|rate| rate.interval.unwrap());
        assert_eq!(intervals, [wilson(1, 4), wilson(1, 1)]);
        assert_eq!((cell.collisions, cell.labels, cell.foreseeable), (2, [2, 0, 0, 0, 1], 2));
        // Every preventable collision of these is foreseeable.
        assert_eq!(cell.fault, cell.preventable);
    }

    #[test]
    fn episodes_in_error_count_as_errors_and_nowhere_else() {
        let failed = |run, episode| {
            let mut row = row(run, episode, None);
            row.judged.outcome.ending = Ending::Error(Fault::Ended);
            row.judged.outcome.reward = 100.0;
            row
        };
        let rows = [row(0, 0, Some((true, 4.0))), failed(0, 1), row(0, 2, None), failed(1, 0)];
        let metrics = metrics(&episodes(&rows)).unwrap();
        let cell = &metrics.cells().unwrap()[0];
        assert_eq!((cell.runs, cell.episodes, cell.errors), (2, 2, 2));
        assert_eq!((cell.collision.value, cell.collision.sd), (Some(0.5), None), "a run of errors alone has no rate");
        assert_eq!(cell.reward_sum.value, Some(2.5));
        let runs = 2.0;
        assert_eq!(
            cell.collision.interval.unwrap(),
            wilson(ClusteredCount::from(1).of_clusters(runs), ClusteredCount::from(2).of_clusters(runs))
        );
    }

    #[test]
    fn a_new_quantity_of_an_episode_is_a_column_and_a_metric() {
        const HURRY: record::Column<f64> = record::Column::new("hurry", "1/s", "how soon it was over");
        let entry = HURRY.of(|row: &EpisodeRow| 1.0 / f64::from(row.judged.outcome.ticks));
        let table = record::episode_table().column(entry);
        let mut all = record::metrics();
        all.push(Metric::Mean(metric::Mean::new(&HURRY, "mean hurry")));
        let episodes = table.frame(&[row(0, 0, None), row(1, 0, Some((true, 4.0)))]);
        let runs = to_runs(&episodes, &all).unwrap();
        let cells = to_cells(&runs, &all).unwrap();
        for (table, name) in [(&episodes, "hurry"), (&runs, "hurry"), (&cells, "hurry_mean"), (&cells, "hurry_sd")] {
            assert!(table.column(name).is_ok(), "{name}");
        }
        assert_eq!(cells.column("hurry_mean").unwrap().f64().unwrap().get(0), Some(0.1));
        let [said_of_runs, said_of_cells] = references(&all);
        assert!(said_of_runs.columns.iter().any(|column| column.name == "hurry" && column.doc == "mean hurry"));
        assert!(said_of_cells.columns.iter().any(|column| column.name == "hurry_mean" && column.unit == "1/s"));
        // All other columns stay the same.
        let before = metrics(&record::episodes(&[])).unwrap();
        assert_eq!((cells.width(), runs.width()), (before.cells.width() + 2, before.runs.width() + 1));
    }

    #[test]
    fn parts_of_a_run_give_the_bits_of_the_whole_run() {
        let rows: Vec<_> = (0..40).map(|n| row(0, n, (n % 3 == 0).then(|| (n % 2 == 0, 0.1 * f64::from(n))))).collect();
        let wanted = to_runs(&episodes(&rows), &record::metrics()).unwrap();
        for size in [1, 7, 40] {
            let mut totals = RunTotals::new();
            rows.chunks(size).for_each(|part| totals.add(&episodes(part)).unwrap());
            assert!(totals.table().unwrap().equals_missing(&wanted), "{size}");
        }
        assert_eq!(RunTotals::new().table().unwrap().shape(), (0, wanted.width()));
    }

    #[test]
    fn a_run_without_collisions_has_no_front_rate() {
        let metrics = metrics(&episodes(&[row(0, 0, None)])).unwrap();
        let cell = &metrics.cells().unwrap()[0];
        assert_eq!((cell.front.value, cell.collision.value), (None, Some(0.0)));
    }
}
