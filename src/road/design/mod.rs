//! Towns that a scenario describes itself: nodes, streets between them, and houses along the streets.
//!
//! A street becomes one straight road between each two of its nodes. Where two streets meet, the roads are joined by an
//! arc; where three or four meet, they are cut back and joined by a junction with one connecting road for every way
//! through it. All reference lines run along the middle of the street, so that the left edge of a connecting road's only
//! driving lane is an arc which is tangent to the middles of both streets.

mod town_design;
mod error;
mod layout;
mod corner;
mod network;
mod surface;
mod lights_and_signs;
mod building_row;

pub use building_row::BuildingRow;
pub use error::DesignError;
pub use town_design::{Node, Street, StreetProfile, TownDesign};

#[cfg(test)]
mod tests;
