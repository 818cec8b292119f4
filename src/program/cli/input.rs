//! The input of a command, and the session that reads it.

use std::path::PathBuf;
use std::sync::{Arc, PoisonError, RwLock};

use clap::Args;

use super::{console, failure, interrupt, network_trial};
use crate::session::{Event, Input, Observer, Session};
use compile::Catalog;
use process::ProcessOpener;
use world::env::MapWriter;

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

/// Makes the language of the commands in this process.
static LANGUAGE: RwLock<fn() -> Catalog> = RwLock::new(Catalog::builtin);

/// Sets the language of the commands.
pub fn speak(language: fn() -> Catalog) {
    *LANGUAGE.write().unwrap_or_else(PoisonError::into_inner) = language;
}

/// The language, without programs and without trials of networks.
pub fn language() -> Catalog {
    let make = *LANGUAGE.read().unwrap_or_else(PoisonError::into_inner);
    make()
}

/// The language of the commands without programs: networks are tried before they are loaded, and maps are written for other worlds.
fn without_programs() -> Catalog {
    language().with_network_trial(network_trial::trial()).with_map_writer(map_writer())
}

/// Writes the maps of towns for other worlds.
pub fn map_writer() -> Arc<MapWriter> {
    Arc::new(|town| export::town(town).map_err(|error| error.to_string()))
}

/// The language for editors: programs are looked up, and none is started.
pub fn catalog() -> Catalog {
    without_programs().with_opener(Arc::new(ProcessOpener::default()))
}

/// A session that reports on the error stream and stops at Ctrl-C.
pub fn session(allow_external: bool) -> Session {
    let catalog = without_programs();
    let session = Session::new(match allow_external {
        true => catalog.with_opener(Arc::new(ProcessOpener::default().asking())),
        false => catalog,
    });
    let session = session.with_observer(Arc::new(Reporter)).with_stop(interrupt::stop());
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
