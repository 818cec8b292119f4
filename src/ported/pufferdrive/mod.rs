//! PufferDrive's demo policy: its weights, run on what its own simulator would observe.
//!
//! # Source
//! `Emerge-Lab/Adaptive_Driving_Agent` at 28a233c, `pufferlib/ocean/drive` and `pufferlib/extensions/puffernet.h`.

mod road_map;
mod observation;
mod network;
mod driver;

pub use driver::{Pedestrians, PufferDrive, PufferDriveKeys, action, control};
pub use network::{BLAKE3, Network, ORIGIN};
pub use observation::Observation;
pub use road_map::{Polyline, RoadMap, polylines};
