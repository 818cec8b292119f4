use super::layout::Layout;
use super::network::Network;
use super::surface::{Surfaces, Tile};
use super::town_design::{BuildingRow, TownDesign};
use crate::Road;
use crate::geometry::{OrientedBox, Pose, Vector};

/// Adds the houses that stand on no road and in no building.
pub(super) fn add(
    row: &BuildingRow,
    design: &TownDesign,
    layout: &Layout,
    network: &Network,
    surfaces: &Surfaces,
    obstacles: &mut Vec<OrientedBox>,
) {
    let mut taken: Vec<Tile> = obstacles.iter().map(Tile::new).collect();
    for (road, edge) in network.along.iter().zip(&layout.edges) {
        let Some(road) = road else { continue };
        let half_width = design.streets[edge.street].carriageway.street_half_width(&design.profile);
        for house in houses(row, half_width, &network.roads[road.0 as usize]) {
            let tile = Tile::new(&house);
            if !surfaces.lie_under(&tile) && !taken.iter().any(|other| other.overlaps(&tile)) {
                taken.push(tile);
                obstacles.push(house);
            }
        }
    }
}

/// As many houses as fit along a straight road of half a width (m), in its middle, on either side.
fn houses(row: &BuildingRow, half_width: f64, road: &Road) -> impl Iterator<Item = OrientedBox> {
    let pitch = row.length + row.gap;
    let count = ((road.length + row.gap) / pitch).floor().max(0.0);
    let first = (road.length - (count * pitch - row.gap)) / 2.0 + row.length / 2.0;
    let across = half_width + row.setback + row.depth / 2.0;
    let start = road.plan_view.pose(0.0);
    let half = Vector::new(row.length / 2.0, row.depth / 2.0);
    let places = [1.0, -1.0].into_iter().flat_map(move |side| {
        (0..count as usize).map(move |index| Vector::new(first + index as f64 * pitch, side * across))
    });
    places.map(move |place| {
        let centre = start.to_world(place);
        OrientedBox { pose: Pose::new(centre.x, centre.y, start.yaw), half }
    })
}
