//! What an editor asks about scenario files, answered over the language server protocol.
//!
//! One message after the other, in the order they come: no threads, no waiting. Every message comes from the same
//! compiler, signatures and layout as on the command line. The place of the cursor is found by reading the text up to it
//! (`cursor`), not from the tree, since a file that is being written seldom has one.

mod wire;
mod documents;
mod cursor;
mod visible;
mod complete;
mod hover;
mod navigate;
mod server;

pub use server::{Ending, serve};
pub use wire::WireError;
