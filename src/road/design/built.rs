use super::layout::{Layout, MAX_FAULTS};
use super::network::Network;
use super::surface::Surfaces;
use super::{Carriageway, DesignError, TownDesign, building_row, lights_and_signs};
use crate::TownParts;

/// The farthest a node may lie from the origin along either axis (m).
const REACH: f64 = 10_000.0;

impl TownDesign {
    /// Lays out the roads and everything beside them.
    ///
    /// # Errors
    /// All faults of the design. Parts that a fault makes impossible to lay out (for example the ways through a junction with a
    /// sharp angle) are excluded from the search for further faults.
    pub fn build(&self) -> Result<TownParts, Vec<DesignError>> {
        let mut faults = self.measure_faults();
        if !faults.is_empty() {
            // Without sane measures every street would be at fault.
            return Err(faults);
        }
        let layout = Layout::new(self, &mut faults);
        faults.truncate(MAX_FAULTS);
        if faults.len() == MAX_FAULTS {
            return Err(faults);
        }
        let network = Network::new(self, &layout);
        let surfaces = Surfaces::new(self, &layout, &network);
        surfaces.find_overlaps(&network, &mut faults);
        surfaces.find_buildings(self, &network, &mut faults);
        if !faults.is_empty() {
            return Err(faults);
        }
        let mut obstacles = self.buildings.clone();
        if let Some(row) = &self.block_buildings {
            building_row::add(row, self, &layout, &network, &surfaces, &mut obstacles);
        }
        Ok(TownParts {
            name: self.name.clone(),
            speed_signs: lights_and_signs::speed_signs(self, &layout, &network),
            traffic_lights: lights_and_signs::traffic_lights(self, &layout, &network),
            roads: network.roads,
            junctions: network.junctions,
            obstacles,
            ..TownParts::default()
        })
    }

    fn measure_faults(&self) -> Vec<DesignError> {
        let half_width = Carriageway::default().street_half_width(&self.profile);
        let mut limits = vec![
            ("lane width", self.profile.lane_width, 2.0, 20.0),
            ("shoulder", self.profile.shoulder, 0.0, 20.0),
            ("sidewalk", self.profile.sidewalk, 0.5, 20.0),
            ("corner radius", self.corner_radius, 0.5, 100.0),
            ("junction radius", self.junction_radius, 1.0, 100.0),
        ];
        if let Some(row) = &self.block_buildings {
            limits.push(("setback of buildings", row.setback, 0.0, 1000.0));
            limits.push(("depth of buildings", row.depth, 1.0, 1000.0));
            limits.push(("length of buildings", row.length, 1.0, 1000.0));
            limits.push(("gap between buildings", row.gap, 0.0, 1000.0));
        }
        // The bend's limit follows from the widths, which must be sound first. Wider streets have a fault of their own where they bend.
        if half_width.is_finite() {
            limits.push(("bend radius", self.bend_radius, half_width + 0.5, 1000.0));
        }
        let outside = |value: f64, low: f64, high: f64| !(low..=high).contains(&value);
        let mut faults: Vec<DesignError> = limits
            .into_iter()
            .filter(|&(_, value, low, high)| outside(value, low, high))
            .map(|(what, value, low, high)| DesignError::Measure { what, value, low, high })
            .collect();
        for node in &self.nodes {
            if outside(node.position.x, -REACH, REACH) || outside(node.position.y, -REACH, REACH) {
                faults.push(DesignError::FarNode { node: node.name.clone(), reach: REACH });
            }
        }
        for street in &self.streets {
            match street.speed_limit {
                Some(limit) if !(limit > 0.0 && limit.is_finite()) => {
                    faults.push(DesignError::SpeedLimit { street: street.name.clone(), limit });
                }
                _ => {}
            }
        }
        for (building, each) in self.buildings.iter().enumerate() {
            let numbers = [each.pose.x, each.pose.y, each.pose.yaw];
            let sound = numbers.iter().all(|n| n.is_finite())
                && [each.half.x, each.half.y].iter().all(|&n| n > 0.0 && n.is_finite());
            if !sound {
                faults.push(DesignError::BuildingMeasure { building });
            }
        }
        faults
    }
}
