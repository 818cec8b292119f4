use polars::prelude::*;

use crate::judge::Label;
use crate::statistics::wilson;

/// What a run is told apart by, beside its number.
const CELL: [&str; 9] =
    ["reward", "train_town", "train_policy", "pedestrian", "town", "policy", "vehicle", "adversary", "block"];

/// The tables of metrics.
#[derive(Debug, Clone)]
pub struct Metrics {
    /// One row for each run: a pedestrian of one training in one town against one policy.
    pub runs: DataFrame,
    /// One row for each cell: all runs of the same reward, towns and policies.
    pub cells: DataFrame,
}

/// A mean over runs, and the standard deviation between them when there is more than one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The mean; none when no run has a value.
    pub mean: Option<f64>,
    /// The sample standard deviation.
    pub sd: Option<f64>,
}

/// A cell, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Name of the reward.
    pub reward: String,
    /// Town and policy it was trained in and against; empty for untrained pedestrians.
    pub trained: (String, String),
    /// Who it is.
    pub pedestrian: String,
    /// Town it was tried in.
    pub town: String,
    /// Policy it was tried against.
    pub policy: String,
    /// The model of car.
    pub vehicle: String,
    /// The adversary, for its body.
    pub adversary: String,
    /// Number of the `evaluate` block, from 0.
    pub block: u32,
    /// How many runs.
    pub runs: u32,
    /// How many episodes in all runs, without those in which the driver failed.
    pub episodes: u32,
    /// How many episodes in which the driver failed; they count nowhere else.
    pub errors: u32,
    /// Collisions of all episodes.
    pub collision: Spread,
    /// Wilson's interval of the collision rate over all episodes.
    pub interval: (f64, f64),
    /// Frontal collisions of all collisions.
    pub front: Spread,
    /// Collisions with a moving ego of all episodes.
    pub moving: Spread,
    /// Reward of an episode.
    pub reward_sum: Spread,
    /// Length of an episode (s).
    pub length: Spread,
    /// Speed of the ego at a collision (m/s).
    pub impact_speed: Spread,
    /// Collisions in all runs.
    pub collisions: u32,
    /// Preventable collisions of all episodes.
    pub preventable: Spread,
    /// Wilson's interval of that, over all episodes.
    pub preventable_interval: (f64, f64),
    /// Preventable collisions of all collisions.
    pub preventable_share: Spread,
    /// Wilson's interval of that, over all collisions.
    pub preventable_share_interval: (f64, f64),
    /// How many collisions got each label, in the order of [`Label::ALL`].
    pub labels: [u32; 6],
    /// How many collisions were with a foreseeable pedestrian.
    pub foreseeable: u32,
}

/// The metrics that get a mean and a spread in the table of cells.
const AVERAGED: [&str; 8] = [
    "collision_rate",
    "front_rate",
    "moving_rate",
    "episode_reward",
    "episode_length_s",
    "impact_speed_mps",
    "preventable_rate",
    "preventable_share",
];

/// The rates that get an interval: name, part, whole.
const RATES: [(&str, &str, &str); 5] = [
    ("collision_rate", "collisions", "episodes"),
    ("front_rate", "front_collisions", "collisions"),
    ("moving_rate", "moving_collisions", "episodes"),
    ("preventable_rate", "preventable_collisions", "episodes"),
    ("preventable_share", "preventable_collisions", "collisions"),
];

/// The name of the column that counts a label.
fn counted(label: Label) -> String {
    format!("{}_collisions", label.name())
}

/// Aggregates episodes to runs and runs to cells, each in the order of first appearance. Episodes in which the driver failed
/// are counted as `errors` and enter nothing else.
///
/// # Errors
/// Those of polars; none for a table made by [`episodes`](super::episodes).
pub fn metrics(episodes: &DataFrame) -> PolarsResult<Metrics> {
    Metrics::of_runs(runs(episodes)?)
}

/// Aggregates episodes to runs. Those of a run must be together; several tables of whole runs give the same as one of all.
///
/// # Errors
/// As [`metrics`].
pub fn runs(episodes: &DataFrame) -> PolarsResult<DataFrame> {
    let total = |name: &str| col(name).cast(DataType::UInt32).sum();
    let mut by_run: Vec<Expr> = CELL.iter().map(|name| col(*name)).collect();
    by_run.push(col("run"));
    by_run.insert(0, col("run_id"));
    let labels = Label::ALL.map(|label| {
        let one = col("verdict").eq(lit(label.name())).fill_null(lit(false));
        one.cast(DataType::UInt32).sum().alias(counted(label))
    });
    let mut aggregated = vec![
        valid().cast(DataType::UInt32).sum().alias("episodes"),
        valid().not().cast(DataType::UInt32).sum().alias("errors"),
        total("collision").alias("collisions"),
        total("front").alias("front_collisions"),
        total("moving").alias("moving_collisions"),
        col("episode_reward").filter(valid()).mean(),
        col("episode_length_s").filter(valid()).mean(),
        col("impact_speed_mps").mean(),
        col("least_gap_m").filter(valid()).mean(),
        col("foreseeable").fill_null(lit(false)).cast(DataType::UInt32).sum().alias("foreseeable_collisions"),
    ];
    aggregated.extend(labels);
    let mut runs = episodes
        .clone()
        .lazy()
        .group_by_stable(by_run)
        .agg(aggregated)
        .with_columns([
            ratio("collisions", "episodes").alias("collision_rate"),
            ratio("front_collisions", "collisions").alias("front_rate"),
            ratio("moving_collisions", "episodes").alias("moving_rate"),
            ratio("preventable_collisions", "episodes").alias("preventable_rate"),
            ratio("preventable_collisions", "collisions").alias("preventable_share"),
        ])
        .collect()?;
    add_intervals(&mut runs)?;
    Ok(runs)
}

fn of_runs(runs: DataFrame) -> PolarsResult<Metrics> {
    let total = |name: &str| col(name).cast(DataType::UInt32).sum();
    let by_cell: Vec<Expr> = CELL.iter().map(|name| col(*name)).collect();
    let mut sums =
        vec![len().cast(DataType::UInt32).alias("runs"), total("episodes"), total("errors"), total("collisions")];
    sums.extend(["front_collisions", "moving_collisions", "foreseeable_collisions"].map(total));
    sums.extend(Label::ALL.map(|label| total(&counted(label))));
    for name in AVERAGED {
        sums.push(col(name).mean().alias(format!("{name}_mean")));
        sums.push(col(name).std(1).alias(format!("{name}_sd")));
    }
    let mut cells = runs.clone().lazy().group_by_stable(by_cell).agg(sums).collect()?;
    add_intervals(&mut cells)?;
    Ok(Metrics { runs, cells })
}

/// Adds Wilson's intervals to runs or cells.
fn add_intervals(table: &mut DataFrame) -> PolarsResult<()> {
    for (name, part, whole) in RATES {
        let (low, high) = intervals(table, part, whole)?;
        table.with_column(Column::new(format!("{name}_wilson_low").into(), low))?;
        table.with_column(Column::new(format!("{name}_wilson_high").into(), high))?;
    }
    Ok(())
}

/// Whether the driver drove to the end of the episode.
fn valid() -> Expr {
    col("outcome").neq(lit("error"))
}

/// A share, missing when the whole is zero.
fn ratio(part: &str, whole: &str) -> Expr {
    let share = col(part).cast(DataType::Float64) / col(whole).cast(DataType::Float64);
    when(col(whole).gt(lit(0u32))).then(share).otherwise(lit(NULL).cast(DataType::Float64))
}

fn intervals(cells: &DataFrame, part: &str, whole: &str) -> PolarsResult<(Vec<f64>, Vec<f64>)> {
    let (hits, trials) = (cells.column(part)?.u32()?, cells.column(whole)?.u32()?);
    let pairs = hits.into_no_null_iter().zip(trials.into_no_null_iter());
    Ok(pairs.map(|(hits, trials)| wilson(hits.into(), trials.into())).unzip())
}

impl Metrics {
    /// Aggregates runs to cells.
    ///
    /// # Errors
    /// Those of polars; none for a table made by the table of runs.
    pub fn of_runs(runs: DataFrame) -> PolarsResult<Self> {
        of_runs(runs)
    }

    /// The cells, for people.
    ///
    /// # Errors
    /// Those of polars; none for tables made by [`metrics`].
    pub fn cells(&self) -> PolarsResult<Vec<Cell>> {
        let frame = &self.cells;
        let text = |name: &str, row: usize| -> PolarsResult<String> {
            Ok(frame.column(name)?.str()?.get(row).unwrap_or_default().to_string())
        };
        let count = |name: &str, row: usize| -> PolarsResult<u32> {
            Ok(frame.column(name)?.u32()?.get(row).unwrap_or_default())
        };
        let number = |name: &str, row: usize| -> PolarsResult<Option<f64>> { Ok(frame.column(name)?.f64()?.get(row)) };
        let spread = |name: &str, row: usize| -> PolarsResult<Spread> {
            Ok(Spread { mean: number(&format!("{name}_mean"), row)?, sd: number(&format!("{name}_sd"), row)? })
        };
        let interval = |name: &str, row: usize| -> PolarsResult<(f64, f64)> {
            let low = number(&format!("{name}_wilson_low"), row)?.unwrap_or(0.0);
            Ok((low, number(&format!("{name}_wilson_high"), row)?.unwrap_or(1.0)))
        };
        let cell = |row: usize| {
            let mut labels = [0; 6];
            for (found, label) in labels.iter_mut().zip(Label::ALL) {
                *found = count(&counted(label), row)?;
            }
            Ok(Cell {
                reward: text("reward", row)?,
                trained: (text("train_town", row)?, text("train_policy", row)?),
                pedestrian: text("pedestrian", row)?,
                town: text("town", row)?,
                policy: text("policy", row)?,
                vehicle: text("vehicle", row)?,
                adversary: text("adversary", row)?,
                block: count("block", row)?,
                runs: count("runs", row)?,
                episodes: count("episodes", row)?,
                errors: count("errors", row)?,
                collision: spread("collision_rate", row)?,
                interval: interval("collision_rate", row)?,
                front: spread("front_rate", row)?,
                moving: spread("moving_rate", row)?,
                reward_sum: spread("episode_reward", row)?,
                length: spread("episode_length_s", row)?,
                impact_speed: spread("impact_speed_mps", row)?,
                collisions: count("collisions", row)?,
                preventable: spread("preventable_rate", row)?,
                preventable_interval: interval("preventable_rate", row)?,
                preventable_share: spread("preventable_share", row)?,
                preventable_share_interval: interval("preventable_share", row)?,
                labels,
                foreseeable: count("foreseeable_collisions", row)?,
            })
        };
        (0..frame.height()).map(cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::episodes;
    use super::*;
    use crate::av::{DrivingMode, Fault};
    use crate::campaign::EpisodeRow;
    use crate::compile::TrainingKey;
    use crate::env::{Ending, Outcome, Spawn};
    use crate::geometry::Pose;
    use crate::judge::{Sight, Trial, Verdict};

    fn row(run: u32, episode: u32, hit: Option<(bool, f64)>) -> EpisodeRow {
        let ending = hit.map_or(Ending::Timeout, |(front, impact_speed)| Ending::Collision {
            front,
            moving: impact_speed > 0.1,
            impact_speed,
            bearing: 0.5,
        });
        let spawn = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let reward = hit.map_or(0.0, |(_, speed)| 1.0 + speed);
        let (least_gap, last_mode) = (1.0, DrivingMode::Cruise);
        // Frontal ones are preventable, others happen to a standing car.
        let verdict = hit.map(|(front, impact_speed)| Verdict {
            label: if front { Label::Preventable } else { Label::Standing },
            warning: 2.0,
            foreseeable: front,
            sight: Sight { hidden: 0.0, seen: 3.0 },
            impact_speed,
            trials: [Trial { impact_speed: None, time: 1.0, least_gap: 0.5 }; 6],
        });
        EpisodeRow {
            run_id: format!("{run:08x}").parse().unwrap(),
            trained: TrainingKey { town: "a".into(), policy: "p".into(), reward: "r1".into(), run }.into(),
            pedestrian: "trained",
            town: "b".into(),
            policy: "p".into(),
            vehicle: "v".into(),
            adversary: "w".into(),
            block: 0,
            episode,
            outcome: Outcome {
                spawn,
                ending,
                reward,
                ticks: 10,
                duration: 0.5,
                least_gap,
                last_mode,
                digest: 7,
                trail: Default::default(),
            },
            verdict,
            near_miss: crate::judge::NearMiss::default(),
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
        let near = |spread: Spread, mean: f64, sd: f64| {
            assert!((spread.mean.unwrap() - mean).abs() < 1e-12, "{spread:?}");
            assert!((spread.sd.unwrap() - sd).abs() < 1e-12, "{spread:?}");
        };
        near(cell.collision, 0.375, 0.125 * 2.0_f64.sqrt());
        near(cell.front, 0.75, 0.25 * 2.0_f64.sqrt());
        near(cell.moving, 0.25, 0.0);
        near(cell.impact_speed, 4.0, 2.0 * 2.0_f64.sqrt());
        assert_eq!(cell.interval, wilson(3, 8));
        near(cell.preventable, 0.25, 0.0);
        near(cell.preventable_share, 0.75, 0.25 * 2.0_f64.sqrt());
        assert_eq!((cell.preventable_interval, cell.preventable_share_interval), (wilson(2, 8), wilson(2, 3)));
        assert_eq!((cell.collisions, cell.labels, cell.foreseeable), (3, [2, 0, 0, 0, 0, 1], 2));
    }

    #[test]
    fn episodes_in_error_count_as_errors_and_nowhere_else() {
        let failed = |run, episode| {
            let mut row = row(run, episode, None);
            row.outcome.ending = Ending::Error(Fault::Ended);
            row.outcome.reward = 100.0;
            row
        };
        let rows = [row(0, 0, Some((true, 4.0))), failed(0, 1), row(0, 2, None), failed(1, 0)];
        let metrics = metrics(&episodes(&rows)).unwrap();
        let cell = &metrics.cells().unwrap()[0];
        assert_eq!((cell.runs, cell.episodes, cell.errors), (2, 2, 2));
        assert_eq!(cell.collision, Spread { mean: Some(0.5), sd: None }, "a run of errors alone has no rate");
        assert_eq!(cell.reward_sum.mean, Some(2.5));
        assert_eq!(cell.interval, wilson(1, 2));
    }

    #[test]
    fn a_run_without_collisions_has_no_front_rate() {
        let metrics = metrics(&episodes(&[row(0, 0, None)])).unwrap();
        let cell = &metrics.cells().unwrap()[0];
        assert_eq!(cell.front, Spread { mean: None, sd: None });
        assert_eq!(cell.collision, Spread { mean: Some(0.0), sd: None });
    }
}
