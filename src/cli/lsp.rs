use super::{ExitCode, front};
use crate::lsp::{Ending, serve};

/// `falsify lsp`
pub fn lsp() -> ExitCode {
    let shelf = std::env::temp_dir().join(concat!("falsify-", env!("CARGO_PKG_VERSION"), "-std"));
    match serve(std::io::stdin().lock(), std::io::stdout().lock(), shelf) {
        Ok(Ending::Orderly) => ExitCode::Done,
        Ok(Ending::Abrupt) => ExitCode::Internal,
        Err(error) => {
            front::fail(&error.to_string());
            ExitCode::Usage
        }
    }
}
