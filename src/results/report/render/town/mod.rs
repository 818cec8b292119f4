//! Towns from above.

mod scenery;
mod town_map;
mod labelled_map;
mod map_page;

pub use labelled_map::labelled_map;
pub use map_page::{MapPage, StartLayer, TownView, map_page};
pub use scenery::{Scenery, Surface};
pub use town_map::{Starts, spawn_map, town_map};
