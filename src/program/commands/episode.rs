//! Options of the commands that repeat episodes of a report.

use std::str::FromStr;

use clap::Args;

use crate::cli::failure::misused;
use crate::exit_code::ExitCode;
use crate::session::{self, EpisodePath, NoEpisodeName};
use base::files;
use lang::reason;

/// Options of all commands that repeat episodes of a report.
#[derive(Debug, Clone, Default, Args)]
pub struct RepeatArgs {
    /// Those of a session.
    #[command(flatten)]
    pub repeat: session::RepeatOptions,
    /// Let scenarios start programs as drivers again; use it only with files that you trust.
    #[arg(long)]
    pub allow_external: bool,
}

/// An argument that names episodes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Named {
    Episode(EpisodePath),
    /// Those whose names are on the standard input.
    Input,
}

impl FromStr for Named {
    type Err = NoEpisodeName;

    fn from_str(text: &str) -> Result<Self, NoEpisodeName> {
        if text == "-" { Ok(Self::Input) } else { text.parse().map(Self::Episode) }
    }
}

/// All episodes that arguments name, with those on the standard input.
///
/// # Errors
/// The exit code, after the reason has been printed: the input cannot be read, or a line of it is not a name.
pub fn resolved(names: &[Named]) -> Result<Vec<EpisodePath>, ExitCode> {
    let mut all = Vec::new();
    for name in names {
        match name {
            Named::Episode(path) => all.push(path.clone()),
            Named::Input => all.extend(on_input()?),
        }
    }
    Ok(all)
}

/// Maximum number of characters of a line that an error quotes.
const MAX_QUOTED: usize = 80;

fn on_input() -> Result<Vec<EpisodePath>, ExitCode> {
    let text = files::text_of(std::io::stdin());
    let text = text.map_err(|error| misused(format!("the names cannot be read from the input: {}", reason(&error))))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let name = |(number, line): (usize, &str)| {
        line.trim().parse().map_err(|error: NoEpisodeName| {
            let start: String = line.chars().take(MAX_QUOTED).collect();
            misused(format!("line {} of the input, `{}`: {error}", number + 1, start.escape_debug()))
        })
    };
    let names: Vec<EpisodePath> = lines.map(name).collect::<Result<_, _>>()?;
    if names.is_empty() { Err(misused("the input has no name of an episode")) } else { Ok(names) }
}
