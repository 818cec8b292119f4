//! Was it avoidable? Runs each failure again with reference drivers at the pedal.
//!
//! 1. The recorded episode is rewound to where the danger began ([`Encounter`]): the first instant of the unbroken approach that
//!    ends in the touch at which the pedestrian can be seen and is in, or moves towards, the path that the car is going to
//!    sweep. A pedestrian that turned away for longer than a second ended an earlier approach.
//!    From then on the reference drivers know where it is.
//! 2. From there the car keeps to the path that it drove, and straight on beyond its end, but another driver decides about
//!    the brake ([`Trial`]). Until that driver interferes the car drives as fast as it has been in the recording since then: it
//!    may pull away as the recorded car did, but it does not inherit its braking. Once it has interfered it never accelerates.
//! 3. The pedestrian is *frozen*: it is where it was at each time, and goes on with its last command after the recorded touch,
//!    for five seconds at most. It does not react to the other driver; how much an adversary would is not measured.
//! 4. A driver *avoids* the failure when the car touches nobody while it moves. Who then walks into the standing car is not
//!    counted, nor who comes from behind.
//!
//! Episodes of all kinds are measured for how near they came to a touch ([`NearMiss`]).
//!
//! The labels are explained at [`Label`], the drivers at [`Reference`]. Reference drivers brake as their figures say, whatever
//! the car's own brake can do.

mod driven_path;
mod sight;
mod encounter;
mod reference;
mod trial;
mod verdict;
mod near_miss;
#[cfg(test)]
mod tests;

pub use driven_path::{DrivenPath, Place};
pub use encounter::{Encounter, Step};
pub use near_miss::NearMiss;
pub use reference::Reference;
pub use sight::Sight;
pub use trial::Trial;
pub use verdict::{Label, Verdict, judge};
