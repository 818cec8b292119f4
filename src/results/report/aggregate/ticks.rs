use polars::prelude::DataFrame;

use crate::record::columns::{
    DRIVING_MODE, EGO_SPEED, EGO_X, EGO_Y, EGO_YAW, EPISODE, PEDESTRIAN_X, PEDESTRIAN_Y, PEDESTRIAN_YAW, RUN_ID,
};
use crate::record::{Column, Table, entries};
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
    Table::new("ticks", "One row for each tick of an episode, the start first. `falsify replay NAME --ticks FILE` writes it; a report does not have it.")
        .columns(entries! { row: &Tick<'_>;
            RUN_ID = row.run.to_string();
            EPISODE = row.episode;
            /// number of the tick, 0 at the start
            tick: u32 = row.number;
            /// end of the tick
            time_s: f64 ["s"] = f64::from(row.number) * row.pair.dt();
            /// middle of the car's box, in the world frame
            EGO_X = row.frame.ego.pose.x;
            /// middle of the car's box, in the world frame
            EGO_Y = row.frame.ego.pose.y;
            /// heading of the car
            EGO_YAW = row.frame.ego.pose.yaw.to_degrees();
            /// speed of the car
            EGO_SPEED = row.frame.ego.speed;
            /// middle of the pedestrian, in the world frame
            PEDESTRIAN_X = row.frame.pedestrian.pose.x;
            /// middle of the pedestrian, in the world frame
            PEDESTRIAN_Y = row.frame.pedestrian.pose.y;
            /// heading of the pedestrian
            PEDESTRIAN_YAW = row.frame.pedestrian.pose.yaw.to_degrees();
            /// speed of the pedestrian
            pedestrian_speed_mps: f64 ["m/s"] = row.frame.pedestrian.speed();
            /// what the driver did in the tick that ended then
            DRIVING_MODE = row.frame.mode.name();
            /// throttle in that tick, 0 to 1
            throttle: f64 = row.frame.control.throttle;
            /// brake in that tick, 0 to 1
            brake: f64 = row.frame.control.brake;
            /// steering in that tick, −1 to 1, positive to the left
            steer: f64 = row.frame.control.steer;
            /// whether any of the pedestrian could be seen from the driver's eye, 1.9 m behind the bumper
            in_sight: bool = row.pair.in_sight(&row.frame);
            /// distance from the pedestrian's disc to the car's box; 0 in a touch
            gap_m: f64 ["m"] = row.pair.gap(&row.frame);
        })
        .columns(STATE.map(|(name, meaning, number)| {
            Column::<f64>::new(name, "as the state", meaning).of(move |row: &Tick<'_>| row.state().map(|state| state[number]))
        }))
        .columns(ACTION.map(|(name, meaning, number)| {
            Column::<f64>::new(name, "as the action", meaning).of(move |row: &Tick<'_>| row.action().map(|action| action[number]))
        }))
}
