use std::sync::Arc;

use super::input::map_writer;
use compile::{BRIDGES, bridge_command};
use episode::ExternalWorld;
use world::av::external::{Opener, Program, ProgramKeys};

/// The world of a bridge: a name of the Python package with options, or a command. It has these times for a tick, and for a greeting or a town (s).
///
/// # Errors
/// The reason why it cannot be used, as a part of a sentence.
pub fn external_world(
    name: &str,
    opener: Arc<dyn Opener>,
    (timeout, start_timeout): (f64, f64),
) -> Result<ExternalWorld, String> {
    let command = bridge_command(name);
    let program = Program::parse(&command, ".".into())?;
    opener.find(&program).map_err(|reason| {
        let names = BRIDGES.join(", ");
        if name.split_whitespace().count() == 1 {
            format!("{reason}; the bridges of the Python package are {names}")
        } else {
            reason
        }
    })?;
    let keys = ProgramKeys { command, files: None, version: None, timeout, start_timeout };
    ExternalWorld::new(program, &keys, opener, map_writer()).map_err(|fault| format!("it {fault}"))
}
