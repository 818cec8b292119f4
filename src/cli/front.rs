//! Files → plan, with everything that is to be said about them on the error stream.

use std::path::{Path, PathBuf};

use anstyle::{AnsiColor, Style};

use super::ExitCode;
use crate::compile::{Catalog, Plan, compile};
use crate::diagnostic::{Colour, Severity, Sources, render};
use crate::lang::reason;

const ERROR: Style = AnsiColor::Red.on_default().bold();

/// Says that something went wrong, in the manner of the diagnostics.
pub fn fail(message: &str) {
    anstream::eprintln!("{ERROR}error{ERROR:#}: {message}");
}

/// Reads, checks and compiles files.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn compile_files(files: &[PathBuf]) -> Result<(Plan, Sources), ExitCode> {
    let mut sources = Sources::default();
    let read = |path: &Path| std::fs::read_to_string(path);
    let compiled = match compile(files, &Catalog::builtin(), &read, &mut sources) {
        Ok(compiled) => compiled,
        Err((path, error)) => {
            fail(&format!("cannot read `{}`: {}", path.display(), reason(&error)));
            return Err(ExitCode::Usage);
        }
    };
    for diagnostic in &compiled.diagnostics {
        // The stream strips the colours where they are not wanted.
        anstream::eprintln!("{}\n", render(diagnostic, &sources, Colour::Always));
    }
    let errors = compiled.diagnostics.iter().filter(|each| each.severity == Severity::Error).count();
    match compiled.plan {
        Some(plan) => Ok((plan, sources)),
        None => {
            let plural = if errors == 1 { "" } else { "s" };
            fail(&format!("{errors} error{plural} found; nothing was run"));
            Err(ExitCode::Scenario)
        }
    }
}
