//! Reports errors and notices of a session on the command line, with the options that help.

use std::fmt::Display;

use super::console;
use super::exit_code::ExitCode;
use crate::session::{Error, Notice, OtherInput};
use export::ExportError;
use results::store::StoreError;

/// Reports why a command has no result; returns its exit code.
pub fn failed(error: Error) -> ExitCode {
    match &error {
        Error::Unreadable { files } => files.iter().for_each(|file| console::fail(&file.to_string())),
        Error::Scenario { .. } => console::fail(&format!("{error}; nothing was run")),
        Error::UnusedMap { town } => console::fail(&format!("--map names the town `{town}`, which nothing uses")),
        Error::NoReport { .. } | Error::NoRun { .. } => {
            console::fail(&format!("{error}; name its folder with --report"));
        }
        Error::OtherReport(other) => {
            let edited = other.differences.iter().any(|each| matches!(each, OtherInput::Program(_)));
            let recheck = format!(
                "\n`falsify recheck --allow-external {}` lets the new program meet the same starts",
                other.folder.display()
            );
            console::fail(&format!(
                "{error}\nnothing was run; --out DIR writes to another folder, --replace replaces that report{}",
                if edited { recheck.as_str() } else { "" }
            ));
        }
        Error::NothingRun { out, cache } => console::fail(&match (out.display(), cache) {
            (out, Some(cache)) => format!("no campaign was run for `{out}` with the cache `{}`", cache.display()),
            (out, None) => {
                format!("no campaign was run in `{out}`; if it was run with --cache, name that folder here too")
            }
        }),
        Error::NotHeld { .. } => {
            console::fail(&format!(
                "{error}; reports hold files of up to 4 MiB, --files DIR names the folder of larger ones"
            ));
        }
        Error::Gate(reason) => console::fail(&format!("--fail-if: {reason}")),
        Error::Changed { changes } => {
            changes.iter().for_each(|change| console::fail(&change.to_string()));
            console::fail("these are not the files that were run; --anyway continues all the same");
        }
        Error::Differs { name, .. } => {
            console::fail(&format!(
                "{error}; `falsify replay {name}` shows where, and --anyway exports it all the same"
            ));
        }
        Error::NoSharedDriver { .. } => {
            console::fail(&format!("{error}; `--driver OLD=NEW` pairs drivers of different names"));
        }
        other => console::fail(&other.to_string()),
    }
    code(&error)
}

/// Reports wrong usage; returns its exit code.
pub fn misused(reason: impl Display) -> ExitCode {
    console::fail(&reason.to_string());
    ExitCode::Usage
}

/// Reports that a file cannot be written; returns the exit code.
pub fn unwritten(reason: impl Display) -> ExitCode {
    console::fail(&reason.to_string());
    ExitCode::WriteFailed
}

fn code(error: &Error) -> ExitCode {
    match error {
        Error::Scenario { .. } => ExitCode::Scenario,
        Error::NoCampaign { .. } => ExitCode::Nothing,
        Error::Store(error) => store_code(error),
        Error::Keep { .. } | Error::Write(_) => ExitCode::WriteFailed,
        Error::Changed { .. }
        | Error::CampaignGone { .. }
        | Error::RunGone { .. }
        | Error::CommandsDiffer { .. }
        | Error::Differs { .. } => ExitCode::Differs,
        Error::Export { source: ExportError::NotRepresentable { .. }, .. } => ExitCode::Usage,
        Error::Export { .. } => ExitCode::WriteFailed,
        Error::Unreadable { .. }
        | Error::UnusedMap { .. }
        | Error::Recording { .. }
        | Error::Gate(_)
        | Error::UnknownCampaign { .. }
        | Error::UnknownFilter { .. }
        | Error::Threads { .. }
        | Error::Read(_)
        | Error::NoFolder { .. }
        | Error::OtherReport(_)
        | Error::Compare(_)
        | Error::NotHeld { .. }
        | Error::NothingRun { .. }
        | Error::NoReport { .. }
        | Error::NoRun { .. }
        | Error::NoEpisode { .. }
        | Error::BadName { .. }
        | Error::NoDriver { .. }
        | Error::NoSharedDriver { .. }
        | Error::Incomparable { .. } => ExitCode::Usage,
    }
}

/// Reports that there is no store; returns the exit code.
pub fn store_failed(error: StoreError) -> ExitCode {
    console::fail(&error.to_string());
    store_code(&error)
}

fn store_code(error: &StoreError) -> ExitCode {
    if error.is_misuse() { ExitCode::Usage } else { ExitCode::WriteFailed }
}

/// Reports a notice, which does not end a command.
pub fn notice(notice: &Notice) {
    match notice {
        Notice::Unpaid { .. } | Notice::EpisodesInError { .. } | Notice::Incomplete(_) => {
            console::fail(&notice.to_string());
        }
        Notice::NoTasks { .. } => {
            console::warn(&format!("{notice}; where a shard was given --cache, name that folder"));
        }
        // Several campaigns may have the same to say.
        Notice::DoubtfulTraining { campaign, .. } | Notice::Caution { campaign, .. } => {
            console::warn(&format!("{campaign}: {notice}"));
        }
        Notice::Renewed { .. } => {
            console::warn(&format!(
                "{notice}; with `files: […]` or `version: \"…\"` in the scenario they are used again"
            ));
        }
        Notice::ProgramsNotAllowed => {
            console::warn("scenarios might start programs in that run; give --allow-external if they may again");
        }
        Notice::UnfinishedReports { .. } => console::note(&format!("{notice}; name one to list it")),
        Notice::Setting(_) => console::note(&notice.to_string()),
        Notice::Store { .. }
        | Notice::LearningCurve { .. }
        | Notice::UnreadableReport(_)
        | Notice::OtherVersion { .. }
        | Notice::Changed(_)
        | Notice::ChangedProgram(_) => {
            console::warn(&notice.to_string());
        }
    }
}
