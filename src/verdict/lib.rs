//! Was a failure avoidable? Repeats each failure with reference drivers that control the brake.
//!
//! It works on the [`Pair`](episode::Pair) of the ego and the pedestrian that it struck.
//!
//! 1. The traced episode is rewound to the start of the danger ([`Encounter`]). This is the first instant of the unbroken approach
//!    before the touch at which two things are true: the pedestrian can be seen, and it is in, or moves towards, the path that the
//!    car is going to sweep. A pedestrian that turned away for longer than a second ended an earlier approach. From then on the
//!    reference drivers know where it is. A car that has stood for half a second since then is judged from the instant at which it
//!    drove off.
//! 2. From there the car follows the path that it drove, and straight on beyond its end. Another driver has a brake of its own
//!    ([`Trial`]). Until that driver brakes, its car is the recorded one. From then on it has the speed of the recorded car or the one to which
//!    its driver would have braked from the fastest speed since it noticed the pedestrian, whichever is less, and never gains speed. So a
//!    driver that brakes as early and as hard as the reference is the reference, and what a driver braked is not added to what the reference
//!    brakes.
//! 3. The pedestrian is *frozen*: it is where it was at each time, and continues with its last command after the recorded touch,
//!    for 5 s at most. It does not react to the other driver; how a pedestrian would react is not measured.
//! 4. A driver *avoids* the failure when the car does not touch the pedestrian while the car moves. A pedestrian that then walks
//!    into the standing car, or comes from behind, is not counted.
//! 5. A collision that all careful drivers avoid, both careful humans and the Fuzzy Safety Model, is *preventable*. It is a *fault* ([`Class`]) if the pedestrian moved as people do and was hit
//!    by the front or driven into, at walking pace or more, both humans have 0.1 m to spare, and no car that follows runs into them ([`Follower`]).
//!
//! [`judge`] runs all drivers, an [`Inquiry`] those that are asked for. Both are pure functions of a recording. A [`Judged`] episode has its outcome,
//! the verdict on its touch and those on the violations of requirements.
//!
//! [`ViolationVerdict`] asks the careful drivers about a requirement that is violated.
//!
//! A [`Recording`] holds an encounter from another simulator, or from a road, and has the same verdicts.
//!
//! [`FalseAlarms`] asks the same drivers about episodes that ended well. [`NearMiss`] measures how near any episode came to a touch, [`LaneDeparture`] whether the car stayed in its lane, and [`PedestrianMotion`] whether the pedestrian moved as people do.
//!
//! [`cause`] runs a failure again with one thing changed, [`natural_traffic`] counts faults among pedestrians who walk as people do, and a
//! [`Price`] is what a driver gives for safety.
//!
//! The labels are explained at [`Label`], the drivers at [`Reference`]. Reference drivers brake with their own parameters, as far as
//! the car's brake and the road allow.

mod driven_path;
mod sight;
mod encounter;
mod recording_error;
mod recording_noise;
mod reference;
mod trial;
mod foreseeable;
mod contact_side;
mod reaction;
mod severity;
mod class;
mod false_alarms;
mod follower;
mod verdict;
mod published;
mod sensitivity;
mod inquiry;
mod violation;
mod judged;
mod near_miss;
mod lane_departure;
mod oracle;
mod recording_units;
mod recording_findings;
mod recording;
mod recording_file;
mod recorded_scene;
mod traffic;
mod price;
mod classification_tree;
pub mod cause;
#[cfg(test)]
mod tests;

pub use class::{CLEAR, Class, WALKING_PACE};
pub use contact_side::ContactSide;
pub use driven_path::{DrivenPath, Place};
pub use encounter::{Encounter, Step};
pub use false_alarms::FalseAlarms;
pub use follower::Follower;
pub use foreseeable::PedestrianMotion;
pub use inquiry::{Inquiry, judge};
pub use judged::{Blame, Judged, JudgedDegree};
pub use lane_departure::LaneDeparture;
pub use near_miss::NearMiss;
pub use oracle::ReferenceOracle;
pub use price::Price;
pub use published::{Answer, Published};
pub use reaction::share_of_drivers;
pub use recorded_scene::{Meeting, NamedMeeting, RecordedActor, RecordedScene};
pub use recording::{Encountered, RecordedRequirement, Recording, Sizes};
pub use recording_error::{InstantFault, RecordingError};
pub use recording_file::{HeadingUnit, RecordingFileError, Units};
pub use recording_findings::{Damage, Finding};
pub use reference::Reference;
pub use sensitivity::Sensitivity;
pub use severity::severe_injury_risk;
pub use sight::Sight;
pub use traffic::{Drive, Traffic, drives, natural_traffic};
pub use trial::Trial;
pub use verdict::{Label, RestsOn, Verdict};
pub use violation::{NoVerdict, ViolationVerdict};
