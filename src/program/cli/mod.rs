//! What all commands share: input, output, progress, settings, exit codes.

pub(crate) mod console;
mod crash;
pub(crate) mod failure;
pub(crate) mod external_world;
pub(crate) mod input;
pub(crate) mod output;
pub(crate) mod interrupt;
pub(crate) mod progress;
pub(crate) mod settings;
pub(crate) mod choice;
mod welcome;
pub(crate) mod network_trial;

pub use crate::exit_code::ExitCode;
pub use settings::is_read as settings_are_read;

use std::ffi::OsString;

use clap::{ArgMatches, Command, FromArgMatches};

use crate::commands::{self, Arguments};
use crate::exit_code::Ended;
use compile::Catalog;

/// Runs the program with this language. The first argument is the name of the program. A bug ends in [`ExitCode::Internal`].
pub fn command_line(language: fn() -> Catalog, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    crash::listen();
    input::speak(language);
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let code = std::panic::catch_unwind(|| run_command(&arguments).unwrap_or_else(|code| code)).unwrap_or_else(|_| {
        console::fail("this is a bug in falsify; what was finished before is not lost");
        ExitCode::Internal
    });
    process::end_all();
    if matches!(code, ExitCode::Done) && console::lost() {
        console::fail("the output cannot be written");
        return ExitCode::WriteFailed;
    }
    code
}

fn run_command(given: &[OsString]) -> Ended {
    if given.get(1).is_some_and(|word| word == network_trial::WORD) {
        return Ok(network_trial::carry_out());
    }
    let mut command = commands::command();
    let (name, mut arguments) = parse(&mut command, given)?;
    arguments.color.apply();
    if settings::concern(&command, &name) {
        let settings = std::env::current_dir().map_or(Ok(None), |folder| settings::find(&folder))?;
        if let Some(settings) = &settings {
            (_, arguments) = parse(&mut settings::apply(commands::command(), settings), given)?;
        }
    }
    // Frees the memory of the options, which is needed soon.
    drop(command);
    arguments.command.run()
}

/// Reads arguments and the name of their command; the error is the exit code, after the reason has been printed.
fn parse(command: &mut Command, given: &[OsString]) -> Result<(String, Arguments), ExitCode> {
    let read = |matches: ArgMatches| {
        let name = matches.subcommand_name().unwrap_or_default().to_owned();
        Ok((name, Arguments::from_arg_matches(&matches)?))
    };
    command.try_get_matches_from_mut(given).and_then(read).map_err(|error| {
        if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand && given.len() < 2 {
            console::note(welcome::WELCOME);
            return ExitCode::Usage;
        }
        // Help and version are not errors.
        let code = if error.use_stderr() { ExitCode::Usage } else { ExitCode::Done };
        let _ = error.print();
        code
    })
}
