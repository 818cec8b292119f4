//! Towns from above.

mod scenery;
mod town_map;

pub use scenery::{Scenery, Surface};
pub use town_map::{Starts, spawn_map, town_map};
