use super::args::ExplainOptions;
use super::{ExitCode, front};
use crate::compile::Catalog;

/// `falsify explain`
pub fn explain(options: &ExplainOptions) -> ExitCode {
    match Catalog::builtin().explain(&options.words) {
        Ok(text) => {
            front::say(text.trim_end());
            ExitCode::Done
        }
        Err(message) => {
            front::fail(&message);
            ExitCode::Usage
        }
    }
}
