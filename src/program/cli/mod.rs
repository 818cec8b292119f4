//! The command line: arguments, commands, progress, exit codes.

mod args;
mod exit_code;
mod console;
mod crash;
mod failure;
mod input;
mod output;
mod interrupt;
mod progress;
mod settings;
mod config;
mod run;
mod ending;
mod shard;
mod merge;
mod status;
mod list;
mod stored;
mod choice;
mod condition;
mod gate;
mod episode;
mod replay;
mod export;
mod verify;
mod failures;
mod judge;
mod compare;
mod recheck;
mod check;
mod sample;
mod fix;
mod fmt;
mod explain;
mod new;
mod demo;
mod welcome;
mod manual;
mod debug;
mod lsp;
mod map;
mod preview;
mod driver_trial;
mod empty_road;
mod network_trial;

pub use args::Arguments;
use exit_code::Ended;
pub use exit_code::ExitCode;
#[cfg(any(fuzzing, test))]
pub use settings::is_read as settings_are_read;
pub use settings::settings;

use std::ffi::OsString;

use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};

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
    if matches!(code, ExitCode::Done) && console::lost() {
        console::fail("the output cannot be written");
        return ExitCode::WriteFailed;
    }
    code
}

fn run_command(given: &[OsString]) -> Ended {
    let mut known = args::command();
    let (mut arguments, mut matches) = parse(&mut known, given)?;
    arguments.color.apply();
    let mut settings = None;
    if matches.subcommand_name().is_some_and(|name| settings::concern(&known, name)) {
        settings = std::env::current_dir().map_or(Ok(None), |folder| settings::find(&folder))?;
        if let Some(settings) = &settings {
            (arguments, matches) = parse(&mut settings::apply(args::command(), settings), given)?;
        }
    }
    // Frees the memory of the known options, which is needed soon.
    drop(known);
    // These may have started programs, which must not outlive them. Others with programs have handlers of their own.
    if let args::Command::Replay(_)
    | args::Command::Export(_)
    | args::Command::Verify(_)
    | args::Command::Compare(_)
    | args::Command::Recheck(_) = arguments.command
    {
        interrupt::end_when_asked();
    }
    match arguments.command {
        args::Command::Config => {
            let (_, options) = matches.subcommand().expect("it is the command `config`");
            config::config(options, settings.as_ref());
            Ok(ExitCode::Done)
        }
        args::Command::Run(options) => run::run(&options),
        args::Command::Status(options) => status::status(&options),
        args::Command::Merge(options) => merge::merge(&options),
        args::Command::Replay(options) => replay::replay(&options),
        args::Command::Export(options) => export::export(&options),
        args::Command::Verify(options) => verify::verify(&options),
        args::Command::Compare(options) => compare::compare(&options),
        args::Command::Recheck(options) => recheck::recheck(&options),
        args::Command::Failures(options) => failures::failures(&options),
        args::Command::Judge(options) => judge::judge(&options),
        args::Command::Check(options) => check::check(&options),
        args::Command::Explain(options) => explain::explain(&options),
        args::Command::New(options) => new::new(&options),
        args::Command::Demo(options) => demo::demo(&options),
        args::Command::Debug(options) => debug::debug(&options),
        args::Command::Lsp { .. } => lsp::lsp(),
        args::Command::Fmt(options) => fmt::fmt(&options),
        args::Command::Preview(options) => preview::preview(&options),
        args::Command::Manual(options) => manual::manual(&options),
        args::Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "falsify", &mut script);
            console::say(String::from_utf8_lossy(&script).trim_end());
            Ok(ExitCode::Done)
        }
    }
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
