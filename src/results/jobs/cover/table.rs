use super::Row;
use crate::record::columns::{DRIVER, EGO_SPEED, EPISODE, RUN_ID, TOWN};
use crate::record::{Table, entries};
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
    .columns(entries! { row: &Row<'_>;
        RUN_ID = row.0.origin.id.to_string();
        TOWN = row.0.town.clone();
        DRIVER = row.0.policy.clone();
        /// spawn rule whose ranges are the box
        spawn: String = row.0.spawn.clone();
        /// who walks
        pedestrian: String = row.0.pedestrian.clone();
        /// parameters of the box
        parameters: String = row.0.parameter_names().join(" ");
        /// what counts as failed: `fault`, `collision` or the name of a requirement
        counts: String = row.0.failure_name().to_string();
        /// share of the box that is small enough
        epsilon: f64 = row.0.epsilon;
        /// one-sided bound, with 95 % confidence over all checks together, of the share that fails where the picture says that it passes; missing without a
        /// check
        bound: f64 = row.1.bound();
        /// fresh episodes of the check with the least bound, uniform in the box
        checked: u64 = look(row, |look| look.points);
        /// of these failed where the picture says that they pass
        worse: u64 = look(row, |look| look.worse);
        /// share of the box that the picture shows as failing
        shown: f64 = row.1.shown;
        /// share of the box in which a driver that never brakes fails, in a sample of starts
        unbraked: f64 = Some(row.1.unbraked_share());
        /// episodes in all
        episodes: u64 = row.1.coverage.points.len() as u64;
        /// points of the box for which no place on the road was found; they count as passed
        unplaced: u64 = row.1.unplaced;
        /// episodes that are left out; they count as passed
        left_out_episodes: u64 = row.1.left_out;
        /// episodes in which a program failed; they count as passed
        errors: u64 = row.1.errors;
    })
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
    Table::new(
        COVER_POINTS,
        "One row for each episode of a `cover`, in their order, with its point in the box. Parameters outside the box are missing.",
    )
    .columns(entries! { row: &Covering<'_>;
        RUN_ID = row.0.origin.id.to_string();
        EPISODE = row.1 as u32;
        /// why it was run: `design` to fill the box, `learning` where pass and fail were least sure, `look` to check the picture
        sampled: String = row.2.sampled.name();
        /// whether it failed
        failed: bool = row.2.failed;
        /// bearing of the pedestrian from the car, positive to the left
        bearing_rad: f64 ["rad"] = of(row, StartParameter::Bearing);
        /// distance between the centres
        distance_m: f64 ["m"] = of(row, StartParameter::Distance);
        /// first heading of the pedestrian from that of the car
        heading_rad: f64 ["rad"] = of(row, StartParameter::Heading);
        EGO_SPEED = of(row, StartParameter::EgoSpeed);
        /// share of its way that a target starts from
        approach: f64 = of(row, StartParameter::Approach);
        /// time for which the pedestrian stands at the start of its path
        delay_s: f64 ["s"] = of(row, StartParameter::Delay);
        /// speed of a target
        walking_speed_mps: f64 ["m/s"] = of(row, StartParameter::WalkingSpeed);
        /// angle by which the line of a target is turned
        turn_rad: f64 ["rad"] = of(row, StartParameter::Turn);
    })
}
