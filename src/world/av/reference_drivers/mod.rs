//! Reference drivers: published rules for when a car must brake for a pedestrian in its way, as baselines for a car under test.
//!
//! They decide about the brake, along a given path, from a [`Threat`] in the frame of that path. A failure
//! can therefore be run again with each of them, and a driving policy can be built around one.
//!
//! | driver | from | brakes |
//! |---|---|---|
//! | [`DelayedBrake::careful_human`] | UN R157, competent and careful human | 1.15 s after the gate, in 0.6 s to 0.774 g |
//! | [`DelayedBrake::attentive_human`] | the same, whose risk evaluation is over when the gate opens | 0.75 s after the gate |
//! | [`FuzzySafety`] | JRC's Fuzzy Safety Model | as hard as the distance is unsafe, to 6 m/s² |
//! | [`Rss`] | ad-rss-lib, unstructured rule | 4 m/s² when both could not stop apart, unless the other was to stop |
//! | [`CutInBrake`] | JRC's human, system and RSS in lanes | when bodies are beside each other, or nearly |
//! | [`AlksHuman`] | `esmini`'s human for pedestrians | 1.15 s after a pedestrian moves towards the path |
//! | [`DelayedBrake::ideal`] | our choice | 0.35 s after the gate, in 0.6 s to 0.85 g |
//! | [`DelayedBrake::bound`] | physics | at once when a pedestrian moves towards the path, 0.85 g |
//!
//! The *gate* opens when the pedestrian is on course into the path ([`Threat::is_on_course`]) and the time to collision is short enough
//! ([`Gate::opens`]).
//! A driver without a gate stops for all who come near the road, and so avoids whatever it is asked about.
//!
//! UN R157 is written for roads without pedestrians, so every use for pedestrians is an extrapolation. Show the figures next
//! to the verdict.
//!
//! # Source
//! UN R157, annex 4 appendix 3; `ec-jrc/JRC-FSM`; `esmini`, controller `ALKS_R157SM`; Shalev-Shwartz et al., arXiv 1708.06374;
//! `intel/ad-rss-lib` and CARLA's `RssCheck`.

mod threat;
mod brake_profile;
mod delayed_brake;
mod fuzzy_safety;
mod rss_limits;
mod rss;
mod cut_in_brake;
mod alks_human;

pub use alks_human::AlksHuman;
pub use brake_profile::BrakeProfile;
pub use cut_in_brake::{CutIn, CutInBrake};
pub use delayed_brake::{DelayedBrake, Gate};
pub use fuzzy_safety::FuzzySafety;
pub use rss::Rss;
pub use rss_limits::{RssLimits, lateral_distance, longitudinal_distance};
pub use threat::{OwnMotion, ReferenceDriver, Threat};

/// Gravity (m/s²) in the regulations.
const GRAVITY: f64 = 9.81;
