//! Options that a command gets when it is chosen: all commands together have many, and a call is of one.

use clap::error::Error;
use clap::{ArgMatches, Args, Command, FromArgMatches};

use super::cells::CellsOptions;
use super::check::CheckOptions;
use super::config;
use super::debug::DebugOptions;
use super::explain::ExplainOptions;
use super::fmt::FmtOptions;
use super::map::MapOptions;
use super::merge::MergeOptions;
use super::new::NewOptions;
use super::render::RenderOptions;
use super::replay::ReplayOptions;
use super::run::RunOptions;
use super::status::StatusOptions;
use super::verify::VerifyOptions;

/// Makes the options of a command.
type Make = fn(Command) -> Command;

/// The commands, with what makes their options.
const COMMANDS: [(&str, Make); 14] = [
    ("run", options::<RunOptions>),
    ("merge", options::<MergeOptions>),
    ("status", options::<StatusOptions>),
    ("config", config::with_options),
    ("replay", options::<ReplayOptions>),
    ("render", options::<RenderOptions>),
    ("verify", options::<VerifyOptions>),
    ("cells", options::<CellsOptions>),
    ("check", options::<CheckOptions>),
    ("explain", options::<ExplainOptions>),
    ("new", options::<NewOptions>),
    ("fmt", options::<FmtOptions>),
    ("map", options::<MapOptions>),
    ("debug", options::<DebugOptions>),
];

/// Options that the derived command does not have yet.
#[derive(Debug)]
pub struct Later<T>(pub T);

impl<T: Args> Args for Later<T> {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

impl<T: FromArgMatches> FromArgMatches for Later<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        T::from_arg_matches(matches).map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        self.0.update_from_arg_matches(matches)
    }
}

/// Lets the commands have their options when they are chosen.
pub fn when_chosen(command: Command) -> Command {
    command.mut_subcommands(|each| match make(&each) {
        Some(make) => each.defer(make),
        None => each,
    })
}

/// Gives the commands their options at once.
pub fn at_once(command: Command) -> Command {
    command.mut_subcommands(|each| match make(&each) {
        Some(make) => make(each),
        None => each,
    })
}

fn make(command: &Command) -> Option<Make> {
    COMMANDS.into_iter().find(|(name, _)| *name == command.get_name()).map(|(_, make)| make)
}

/// Gives a command its options; what it says about itself is not theirs to change.
fn options<T: Args>(command: Command) -> Command {
    let about = command.get_about().cloned().unwrap_or_default();
    T::augment_args(command).about(about)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::args::Arguments;
    use super::*;

    #[test]
    fn every_command_has_its_options_or_none() {
        let without: Vec<String> = Arguments::command()
            .get_subcommands()
            .filter(|each| !each.has_subcommands() && each.get_arguments().next().is_none() && make(each).is_none())
            .map(|each| each.get_name().to_string())
            .collect();
        assert!(without.is_empty(), "{without:?}: a command whose options come later needs a line in `COMMANDS`");
    }
}
