use std::sync::Arc;

use super::input::map_writer;
use world::av::external::{Opener, Program, ProgramKeys};
use world::env::ExternalWorld;

/// Starts a bridge of the Python package.
const PYTHON: &str = "python3 -m falsify_av.bridges";

/// The world of a bridge: of the Python package if it is a name, or a command. It has these times for a tick, and for a greeting or a town (s).
///
/// # Errors
/// The reason why it cannot be used, as a part of a sentence.
pub fn external_world(
    name: &str,
    opener: Arc<dyn Opener>,
    (timeout, start_timeout): (f64, f64),
) -> Result<ExternalWorld, String> {
    let is_name = name.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
    let command = if is_name { format!("{PYTHON} {name}") } else { name.to_string() };
    let program = Program::parse(&command, ".".into())?;
    opener.find(&program)?;
    let keys = ProgramKeys { command, files: None, version: None, timeout, start_timeout };
    ExternalWorld::new(program, &keys, opener, map_writer()).map_err(|fault| format!("it {fault}"))
}
