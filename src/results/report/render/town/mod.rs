//! Towns from above.

mod scenery;
mod town_map;
mod map_surfaces;
mod map_page;

pub use map_page::{MapPage, StartLayer, TownView, map_page};
pub use scenery::{Scenery, Surface};
pub use town_map::{Starts, spawn_map, town_map};
