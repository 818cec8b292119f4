//! The program as a library: it checks scenarios, runs their campaigns, lists failures and repeats episodes.
//!
//! A [`Session`] holds what all calls share: the catalogue of the language, the reader of files, an [`Observer`] and a [`Stop`] flag. Each call
//! takes a struct of plain options, returns a value or an [`Error`], and the observer is called with each [`Event`] meanwhile. No call prints, reads
//! the arguments or the environment of the process, installs a signal handler or starts a program that the catalogue does not allow. The
//! structs of options are also arguments of the command line, which alone parses them.

mod disk;
mod error;
mod stop;
mod event;
mod input;
mod setup;
mod check;
mod options;
mod campaign_report;
mod manifest;
mod other_report;
mod growing_curves;
mod tasks;
mod run;
mod overview;
mod episode_name;
mod held_files;
mod held_programs;
mod changed_program;
mod stored;
mod repeat;
mod causes;
mod reasons;

pub use crate::commands::{
    FailuresArgs, FoundFailure, Replay, ReplayAllOptions, ReplayOptions, ReplayedReport, Retrained,
};
pub use campaign_report::{CampaignOutcome, CampaignReport, OverviewFiles, RunReport, ShardReport};
pub(crate) use causes::Causes;
pub use changed_program::ChangedProgram;
pub use check::{Checked, Planned};
pub use disk::Disk;
pub use episode_name::{EpisodeName, EpisodePath, NoEpisodeName};
pub(crate) use error::named;
pub use error::{Change, Error, KeepError};
pub use event::{Event, Level, Notice, Observer, Silent, Stage};
pub use growing_curves::NewestUpdate;
pub use input::Input;
pub(crate) use options::seconds;
pub use options::{RunOptions, TableFormat};
pub use other_report::{OtherInput, OtherReport};
pub use reasons::{Reason, reasons};
pub use repeat::Repeated;
pub(crate) use run::{CampaignRun, Work, pool};
pub use setup::Session;
pub use stop::Stop;
pub use stored::RepeatOptions;
pub(crate) use stored::{Source, WhichPrograms};
