use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use crate::compile::RunId;
use crate::env::{Frame, Scenario, Trace};

/// An episode tick by tick as a table, the beginning first. The columns are explained in `reports/README.md`.
pub fn ticks(run: RunId, episode: u32, scenario: &Scenario, trace: &Trace) -> DataFrame {
    let pair = trace.main_pair(scenario);
    let frames: Vec<Frame> = pair.frames().collect();
    let number = |name: &str, value: &dyn Fn(&Frame) -> f64| {
        Column::from(Series::new(name.into(), frames.iter().map(value).collect::<Vec<f64>>()))
    };
    let counted = || 0..frames.len() as u32;
    let modes: Vec<&str> = frames.iter().map(|frame| frame.mode.name()).collect();
    let in_sight: Vec<bool> = frames.iter().map(|frame| pair.in_sight(frame)).collect();
    let times: Vec<f64> = counted().map(|tick| f64::from(tick) * scenario.episode.tick).collect();
    let columns = vec![
        Series::new("run_id".into(), vec![run.to_string(); frames.len()]).into(),
        Series::new("episode".into(), vec![episode; frames.len()]).into(),
        Series::new("tick".into(), counted().collect::<Vec<u32>>()).into(),
        Series::new("time_s".into(), times).into(),
        number("ego_x_m", &|frame| frame.ego.pose.x),
        number("ego_y_m", &|frame| frame.ego.pose.y),
        number("ego_yaw_deg", &|frame| frame.ego.pose.yaw.to_degrees()),
        number("ego_speed_mps", &|frame| frame.ego.speed),
        number("pedestrian_x_m", &|frame| frame.pedestrian.pose.x),
        number("pedestrian_y_m", &|frame| frame.pedestrian.pose.y),
        number("pedestrian_yaw_deg", &|frame| frame.pedestrian.pose.yaw.to_degrees()),
        number("pedestrian_speed_mps", &|frame| frame.pedestrian.speed()),
        Series::new("driving_mode".into(), modes).into(),
        number("throttle", &|frame| frame.control.throttle),
        number("brake", &|frame| frame.control.brake),
        number("steer", &|frame| frame.control.steer),
        Series::new("in_sight".into(), in_sight).into(),
        number("gap_m", &|frame| pair.gap(frame)),
    ];
    DataFrame::new(frames.len(), columns).expect("all columns have a value for every tick")
}
