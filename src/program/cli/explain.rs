use clap::Args;

use super::console;
use super::exit_code::{Ended, ExitCode};
use super::failure::misused;
use compile::Catalog;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify explain                            list everything
  falsify explain missing-unit               a diagnostic, with a bad and a good example
  falsify explain policy idm                 the keys of a kind, with types, units and defaults
  falsify explain training ppo gamma         one key
  falsify explain matrix                     a word of the language, with an example
  falsify explain state                      what the controller of a pedestrian gets, with units and bounds";

/// Options of `falsify explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// A code; a form, a form and a kind, and a key of it; a word such as `param` or `normal`; an event, a variable; or `events`,
    /// `variables`, `units`, `state`, `action`.
    #[arg(value_name = "WORD")]
    pub words: Vec<String>,
}

/// `falsify explain`
pub fn explain(options: &ExplainArgs) -> Ended {
    let text = Catalog::builtin().explain(&options.words).map_err(misused)?;
    console::say(console::wrapped(&text).trim_end());
    Ok(ExitCode::Done)
}
