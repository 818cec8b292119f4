//! The language server: it answers an editor's requests about scenario files over the language server protocol.
//!
//! Messages are handled one after the other, in the order of their arrival, without threads. Every message comes from the same
//! compiler, signatures and layout as on the command line. The context of the cursor is found by reading the text up to it
//! (`cursor`), not from the tree: a file that is being written seldom has one.

mod wire;
mod client;
mod documents;
mod workspace;
mod cursor;
mod visible;
mod complete;
mod hover;
mod navigate;
mod references;
mod server;

pub use server::{Ending, serve};
pub use wire::WireError;
