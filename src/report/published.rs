use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use super::{Cell, Spread};
use crate::compile::{Published, PublishedCell, PublishedFigure};
use crate::statistics::student_quantile;

/// A spread that is printed as 0.00 may have been as large as this.
const ROUNDED_AWAY: f64 = 0.004;

/// A figure of ours beside one that others have published.
#[derive(Debug, Clone, PartialEq)]
pub struct Beside<'a> {
    /// Where the published one is from.
    pub source: &'a str,
    /// What is said of it.
    pub docs: &'a str,
    /// Our cell.
    pub cell: &'a Cell,
    /// The published figure; its column says which of the cell's it stands beside.
    pub published: PublishedFigure,
    /// Over how many trainings it was averaged.
    pub published_runs: u32,
    /// Ours.
    pub ours: Spread,
    /// Ours less theirs; none when ours has no value.
    pub difference: Option<f64>,
    /// Welch's 95 % interval of the difference, both spreads being between trainings; none without spreads.
    ///
    /// # Source
    /// Welch, *The generalization of "Student's" problem*, Biometrika 34, 1947. A
    /// published spread of 0.00 counts as 0.004.
    pub interval: Option<(f64, f64)>,
}

/// How near ours is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreement {
    /// No farther from the published mean than the published standard deviation.
    Within,
    /// Farther, but the interval of the difference holds 0.
    Indistinct,
    /// The interval of the difference does not hold 0.
    Differs,
    /// There is too little to say.
    Unknown,
}

impl Agreement {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "within its spread",
            Self::Indistinct => "indistinct",
            Self::Differs => "differs",
            Self::Unknown => "unknown",
        }
    }
}

impl Beside<'_> {
    /// The published mean and spread.
    pub fn theirs(&self) -> Spread {
        Spread { mean: Some(self.published.mean), sd: self.published.sd }
    }

    /// How near ours is.
    pub fn agreement(&self) -> Agreement {
        let (Some(difference), Some((low, high))) = (self.difference, self.interval) else { return Agreement::Unknown };
        if self.published.sd.is_some_and(|sd| difference.abs() <= sd.max(ROUNDED_AWAY)) {
            Agreement::Within
        } else if low <= 0.0 && high >= 0.0 {
            Agreement::Indistinct
        } else {
            Agreement::Differs
        }
    }
}

/// Puts published figures beside those of our trained pedestrians, in the order of the published cells.
pub fn beside<'a>(published: &'a [Published], cells: &'a [Cell]) -> Vec<Beside<'a>> {
    let mut all = Vec::new();
    for table in published {
        for (theirs, cell) in table.cells.iter().flat_map(|theirs| matching(theirs, cells)) {
            all.extend(theirs.figures.iter().map(|figure| compare(table, *figure, cell)));
        }
    }
    all
}

fn matching<'a>(theirs: &'a PublishedCell, cells: &'a [Cell]) -> impl Iterator<Item = (&'a PublishedCell, &'a Cell)> {
    let trained = |cell: &&Cell| ["trained", "sampled"].contains(&cell.key.controller.as_str());
    let same = move |cell: &&Cell| {
        theirs.rewards.contains(&cell.key.reward)
            && theirs.towns.contains(&cell.key.town)
            && theirs.policies.contains(&cell.key.policy)
    };
    cells.iter().filter(trained).filter(same).map(move |cell| (theirs, cell))
}

fn compare<'a>(table: &'a Published, published: PublishedFigure, cell: &'a Cell) -> Beside<'a> {
    let ours = match published.column {
        "collision_rate" => cell.collision,
        "front_rate" => cell.front,
        "moving_rate" => cell.moving,
        "episode_reward" => cell.reward_sum,
        "episode_length_s" => cell.length,
        "impact_speed_mps" => cell.impact_speed,
        other => panic!("`{other}` is no figure of a cell"),
    };
    let difference = ours.mean.map(|mean| mean - published.mean);
    let interval = difference.zip(ours.sd).zip(published.sd).and_then(|((difference, sd), theirs)| {
        let half = welch((sd, cell.runs), (theirs.max(ROUNDED_AWAY), table.runs))?;
        Some((difference - half, difference + half))
    });
    let (source, docs) = (&table.source, &table.docs);
    Beside { source, docs, cell, published, published_runs: table.runs, ours, difference, interval }
}

/// Half the width of Welch's 95 % interval of a difference of two means, from their standard deviations and numbers.
fn welch((a, n): (f64, u32), (b, m): (f64, u32)) -> Option<f64> {
    if n < 2 || m < 2 {
        return None;
    }
    let (a, b) = (a * a / f64::from(n), b * b / f64::from(m));
    let degrees = (a + b) * (a + b) / (a * a / f64::from(n - 1) + b * b / f64::from(m - 1));
    Some(student_quantile(degrees) * (a + b).sqrt())
}

/// Published figures beside ours as a table, one row for each figure.
pub fn published(all: &[Beside<'_>]) -> DataFrame {
    let text = |name: &str, value: &dyn Fn(&Beside<'_>) -> String| {
        Column::from(Series::new(name.into(), all.iter().map(value).collect::<Vec<String>>()))
    };
    let count = |name: &str, value: &dyn Fn(&Beside<'_>) -> u32| {
        Column::from(Series::new(name.into(), all.iter().map(value).collect::<Vec<u32>>()))
    };
    let number = |name: &str, value: &dyn Fn(&Beside<'_>) -> Option<f64>| {
        Column::from(Series::new(name.into(), all.iter().map(value).collect::<Vec<Option<f64>>>()))
    };
    let columns = vec![
        text("source", &|row| row.source.to_string()),
        text("reward", &|row| row.cell.key.reward.clone()),
        text("train_town", &|row| row.cell.key.train_town.clone()),
        text("train_policy", &|row| row.cell.key.train_policy.clone()),
        text("pedestrian", &|row| row.cell.key.controller.clone()),
        text("town", &|row| row.cell.key.town.clone()),
        text("policy", &|row| row.cell.key.policy.clone()),
        text("vehicle", &|row| row.cell.key.vehicle.clone()),
        text("adversary", &|row| row.cell.key.adversary.clone()),
        count("block", &|row| row.cell.key.block),
        text("figure", &|row| row.published.column.to_string()),
        number("published_mean", &|row| Some(row.published.mean)),
        number("published_sd", &|row| row.published.sd),
        count("published_runs", &|row| row.published_runs),
        number("mean", &|row| row.ours.mean),
        number("sd", &|row| row.ours.sd),
        count("runs", &|row| row.cell.runs),
        number("difference", &|row| row.difference),
        number("difference_low", &|row| row.interval.map(|interval| interval.0)),
        number("difference_high", &|row| row.interval.map(|interval| interval.1)),
        text("agreement", &|row| row.agreement().name().to_string()),
    ];
    DataFrame::new(all.len(), columns).expect("all columns have a value for every row")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welchs_interval_is_scipys() {
        // scipy 1.17.1: stats.t.ppf(0.975, 2.391412) times the standard error, for 0.02 of 5 and 0.05 of 3.
        let half = welch((0.02, 5), (0.05, 3)).unwrap();
        assert!((half - 0.111_622_865_793).abs() < 1e-9, "{half}");
        assert_eq!(welch((0.02, 1), (0.05, 3)), None);
    }
}
