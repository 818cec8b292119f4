//! InterFuser as a car under test: its planner and controller as published, with the ideal output of its network in place of the
//! network.
//!
//! Ten times a second the ideal `object_map` is drawn around the ego, `detection` finds the road users in it, the `tracker`
//! corrects (or worsens) their speeds, and the `forecast` draws where they will be. Twenty times a second the `controller`
//! moves the ego along a `corridor` through these drawings and decides. Every second decision is carried out, and held
//! for a tick.
//!
//! This folder uses InterFuser's frames: [`EgoVector`] is (right, back) of the ego in metres, headings are half turns with 0
//! to the right and 0.5 towards the ego, and steer is positive to the right.
//!
//! # Source
//! `opendilab/InterFuser` at 14ca80e, `leaderboard/team_code` and `interfuser/timm/data`.

mod settings;
mod image;
mod object_map;
mod detection;
mod tracker;
mod forecast;
mod corridor;
mod pid;
mod controller;
mod driver;
mod kind;

pub use controller::{Controller, Counters, Decision, Inputs, Reason};
pub use corridor::WAYPOINTS;
pub use detection::{ObjectClass, find_detections};
pub use driver::InterFuser;
pub use forecast::{Forecast, HORIZONS};
pub use object_map::{Cell, ObjectMap, Sighting};
pub use settings::Settings;
pub use tracker::Tracker;

/// A place or a displacement in the ego's frame: metres to the right and to the back.
pub type EgoVector = road::geometry::Vector;
