//! The commands of the program: one file each, with its arguments, its help and its work.

mod causes;
mod condition;
mod episode;
mod starts;
mod run;
mod merge;
mod status;
mod replay;
mod shrink;
mod export;
mod failures;
mod judge;
mod compare;
mod recheck;
mod fmt;
mod check;
mod explain;
mod new;
mod demo;
mod lsp;
mod preview;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, CommandFactory, Parser, Subcommand, ValueEnum};

use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
pub use failures::{FailuresArgs, FoundFailure};
pub use replay::{Replay, ReplayAllOptions, ReplayOptions, ReplayedReport, Retrained};
pub use run::RunArgs;

const EXAMPLES: &str = "\
Examples:
  falsify demo                               a first result without any file
  falsify new my.scn                         start from a commented file
  falsify check my.scn                       find mistakes without running anything
  falsify run my.scn                         run its campaigns, reports go to reports/
  falsify failures                           list the failures of reports/, the worst first
  falsify replay 1a2b3c4d:17                 see a failure again
  falsify export 1a2b3c4d:17 --as animation  draw it
  falsify export 1a2b3c4d:17 --as xosc-1.3   the failure for another simulator
  falsify explain missing-unit               what a message means

Exit codes:
  0 done   1 internal error   2 wrong usage or missing file   3 errors in a scenario
  4 nothing to run   5 a run or a driver failed   6 a report cannot be written   7 a --fail-if condition is true
  8 a repetition differs from its report   9 tasks to merge are missing   130 stopped by Ctrl-C or SIGTERM";

/// Finds collisions of a self-driving car with a pedestrian that a careful human avoids.
#[derive(Debug, Parser)]
#[command(name = "falsify", version, after_help = EXAMPLES, max_term_width = 100)]
pub struct Arguments {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
    /// When to colour the output.
    #[arg(long, global = true, value_enum, default_value_t = Colouring::Auto, value_name = "WHEN")]
    pub color: Colouring,
}

/// The commands as the help lists them.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Write a scenario", &["new", "check", "explain", "fmt", "preview"]),
    ("Run it", &["demo", "run", "status", "merge"]),
    ("Look at what was found", &["failures", "shrink", "replay", "compare", "recheck", "judge"]),
    ("Export", &["export"]),
    ("For editors and shells", &["lsp", "completions"]),
];

/// The commands and options, with a help that lists the commands in groups.
pub fn command() -> clap::Command {
    let command = Arguments::command();
    let heading = *command.get_styles().get_header();
    let literal = *command.get_styles().get_literal();
    let mut help = "{about-with-newline}\n{usage-heading} {usage}\n".to_owned();
    for (group, names) in GROUPS {
        help.push_str(&format!("\n{heading}{group}:{heading:#}\n"));
        for name in names {
            let about = command.find_subcommand(name).and_then(clap::Command::get_about).expect("it is a command");
            help.push_str(&format!("  {literal}{name:12}{literal:#}{about}\n"));
        }
    }
    help.push_str(&format!("\n{heading}Options:{heading:#}\n{{options}}{{after-help}}"));
    command.help_template(help)
}

/// The commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run campaigns: train pedestrians, evaluate them, search for failures, write reports.
    #[command(after_help = run::EXAMPLES, disable_help_flag = true)]
    Run(Box<run::RunArgs>),
    /// Merge the work of the shards of a run, and write its reports.
    #[command(after_help = merge::EXAMPLES, disable_help_flag = true)]
    Merge(Box<merge::MergeArgs>),
    /// Show how far campaigns are and how to go on; show and remove what is stored.
    #[command(after_help = status::EXAMPLES)]
    Status(status::StatusArgs),
    /// Repeat episodes of a report, describe them, and compare them with the report; --all repeats the whole report.
    #[command(after_help = replay::EXAMPLES)]
    Replay(replay::ReplayArgs),
    /// Write episodes for other programs (OpenSCENARIO, OSI, CARLA …), or draw them.
    #[command(after_help = export::EXAMPLES)]
    Export(export::ExportArgs),
    /// Compare two reports, or two drivers of one, start by start.
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::CompareArgs),
    /// Let a new version of a driver meet old failures again, and a fixed list of episodes.
    #[command(after_help = recheck::EXAMPLES)]
    Recheck(recheck::RecheckArgs),
    /// List failures, those that count most against a driver first, baselines last.
    #[command(after_help = failures::EXAMPLES)]
    Failures(failures::FailuresArgs),
    /// Shrink failures: the same failure with the fewest commands of the pedestrian, nearest to a natural walk.
    #[command(after_help = shrink::EXAMPLES)]
    Shrink(shrink::ShrinkArgs),
    /// Judge a collision recorded elsewhere: would a careful driver have avoided it?
    #[command(after_help = judge::EXAMPLES)]
    Judge(judge::JudgeArgs),
    /// Find mistakes in files without running anything; try a driver of your own.
    #[command(after_help = check::EXAMPLES)]
    Check(check::CheckArgs),
    /// Explain a diagnostic, a form, a kind or a key of the language.
    #[command(after_help = explain::EXAMPLES)]
    Explain(explain::ExplainArgs),
    /// Run the scenario inside the program: a first result without any file.
    #[command(after_help = demo::EXAMPLES)]
    Demo(demo::DemoArgs),
    /// Write a commented scenario to start from.
    #[command(after_help = new::EXAMPLES)]
    New(new::NewArgs),
    /// Give scenario files their canonical layout.
    #[command(after_help = fmt::EXAMPLES)]
    Fmt(fmt::FmtArgs),
    /// Show a scenario or a map on a page that follows the file while you edit it.
    #[command(after_help = preview::EXAMPLES)]
    Preview(preview::PreviewArgs),
    /// Serve an editor by the language server protocol on the standard streams.
    #[command(after_help = lsp::EXAMPLES)]
    Lsp {
        /// Accepted because many editors pass it; the standard streams are the only way.
        #[arg(long)]
        stdio: bool,
    },
    /// Print a completion script for a shell.
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// The exit code of a failure whose message is printed.
    pub fn run(self) -> Ended {
        // These may have started programs, which must not outlive them. Others with programs have handlers of their own.
        if let Self::Replay(_) | Self::Shrink(_) | Self::Failures(_) | Self::Export(_) | Self::Compare(_) = self {
            interrupt::end_when_asked();
        }
        match self {
            Self::Run(options) => run::run(&options),
            Self::Status(options) => status::status(&options),
            Self::Merge(options) => merge::merge(&options),
            Self::Replay(options) => replay::replay(&options),
            Self::Export(options) => export::export(&options),
            Self::Compare(options) => compare::compare(&options),
            Self::Recheck(options) => recheck::recheck(&options),
            Self::Failures(options) => failures::failures(&options),
            Self::Shrink(options) => shrink::shrink(&options),
            Self::Judge(options) => judge::judge(&options),
            Self::Check(options) => check::check(&options),
            Self::Explain(options) => explain::explain(&options),
            Self::New(options) => new::new(&options),
            Self::Demo(options) => demo::demo(&options),
            Self::Lsp { .. } => lsp::lsp(),
            Self::Fmt(options) => fmt::fmt(&options),
            Self::Preview(options) => preview::preview(&options),
            Self::Completions { shell } => {
                let mut script = Vec::new();
                let mut command = Arguments::command().mut_subcommands(|command| command.mut_args(without_quotes));
                clap_complete::generate(shell, &mut command, "falsify", &mut script);
                console::say(String::from_utf8_lossy(&script).trim_end());
                Ok(ExitCode::Done)
            }
        }
    }
}

/// The same without quotes and dollars in the descriptions of its values, which have a meaning to fish and zsh there.
fn without_quotes(argument: Arg) -> Arg {
    let plain = |value: &PossibleValue| {
        let help = value.get_help().map(|help| help.to_string().replace(['"', '`', '$'], "'"));
        PossibleValue::new(value.get_name().to_owned()).hide(value.is_hide_set()).help(help.unwrap_or_default())
    };
    match argument.get_possible_values().as_slice() {
        [] => argument,
        values => argument.value_parser(PossibleValuesParser::new(values.iter().map(plain))),
    }
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  falsify completions bash > ~/.local/share/bash-completion/completions/falsify";

/// When to colour the output.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Colouring {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Colouring {
    /// Applies to everything that is printed.
    pub fn apply(self) {
        let choice = match self {
            Self::Auto => anstream::ColorChoice::Auto,
            Self::Always => anstream::ColorChoice::Always,
            Self::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}
