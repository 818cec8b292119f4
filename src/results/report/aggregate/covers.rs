use polars::prelude::DataFrame;

use crate::jobs::CoverResult;
use crate::record::columns::{POLICY, RUN_ID, TOWN};
use crate::record::{Column, Table};
use compile::CoverKey;
use world::env::StartParameter;
use world::likelihood::{Look, Point};

/// The stems of the files of the tables.
pub const COVERS: &str = "covers";
pub const COVER_POINTS: &str = "cover_points";

/// What a cover shows, in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct CoverRow {
    pub key: CoverKey,
    /// The name of what it counts.
    pub failure: String,
    /// The names of the parameters of the box.
    pub parameters: Vec<&'static str>,
    /// The share of the box that is small enough.
    pub epsilon: f64,
    pub budget: u32,
    pub episodes: u64,
    /// The episodes that failed.
    pub failures: u64,
    pub looks: u64,
    /// The look with the least bound; none when it ended before its first look.
    pub look: Option<Look>,
    /// The share of the box that the picture of this look shows as failing.
    pub shown: Option<f64>,
    pub unplaced: u64,
    pub left_out: u64,
    pub errors: u64,
    pub ticks: u64,
}

impl CoverRow {
    fn new(result: &CoverResult) -> Self {
        let found = &result.found;
        let coverage = &found.coverage;
        let look = coverage.best().copied();
        Self {
            key: result.key.clone(),
            failure: result.failure.clone(),
            parameters: result.parameters.iter().map(|drawn| drawn.parameter.name()).collect(),
            epsilon: result.epsilon,
            budget: result.budget,
            episodes: coverage.points.len() as u64,
            failures: coverage.failures(),
            looks: coverage.looks.len() as u64,
            look,
            shown: look.map(|look| coverage.shown(&coverage.picture(&look))),
            unplaced: found.unplaced,
            left_out: found.left_out,
            errors: found.errors,
            ticks: found.ticks,
        }
    }

    /// Whether the bound is small enough.
    pub fn is_covered(&self) -> bool {
        self.look.is_some_and(|look| look.bound <= self.epsilon)
    }

    /// What is shown, as a sentence without its end.
    pub fn statement(&self) -> String {
        let Some(look) = self.look else { return "Nothing is shown: it ended before its first check".into() };
        let which = if self.failures == 0 { "" } else { " that the picture does not show" };
        let enough = match self.is_covered() {
            true => String::new(),
            false => format!(", more than the {} asked for", percent_above(self.epsilon)),
        };
        format!(
            "With 95 % confidence no {}{which} occupies more than {} of the box{enough}",
            self.failure,
            percent_above(look.bound)
        )
    }
}

/// A share in percent with two digits, rounded up.
pub fn percent_above(share: f64) -> String {
    let percent = share * 100.0;
    let digits = if percent >= 10.0 {
        0
    } else if percent >= 1.0 {
        1
    } else {
        2
    };
    let unit = libm::pow(10.0, f64::from(digits));
    format!("{:.*} %", digits as usize, (percent * unit - 1e-9).ceil() / unit)
}

/// The rows of all covers.
pub fn cover_rows(results: &[CoverResult]) -> Vec<CoverRow> {
    results.iter().map(CoverRow::new).collect()
}

/// What a cover shows, as a short line for a terminal.
pub fn cover_in_words(result: &CoverResult) -> String {
    let coverage = &result.found.coverage;
    let episodes = coverage.points.len();
    match coverage.best() {
        None => format!("{episodes} episodes, and no check"),
        Some(look) => {
            format!("{} failures, bound {} in {episodes} episodes", coverage.failures(), percent_above(look.bound))
        }
    }
}

/// The columns of `covers`.
pub fn cover_columns<'a>() -> Table<'a, CoverRow> {
    let (count, number) = (Column::<u64>::new, Column::<f64>::new);
    let look = |row: &CoverRow, value: fn(&Look) -> u64| row.look.as_ref().map(value);
    Table::new(
        COVERS,
        "One row for each `cover` of a driver in a town: how much of a box of starts can fail where the picture says that it passes. Equal parts \
         of the box are equally likely by the spawn rule.",
    )
    .column(RUN_ID.of(|row: &CoverRow| row.key.id.to_string()))
    .column(TOWN.of(|row: &CoverRow| row.key.town.clone()))
    .column(POLICY.of(|row: &CoverRow| row.key.policy.clone()))
    .column(Column::<String>::new("spawn", "", "spawn rule whose ranges are the box").of(|row: &CoverRow| row.key.spawn.clone()))
    .column(Column::<String>::new("pedestrian", "", "who walks").of(|row: &CoverRow| row.key.pedestrian.clone()))
    .column(count("block", "", "number of the `cover` block in its campaign, from 0").of(|row: &CoverRow| u64::from(row.key.block)))
    .column(Column::<String>::new("parameters", "", "parameters of the box").of(|row: &CoverRow| row.parameters.join(" ")))
    .column(Column::<String>::new("counts", "", "what counts as failed: `fault`, `collision` or the name of a requirement").of(|row: &CoverRow| row.failure.clone()))
    .column(number("epsilon", "", "share of the box that is small enough").of(|row: &CoverRow| row.epsilon))
    .column(number("bound", "", "one-sided bound, with 95 % confidence over all checks together, of the share that fails where the picture says that it passes; missing without a check").of(|row: &CoverRow| row.look.map(|look| look.bound)))
    .column(Column::<bool>::new("covered", "", "whether the bound is at most `epsilon`").of(CoverRow::is_covered))
    .column(count("checked", "", "fresh episodes of the check with the least bound, uniform in the box").of(move |row: &CoverRow| look(row, |look| look.points)))
    .column(count("worse", "", "of these failed where the picture says that they pass").of(move |row: &CoverRow| look(row, |look| look.worse)))
    .column(count("better", "", "of these passed where the picture says that they fail").of(move |row: &CoverRow| look(row, |look| look.better)))
    .column(number("alpha", "", "share of the 5 % that this check may use").of(|row: &CoverRow| row.look.map(|look| look.alpha)))
    .column(count("learnt", "", "first episodes, from which that picture was learnt").of(move |row: &CoverRow| look(row, |look| look.learnt)))
    .column(number("shown", "", "share of the box that the picture shows as failing").of(|row: &CoverRow| row.shown))
    .column(count("checks", "", "number of checks").of(|row: &CoverRow| row.looks))
    .column(count("episodes", "", "episodes in all").of(|row: &CoverRow| row.episodes))
    .column(count("budget", "", "episodes that it might use").of(|row: &CoverRow| u64::from(row.budget)))
    .column(count("failures", "", "episodes that failed").of(|row: &CoverRow| row.failures))
    .column(count("unplaced", "", "points of the box for which no place on the road was found; they count as passed").of(|row: &CoverRow| row.unplaced))
    .column(count("left_out_episodes", "", "episodes that are left out; they count as passed").of(|row: &CoverRow| row.left_out))
    .column(count("errors", "", "episodes in which a program failed; they count as passed").of(|row: &CoverRow| row.errors))
    .column(count("ticks", "", "simulator ticks in all").of(|row: &CoverRow| row.ticks))
}

/// The table `covers`.
pub fn cover_table(rows: &[CoverRow]) -> DataFrame {
    cover_columns().frame(rows)
}

/// An episode of a cover, with its number.
pub type Covering<'a> = (&'a CoverResult, u64, &'a Point);

/// The columns of `cover_points`.
pub fn cover_point_columns<'a>() -> Table<'a, Covering<'a>> {
    type Row<'a> = Covering<'a>;
    let of = |row: &Row<'_>, parameter: StartParameter| {
        let place = row.0.parameters.iter().position(|drawn| drawn.parameter == parameter)?;
        Some(row.0.parameters[place].value(*row.2.at.get(place)?))
    };
    let value =
        |name, unit, doc, parameter| Column::<f64>::new(name, unit, doc).of(move |row: &Row<'_>| of(row, parameter));
    Table::new(
        COVER_POINTS,
        "One row for each episode of a `cover`, in their order, with its point in the box. Parameters that are no part of the box are missing.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.0.key.id.to_string()))
    .column(Column::<u64>::new("episode", "", "number of the episode, from 0").of(|row: &Row<'_>| row.1))
    .column(
        Column::<String>::new(
            "sampled",
            "",
            "why it was run: `design` to fill the box, `learning` where pass and fail were least sure, `look` to check the picture",
        )
        .of(|row: &Row<'_>| row.2.sampled.name()),
    )
    .column(Column::<bool>::new("failed", "", "whether it failed").of(|row: &Row<'_>| row.2.failed))
    .column(value("bearing_rad", "rad", "bearing of the pedestrian from the car, positive to the left", StartParameter::Bearing))
    .column(value("distance_m", "m", "distance between the centres", StartParameter::Distance))
    .column(value("heading_rad", "rad", "first heading of the pedestrian from that of the car", StartParameter::Heading))
    .column(value("ego_speed_mps", "m/s", "speed of the car at the start", StartParameter::EgoSpeed))
    .column(value("approach", "", "share of its way that a target starts from", StartParameter::Approach))
    .column(value("delay_s", "s", "time for which the pedestrian stands at the start of its path", StartParameter::Delay))
    .column(value("walking_speed_mps", "m/s", "speed of a target", StartParameter::WalkingSpeed))
    .column(value("turn_rad", "rad", "angle by which the line of a target is turned", StartParameter::Turn))
}

/// The table `cover_points`.
pub fn cover_point_table(results: &[CoverResult]) -> DataFrame {
    let numbered =
        results.iter().flat_map(|result| (0..).zip(&result.found.coverage.points).map(move |point| (result, point)));
    let rows: Vec<Covering<'_>> = numbered.map(|(result, (number, point))| (result, number, point)).collect();
    cover_point_columns().frame(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_rounded_up() {
        let shares = [0.0098, 0.00981, 0.01, 0.0123, 0.139, 0.5];
        assert_eq!(shares.map(percent_above), ["0.98 %", "0.99 %", "1.0 %", "1.3 %", "14 %", "50 %"]);
    }
}
