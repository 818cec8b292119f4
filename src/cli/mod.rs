//! The command line: arguments, commands, progress, exit codes.

mod args;
mod repeat_args;
mod exit_code;
mod front;
mod interrupt;
mod progress;
mod run;
mod list;
mod cells;
mod gate;
mod repeat;
mod replay;
mod render;
mod verify;
mod check;
mod beginnings;
mod fmt;
mod explain;
mod new;
mod debug;
mod lsp;
mod map;
mod av_check;

pub use args::Arguments;
pub use exit_code::ExitCode;

use clap::{CommandFactory, Parser};

/// Runs the program with the arguments of the process. A bug ends in [`ExitCode::Internal`].
pub fn main() -> ExitCode {
    let code = std::panic::catch_unwind(run_command).unwrap_or_else(|_| {
        front::fail("this is a bug in falsify; what was finished before is not lost");
        ExitCode::Internal
    });
    if matches!(code, ExitCode::Done) && front::lost() {
        front::fail("the output cannot be written");
        return ExitCode::WriteFailed;
    }
    code
}

fn run_command() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are no mistakes.
            let code = if error.use_stderr() { ExitCode::Usage } else { ExitCode::Done };
            let _ = error.print();
            return code;
        }
    };
    arguments.color.apply();
    match arguments.command {
        args::Command::Run(options) => run::run(&options),
        args::Command::Replay(options) => replay::replay(&options),
        args::Command::Render(options) => render::render(&options),
        args::Command::Verify(options) => verify::verify(&options),
        args::Command::Cells(options) => cells::cells(&options),
        args::Command::Check(options) => check::check(&options),
        args::Command::Explain(options) => explain::explain(&options),
        args::Command::New(options) => new::new(&options),
        args::Command::Debug(options) => debug::debug(&options),
        args::Command::Lsp { .. } => lsp::lsp(),
        args::Command::Fmt(options) => fmt::fmt(&options),
        args::Command::Map(options) => map::map(&options),
        args::Command::Av(args::AvCommand::Check(options)) => av_check::check(&options),
        args::Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "falsify", &mut script);
            front::say(String::from_utf8_lossy(&script).trim_end());
            ExitCode::Done
        }
    }
}
