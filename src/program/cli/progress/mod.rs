//! Progress for people and programs: bars on a terminal, a line for each finished job in a log, events as JSON.

mod showing;
mod learnt;
mod job;
mod board;
mod bars;
mod event_line;
mod follow;
mod counting;
mod heartbeat;

pub use counting::Counting;
pub use event_line::EventLine;
pub use follow::Progress;
pub use heartbeat::heartbeat;
pub use learnt::Learnt;
pub use showing::Showing;
