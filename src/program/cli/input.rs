//! The input of a command, and the session that reads it.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::{console, failure, interrupt};
use crate::session::{Event, Input, Observer, Session};
use compile::Catalog;
use process::ProcessOpener;

/// Options that replace parts of the files.
#[derive(Debug, Args)]
pub struct GivenArgs {
    /// The replacements.
    #[command(flatten)]
    pub input: Input,
    /// Let scenarios name programs as drivers, which `run` starts; use it only with files that you trust.
    #[arg(long, help_heading = "Scenario")]
    pub allow_external: bool,
}

impl GivenArgs {
    /// These files and their replacements.
    pub fn input(&self, files: &[PathBuf]) -> Input {
        Input { files: files.to_vec(), ..self.input.clone() }
    }
}

/// A session that reports on the error stream and stops at Ctrl-C.
pub fn session(allow_external: bool) -> Session {
    let catalog = match allow_external {
        true => Catalog::builtin().with_opener(Arc::new(ProcessOpener::default())),
        false => Catalog::builtin(),
    };
    let session = Session::new(catalog).with_observer(Arc::new(Reporter)).with_stop(interrupt::stop());
    session.with_folder(std::env::current_dir().unwrap_or_default())
}

/// Reports diagnostics and notices on the error stream.
#[derive(Debug)]
pub struct Reporter;

impl Observer for Reporter {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Diagnostics(diagnostics, sources) => console::show(diagnostics, sources),
            Event::Notice(notice) => failure::notice(notice),
            _ => {}
        }
    }
}
