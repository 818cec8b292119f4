//! Progress for people and programs: bars on a terminal, a line for each finished job in a log, events as JSON.

mod showing;
mod learnt;
mod job;
mod board;
mod bars;
mod lines;
mod events;
mod observer;

pub use events::Event;
pub use learnt::Learnt;
pub use observer::Progress;
pub use showing::Showing;
