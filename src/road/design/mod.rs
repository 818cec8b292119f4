//! Towns that a scenario describes itself: nodes, streets between them, and houses along the streets.
//!
//! A street becomes one straight road between each two of its nodes. Where two streets meet, the roads are joined by an
//! arc; where three or four meet, they are cut back and joined by a junction with one connecting road for every way
//! of a lane through it. All reference lines run along the middle of the street. The reference line of a connecting road is tangent to the
//! middles of both streets; its lane offset leads from the left edge of the lane before it to that of the lane after it.

mod carriageway;
mod town_design;
mod error;
mod fast_bend;
mod layout;
mod corner;
mod turning_lanes;
mod network;
mod surface;
mod lights_and_signs;
mod building_row;
mod built;

pub use carriageway::{Carriageway, StreetProfile};
pub use error::DesignError;
pub use fast_bend::FastBend;
pub use town_design::{BuildingRow, Node, Street, TownDesign};
