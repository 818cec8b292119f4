//! A driver in a separate program, in any language: it receives its view as messages and answers with controls.
//!
//! ```text
//! External ──┐ prepare:  adds its world to the request
//! External ──┤                                            Session ── Link ──> the program
//! External ──┘ drive: takes its answer; the first one     (handshake, encoding,     (pipes, deadlines:
//!              sends the request                           restart after a fault)    given from above)
//! ```
//! The protocol is described in `scenarios/external/README.md`. Nothing here starts a process or reads a clock: a [`Link`]
//! does both, and an [`Opener`] makes the link. A [`Peer`] keeps the link of a program, also for programs that are not drivers.

mod link;
mod peer;
mod program;
mod message;
mod refusal;
mod binary;
mod session;
mod driver;

pub use driver::{External, ExternalKeys};
pub use link::{Link, Opener};
pub use message::Body;
pub use message::PROTOCOL;
pub use peer::Peer;
pub use program::{Program, ProgramKeys};
pub use refusal::{ID, KeyOf, Keyed, answer_refusal, greeting_refusal};
pub use session::Settings;
