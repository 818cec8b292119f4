use polars::prelude::DataFrame;

use crate::record::columns::{
    DRIVING_MODE, EGO_SPEED, EGO_X, EGO_Y, EGO_YAW, EPISODE, PEDESTRIAN_X, PEDESTRIAN_Y, PEDESTRIAN_YAW, RUN_ID,
};
use crate::record::{Column, Table};
use compile::RunId;
use episode::{ActionSpec, Frame, ObservationSpec, Pair, Scenario, Trace};

/// A tick of an episode.
pub struct Tick<'a> {
    run: RunId,
    episode: u32,
    number: u32,
    pair: &'a Pair<'a>,
    frame: Frame,
}

/// The columns of the state, with the number of the component.
const STATE: [(&str, &str, usize); ObservationSpec::DIM] = [
    (
        "state_bearing",
        "first number of the state that the pedestrian gets for a decision here, in the frame and units of its `body` \
         (`falsify explain state`); missing where it takes no decision",
        0,
    ),
    ("state_distance", "second number of that state", 1),
    ("state_relative_heading", "third number of that state", 2),
    ("state_speed", "fourth number of that state", 3),
];

/// The columns of the action.
const ACTION: [(&str, &str, usize); ActionSpec::DIM] = [
    (
        "action_heading",
        "first number of the action that the pedestrian takes here, within its bounds (`falsify explain action`); missing where it keeps \
         its command",
        0,
    ),
    ("action_speed", "second number of that action", 1),
];

impl Tick<'_> {
    fn state(&self) -> Option<[f64; ObservationSpec::DIM]> {
        self.pair.decision(self.number as usize).map(|_| self.pair.state(&self.frame))
    }

    fn action(&self) -> Option<[f64; ActionSpec::DIM]> {
        self.pair.decision(self.number as usize).map(|decision| self.pair.action(&self.frame, decision))
    }
}

/// An episode tick by tick as a table, the start first.
pub fn ticks(run: RunId, episode: u32, scenario: &Scenario, trace: &Trace) -> DataFrame {
    let pair = &trace.main_pair(scenario);
    let tick = |(number, frame)| Tick { run, episode, number, pair, frame };
    tick_table().frame(&(0..).zip(pair.frames()).map(tick).collect::<Vec<_>>())
}

/// The columns of [`ticks`].
pub fn tick_table<'a>() -> Table<'a, Tick<'a>> {
    let middle = "middle of the car's box, in the world frame";
    let person = "middle of the pedestrian, in the world frame";
    Table::new("ticks", "One row for each tick of an episode, the start first. `falsify replay NAME --ticks FILE` writes it; a report does not have it.")
        .column(RUN_ID.of(|row: &Tick<'_>| row.run.to_string()))
        .column(EPISODE.of(|row: &Tick<'_>| row.episode))
        .column(Column::<u32>::new("tick", "", "number of the tick, 0 at the start").of(|row: &Tick<'_>| row.number))
        .measure("time_s", "s", "end of the tick", |row| f64::from(row.number) * row.pair.dt())
        .column(EGO_X.of(|row: &Tick<'_>| row.frame.ego.pose.x).meaning(middle))
        .column(EGO_Y.of(|row: &Tick<'_>| row.frame.ego.pose.y).meaning(middle))
        .column(EGO_YAW.of(|row: &Tick<'_>| row.frame.ego.pose.yaw.to_degrees()).meaning("heading of the car"))
        .column(EGO_SPEED.of(|row: &Tick<'_>| row.frame.ego.speed).meaning("speed of the car"))
        .column(PEDESTRIAN_X.of(|row: &Tick<'_>| row.frame.pedestrian.pose.x).meaning(person))
        .column(PEDESTRIAN_Y.of(|row: &Tick<'_>| row.frame.pedestrian.pose.y).meaning(person))
        .column(
            PEDESTRIAN_YAW
                .of(|row: &Tick<'_>| row.frame.pedestrian.pose.yaw.to_degrees())
                .meaning("heading of the pedestrian"),
        )
        .measure("pedestrian_speed_mps", "m/s", "speed of the pedestrian", |row| row.frame.pedestrian.speed())
        .column(
            DRIVING_MODE.of(|row: &Tick<'_>| row.frame.mode.name()).meaning("what the driver did in the tick that ended then"),
        )
        .number("throttle", "throttle in that tick, 0 to 1", |row| row.frame.control.throttle)
        .number("brake", "brake in that tick, 0 to 1", |row| row.frame.control.brake)
        .number("steer", "steering in that tick, −1 to 1, positive to the left", |row| row.frame.control.steer)
        .column(
            Column::<bool>::new(
                "in_sight",
                "",
                "whether any of the pedestrian could be seen from the driver's eye, 1.9 m behind the bumper",
            )
            .of(|row: &Tick<'_>| row.pair.in_sight(&row.frame)),
        )
        .measure(
            "gap_m",
            "m",
            "distance from the pedestrian's disc to the car's box; 0 in a touch",
            |row| row.pair.gap(&row.frame),
        )
        .columns(STATE.map(|(name, meaning, number)| {
            Column::<f64>::new(name, "as the state", meaning).of(move |row: &Tick<'_>| row.state().map(|state| state[number]))
        }))
        .columns(ACTION.map(|(name, meaning, number)| {
            Column::<f64>::new(name, "as the action", meaning).of(move |row: &Tick<'_>| row.action().map(|action| action[number]))
        }))
}
