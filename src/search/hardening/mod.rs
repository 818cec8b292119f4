//! From a driver's failures to a better driver: rounds of attack and repair.
//!
//! A round *attacks*: falsifiers search for faults of the driver as it is now. Their failures (start and commands) and the pedestrians that they end
//! up with are kept. Then it *repairs*: it searches the keys of the driver for fewer starts with a fault in all that is kept, and in natural traffic,
//! while the driver stays nearly as fast and brakes hard nearly as seldom as before. At the end the driver as it was and as it has become meet starts and
//! pedestrians that no round has used.
//!
//! What is repaired is anything whose keys are numbers ([`Tunable`]). A driver that learns by a training of its own would take the place of the
//! private module `repair`, and meet the same attacks and tests.

mod traffic_rule;
mod tunable;
mod plan;
mod repair;
mod tested;
mod rounds;

#[cfg(test)]
mod tests;

pub use plan::{Attack, Hardening};
pub use rounds::{Hardened, Round, harden};
pub use tested::Tested;
pub use traffic_rule::TrafficRule;
pub use tunable::{Side, Tunable, TunableKey};
