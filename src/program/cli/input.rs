//! The input of a command, and the session that reads it.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::{console, failure, interrupt};
use crate::session::{Event, Input, Observer, Session};
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
