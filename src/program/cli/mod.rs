//! What all commands share: input, output, progress, settings, exit codes.

pub(crate) mod exit_code;
pub(crate) mod console;
mod crash;
pub(crate) mod failure;
pub(crate) mod input;
pub(crate) mod output;
pub(crate) mod interrupt;
pub(crate) mod progress;
pub(crate) mod settings;
pub(crate) mod choice;
mod welcome;
pub(crate) mod network_trial;

pub use exit_code::ExitCode;
#[cfg(any(fuzzing, test))]
pub use settings::is_read as settings_are_read;
pub use settings::settings;

use std::ffi::OsString;

use clap::{ArgMatches, Command, FromArgMatches};

use crate::commands::{self, Arguments};
use compile::Catalog;
use exit_code::Ended;

/// Runs the program with this language. The first argument is the name of the program. A bug ends in [`ExitCode::Internal`].
pub fn command_line(language: fn() -> Catalog, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    crash::listen();
    input::speak(language);
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let code = std::panic::catch_unwind(|| run_command(&arguments).unwrap_or_else(|code| code)).unwrap_or_else(|_| {
        console::fail("this is a bug in falsify; what was finished before is not lost");
        ExitCode::Internal
    });
    if matches!(code, ExitCode::Done) && console::lost() {
        console::fail("the output cannot be written");
        return ExitCode::WriteFailed;
    }
    code
}

fn run_command(given: &[OsString]) -> Ended {
    let mut known = commands::command();
    let (mut arguments, mut matches) = parse(&mut known, given)?;
    arguments.color.apply();
    let mut settings = None;
    if matches.subcommand_name().is_some_and(|name| settings::concern(&known, name)) {
        settings = std::env::current_dir().map_or(Ok(None), |folder| settings::find(&folder))?;
        if let Some(settings) = &settings {
            (arguments, matches) = parse(&mut settings::apply(commands::command(), settings), given)?;
        }
    }
    // Frees the memory of the known options, which is needed soon.
    drop(known);
    arguments.command.run(&matches, settings.as_ref())
}

/// Reads arguments; the error is the exit code, after the reason has been printed.
fn parse(command: &mut Command, given: &[OsString]) -> Result<(Arguments, ArgMatches), ExitCode> {
    let parsed = command.try_get_matches_from_mut(given);
    let parsed = parsed.and_then(|matches| Ok((Arguments::from_arg_matches(&matches)?, matches)));
    parsed.map_err(|error| {
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
