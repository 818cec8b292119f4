use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use crate::compile::RunId;
use crate::env::{Moment, Recording, Scenario};

/// An episode tick by tick as a table, the beginning first. The columns are explained in `reports/README.md`.
pub fn ticks(run: RunId, episode: u32, scenario: &Scenario, recording: &Recording) -> DataFrame {
    let moments = recording.moments();
    let number = |name: &str, value: &dyn Fn(&Moment) -> f64| {
        Column::from(Series::new(name.into(), moments.iter().map(value).collect::<Vec<f64>>()))
    };
    let counted = || 0..moments.len() as u32;
    let modes: Vec<&str> = moments.iter().map(|moment| moment.mode.name()).collect();
    let in_sight: Vec<bool> = moments.iter().map(|moment| moment.in_sight(scenario)).collect();
    let times: Vec<f64> = counted().map(|tick| f64::from(tick) * scenario.episode.tick).collect();
    let columns = vec![
        Series::new("run_id".into(), vec![run.to_string(); moments.len()]).into(),
        Series::new("episode".into(), vec![episode; moments.len()]).into(),
        Series::new("tick".into(), counted().collect::<Vec<u32>>()).into(),
        Series::new("time_s".into(), times).into(),
        number("ego_x_m", &|moment| moment.ego.pose.x),
        number("ego_y_m", &|moment| moment.ego.pose.y),
        number("ego_yaw_deg", &|moment| moment.ego.pose.yaw.to_degrees()),
        number("ego_speed_mps", &|moment| moment.ego.speed),
        number("pedestrian_x_m", &|moment| moment.pedestrian.pose.x),
        number("pedestrian_y_m", &|moment| moment.pedestrian.pose.y),
        number("pedestrian_yaw_deg", &|moment| moment.pedestrian.pose.yaw.to_degrees()),
        number("pedestrian_speed_mps", &|moment| moment.pedestrian.speed()),
        Series::new("driving_mode".into(), modes).into(),
        number("throttle", &|moment| moment.control.throttle),
        number("brake", &|moment| moment.control.brake),
        number("steer", &|moment| moment.control.steer),
        Series::new("in_sight".into(), in_sight).into(),
        number("gap_m", &|moment| moment.gap(scenario)),
    ];
    DataFrame::new(moments.len(), columns).expect("all columns have a value for every tick")
}
