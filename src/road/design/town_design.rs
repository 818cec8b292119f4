use super::{
    BuildingRow, Carriageway, DesignError, building_row,
    layout::{Layout, MAX_FAULTS},
    lights_and_signs,
    network::Network,
    surface::Surfaces,
};
use crate::TownParts;
use crate::geometry::{OrientedBox, Point};

/// The farthest a node may lie from the origin along either axis (m).
const REACH: f64 = 10_000.0;

/// A town as a scenario describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct TownDesign {
    pub name: String,
    /// The places where streets start, end, bend and meet.
    pub nodes: Vec<Node>,
    pub streets: Vec<Street>,
    /// Houses, walls and the like.
    pub buildings: Vec<OrientedBox>,
    /// The cross-section of every street.
    pub profile: StreetProfile,
    /// The radius of the middle of a street where it bends (m).
    pub bend_radius: f64,
    /// The radius of the sidewalk's outer edge around the corner of a junction (m).
    pub corner_radius: f64,
    /// The least distance from a junction's node at which roads end (m).
    pub junction_radius: f64,
    /// Whether opposite legs of a junction have green together; otherwise each leg has its own turn.
    pub opposite_lights: bool,
    /// Houses along all streets.
    pub block_buildings: Option<BuildingRow>,
}

/// A place where streets start, end, bend or meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    pub name: String,
    /// Where the middles of its streets meet.
    pub position: Point,
    /// Whether traffic lights stand on every approach; only for junctions.
    pub lights: bool,
}

/// A street along straight lines between nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Street {
    pub name: String,
    /// The nodes it passes, as indices into [`TownDesign::nodes`]; a closed street ends with its first node.
    pub nodes: Vec<usize>,
    /// The limit on its speed signs (m/s); without it there are no signs.
    pub speed_limit: Option<f64>,
    /// Its driving lanes.
    pub carriageway: Carriageway,
}

/// The widths of a street's parts: driving lanes, and on either side of them a shoulder and a sidewalk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreetProfile {
    /// Width of a driving lane (m).
    pub lane_width: f64,
    /// Width of a shoulder (m).
    pub shoulder: f64,
    /// Width of a sidewalk (m).
    pub sidewalk: f64,
}

impl Default for StreetProfile {
    /// The cross-section of the streets in CARLA's Town01 and Town02.
    fn default() -> Self {
        Self { lane_width: 4.0, shoulder: 0.3, sidewalk: 4.0 }
    }
}

impl Default for TownDesign {
    /// An empty town with the usual measures.
    fn default() -> Self {
        Self {
            name: String::new(),
            nodes: Vec::new(),
            streets: Vec::new(),
            buildings: Vec::new(),
            profile: StreetProfile::default(),
            bend_radius: 12.0,
            corner_radius: 2.0,
            junction_radius: 6.0,
            opposite_lights: false,
            block_buildings: None,
        }
    }
}

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
