//! The input of a command, and the session that reads it.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::{console, failure, interrupt, network_trial};
use crate::session::{Input, Notice, Observer, Session};
use base::diagnostic::{Diagnostic, Sources};
use compile::Catalog;
use process::ProcessOpener;

/// Options that replace parts of the files.
#[derive(Debug, Default, Args)]
pub struct GivenOptions {
    /// Take the roads of a town from an OpenDRIVE map instead; buildings are kept.
    #[arg(long, value_name = "TOWN=FILE", value_parser = town_and_file, help_heading = "Scenario")]
    pub map: Vec<(String, PathBuf)>,
    /// Give a parameter or a key of a declaration another value, as `far=20 m` or `ppo_paper.steps=1000`.
    #[arg(long, value_name = "NAME=VALUE", help_heading = "Scenario")]
    pub set: Vec<String>,
    /// Let scenarios name programs as drivers, which `run` starts; use it only with files that you trust.
    #[arg(long, help_heading = "Scenario")]
    pub allow_external: bool,
}

impl GivenOptions {
    /// These files and their replacements.
    pub fn input(&self, files: &[PathBuf]) -> Input {
        Input { files: files.to_vec(), maps: self.map.clone(), settings: self.set.clone() }
    }
}

fn town_and_file(text: &str) -> Result<(String, PathBuf), String> {
    let (town, file) = text.split_once('=').ok_or("write TOWN=FILE")?;
    Ok((town.to_string(), PathBuf::from(file)))
}

/// The language of the commands: networks are tried before they are loaded, and programs are started if the user allows it.
pub fn catalog(allow_external: bool) -> Catalog {
    let catalog = Catalog::builtin().with_network_trial(network_trial::trial());
    if allow_external { catalog.with_opener(Arc::new(ProcessOpener::default())) } else { catalog }
}

/// A session that reports on the error stream and stops at Ctrl-C.
pub fn session(allow_external: bool) -> Session {
    Session::new(catalog(allow_external)).with_observer(Arc::new(Reporter)).with_stop(interrupt::stop())
}

/// Reports diagnostics and notices on the error stream.
#[derive(Debug)]
pub struct Reporter;

impl Observer for Reporter {
    fn diagnostics(&self, diagnostics: &[Diagnostic], sources: &Sources) {
        console::show(diagnostics, sources);
    }

    fn notice(&self, notice: &Notice) {
        failure::notice(notice);
    }
}
