//! The command `falsify`: sessions, the command line and the language server.

pub mod exit_code;
pub mod session;
pub mod lsp;
pub mod cli;
pub mod commands;
