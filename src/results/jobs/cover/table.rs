use super::Row;
use crate::record::columns::{DRIVER, EGO_SPEED, EPISODE, RUN_ID, TOWN};
use crate::record::{Column, Table};
use compile::Cover;
use episode::StartParameter;
use search::likelihood::{Look, Point};

/// The stems of the files of the tables.
pub const COVERS: &str = "covers";
pub const COVER_POINTS: &str = "cover_points";

/// The columns of `covers`.
pub fn columns<'a>() -> Table<'a, Row<'a>> {
    let look = |row: &Row<'_>, value: fn(&Look) -> u64| row.1.coverage.best().map(value);
    Table::new(
        COVERS,
        "One row for each `cover` of a driver in a town: how much of a box of starts can fail where the picture says that it passes. Equal parts \
         of the box are equally likely by the spawn rule.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.0.origin.id.to_string()))
    .column(TOWN.of(|row: &Row<'_>| row.0.town.clone()))
    .column(DRIVER.of(|row: &Row<'_>| row.0.policy.clone()))
    .column(Column::<String>::new("spawn", "", "spawn rule whose ranges are the box").of(|row: &Row<'_>| row.0.spawn.clone()))
    .column(Column::<String>::new("pedestrian", "", "who walks").of(|row: &Row<'_>| row.0.pedestrian.clone()))
    .column(Column::<String>::new("parameters", "", "parameters of the box").of(|row: &Row<'_>| row.0.parameter_names().join(" ")))
    .column(Column::<String>::new("counts", "", "what counts as failed: `fault`, `collision` or the name of a requirement").of(|row: &Row<'_>| row.0.failure_name().to_string()))
    .number("epsilon", "share of the box that is small enough", |row| row.0.epsilon)
    .number(
        "bound",
        "one-sided bound, with 95 % confidence over all checks together, of the share that fails where the picture \
         says that it passes; missing without a check",
        |row| row.1.bound(),
    )
    .count(
        "checked",
        "fresh episodes of the check with the least bound, uniform in the box",
        move |row| look(row, |look| look.points),
    )
    .count("worse", "of these failed where the picture says that they pass", move |row| look(row, |look| look.worse))
    .number("shown", "share of the box that the picture shows as failing", |row| row.1.shown)
    .number("unbraked", "share of the box in which a driver that never brakes fails, in a sample of starts", |row| Some(row.1.unbraked_share()))
    .count("episodes", "episodes in all", |row| row.1.coverage.points.len() as u64)
    .count(
        "unplaced",
        "points of the box for which no place on the road was found; they count as passed",
        |row| row.1.unplaced,
    )
    .count("left_out_episodes", "episodes that are left out; they count as passed", |row| row.1.left_out)
    .count("errors", "episodes in which a program failed; they count as passed", |row| row.1.errors)
}

/// An episode of a cover, with its number.
pub type Covering<'a> = (&'a Cover, u64, &'a Point);

/// The columns of `cover_points`.
pub fn point_columns<'a>() -> Table<'a, Covering<'a>> {
    let of = |row: &Covering<'_>, parameter: StartParameter| {
        let parameters = row.0.scenario.start_parameters();
        let place = parameters.iter().position(|drawn| drawn.parameter == parameter)?;
        Some(parameters[place].value(*row.2.at.get(place)?))
    };
    let value = |name, unit, doc, parameter| {
        Column::<f64>::new(name, unit, doc).of(move |row: &Covering<'_>| of(row, parameter))
    };
    Table::new(
        COVER_POINTS,
        "One row for each episode of a `cover`, in their order, with its point in the box. Parameters outside the box are missing.",
    )
    .column(RUN_ID.of(|row: &Covering<'_>| row.0.origin.id.to_string()))
    .column(EPISODE.of(|row: &Covering<'_>| row.1 as u32))
    .column(
        Column::<String>::new(
            "sampled",
            "",
            "why it was run: `design` to fill the box, `learning` where pass and fail were least sure, `look` to check the picture",
        )
        .of(|row: &Covering<'_>| row.2.sampled.name()),
    )
    .column(Column::<bool>::new("failed", "", "whether it failed").of(|row: &Covering<'_>| row.2.failed))
    .column(value("bearing_rad", "rad", "bearing of the pedestrian from the car, positive to the left", StartParameter::Bearing))
    .column(value("distance_m", "m", "distance between the centres", StartParameter::Distance))
    .column(value("heading_rad", "rad", "first heading of the pedestrian from that of the car", StartParameter::Heading))
    .column(EGO_SPEED.of(move |row: &Covering<'_>| of(row, StartParameter::EgoSpeed)))
    .column(value("approach", "", "share of its way that a target starts from", StartParameter::Approach))
    .column(value("delay_s", "s", "time for which the pedestrian stands at the start of its path", StartParameter::Delay))
    .column(value("walking_speed_mps", "m/s", "speed of a target", StartParameter::WalkingSpeed))
    .column(value("turn_rad", "rad", "angle by which the line of a target is turned", StartParameter::Turn))
}
