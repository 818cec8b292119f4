use super::{ExitCode, front};
use crate::lsp::{Ending, serve};

/// `falsify lsp`
pub fn lsp() -> ExitCode {
    match serve(std::io::stdin().lock(), std::io::stdout().lock()) {
        Ok(Ending::Orderly) => ExitCode::Done,
        Ok(Ending::Abrupt) => ExitCode::Internal,
        Err(error) => {
            front::fail(&error.to_string());
            ExitCode::Usage
        }
    }
}
