//! Reports errors and notices on the error stream.

use std::fmt::Display;

use super::{console, interrupt};
use crate::exit_code::ExitCode;
use crate::session::{Error, Level, Notice};

/// Reports why a command has no result; returns its exit code.
pub fn failed(error: Error) -> ExitCode {
    match &error {
        Error::Unreadable { files } => files.iter().for_each(|file| console::fail(&file.to_string())),
        Error::Changed { changes } => {
            changes.iter().for_each(|change| console::fail(&change.to_string()));
            console::fail("these are not the files that were run; --anyway continues all the same");
        }
        other => console::fail(&other.to_string()),
    }
    error.exit_code()
}

/// Reports wrong usage; returns its exit code.
pub fn misused(reason: impl Display) -> ExitCode {
    failed(Error::Usage(reason.to_string()))
}

/// Reports that a file cannot be written; returns the exit code.
pub fn unwritten(reason: impl Display) -> ExitCode {
    console::fail(&reason.to_string());
    ExitCode::WriteFailed
}

/// Reports a notice, which does not end a command.
pub fn notice(notice: &Notice) {
    let text = match notice {
        // Several campaigns may have the same to say.
        Notice::DoubtfulTraining { campaign, .. } | Notice::Caution { campaign, .. } => format!("{campaign}: {notice}"),
        other => other.to_string(),
    };
    match notice.level() {
        Level::Note => console::note(&text),
        Level::Warning => console::warn(&text),
        Level::Error => console::fail(&text),
    }
}

/// Warns if programs crashed or timed out in this process: they are started again, and an episode is lost if that happens when it is repeated alone.
/// `lost` is the number of episodes without a result, if it is known.
pub fn programs(lost: Option<u64>) {
    let times = match process::failures() {
        0 => return,
        _ if interrupt::stop().is_asked() => return,
        1 => "once".to_owned(),
        times => format!("{times} times"),
    };
    let end = match lost {
        None => String::new(),
        Some(0) => "; no episode was lost".to_owned(),
        Some(lost) => format!("; the column `error` of `episodes` says why {lost} have no result"),
    };
    console::warn(&format!("programs crashed or timed out {times} and were started again{end}"));
}
