use super::carriageway::{Carriageway, StreetProfile};
use crate::geometry::{OrientedBox, Point};
use base::keys;

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

keys! {
    /// Houses along both sides of all straight streets.
    #[derive(Copy)]
    pub struct BuildingRow = "row_houses" {
        /// Distance of the fronts from the sidewalk.
        setback: f64 as within(LENGTH, 0.0, 1000.0) = "1 m",
        /// Extent away from the street.
        depth: f64 as within(LENGTH, 1.0, 1000.0) = "10 m",
        /// Extent along the street.
        length: f64 as within(LENGTH, 3.0, 1000.0) = "16 m",
        /// Distance between two houses.
        gap: f64 as within(LENGTH, 0.0, 1000.0) = "4 m",
    }
}
