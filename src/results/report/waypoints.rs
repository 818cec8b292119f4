use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use world::road::{LaneKind, Town, Waypoint};

/// The waypoints of all driving lanes at a spacing (m) along the reference lines, in CARLA's frame: x, −y, −yaw.
///
/// # Source
/// CARLA's `Map.generate_waypoints`; columns as its client prints them.
pub fn waypoints(town: &Town, spacing: f64) -> DataFrame {
    let all: Vec<Waypoint> = town
        .generate_waypoints(spacing)
        .into_iter()
        .filter(|each| town.lane_kind(*each) == LaneKind::Driving)
        .collect();
    let poses: Vec<_> = all.iter().map(|each| town.pose(*each)).collect();
    let number = |name: &str, values: Vec<f64>| Column::from(Series::new(name.into(), values));
    let road = |each: &Waypoint| &town.roads[each.road.0 as usize];
    let junction =
        |each: &Waypoint| town.junction(*each).map_or(-1, |junction| i64::from(town.junctions[junction.0 as usize].id));
    let columns = vec![
        Column::from(Series::new("road_id".into(), all.iter().map(|each| road(each).id).collect::<Vec<u32>>())),
        Column::from(Series::new("section_id".into(), all.iter().map(|each| each.section).collect::<Vec<u32>>())),
        Column::from(Series::new("lane_id".into(), all.iter().map(|each| each.lane).collect::<Vec<i32>>())),
        number("s", all.iter().map(|each| each.s).collect()),
        number("x", poses.iter().map(|pose| pose.x).collect()),
        number("y", poses.iter().map(|pose| -pose.y).collect()),
        number("z", all.iter().map(|each| town.elevation(*each)).collect()),
        number("yaw", poses.iter().map(|pose| -pose.yaw.to_degrees()).collect()),
        number("lane_width", all.iter().map(|each| town.lane_width(*each)).collect()),
        Column::from(Series::new("lane_type".into(), vec!["Driving"; all.len()])),
        Column::from(Series::new(
            "is_junction".into(),
            all.iter().map(|each| town.is_junction(*each)).collect::<Vec<bool>>(),
        )),
        Column::from(Series::new("junction_id".into(), all.iter().map(junction).collect::<Vec<i64>>())),
    ];
    DataFrame::new(all.len(), columns).expect("all columns have a value for every waypoint")
}
