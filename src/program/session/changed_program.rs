use std::fmt;

use compile::{Campaign, changed_files};
use results::report::Manifest;

/// Maximum number of files that are named.
const MAX_NAMED: usize = 3;

/// A program of the user that is not, or need not be, the one that a report was made with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChangedProgram {
    /// The name of the driver or the controller.
    pub name: String,
    /// Its files that have changed, by their paths in the folder of the scenario.
    pub files: Vec<String>,
    /// Whether it may have changed unnoticed, since the scenario states neither files nor version.
    pub is_unknown: bool,
}

impl ChangedProgram {
    /// The programs of a campaign that differ, or may differ, from those of a report.
    pub(super) fn all(then: &Manifest, now: &Campaign) -> Vec<Self> {
        let programs = now.programs();
        let changed = programs.iter().filter_map(|now| {
            let then = then.programs.iter().find(|then| then.name == now.name)?;
            let files = changed_files(&then.files, &now.files).into_iter().map(str::to_owned).collect();
            let is_unknown = then.is_unknown() || now.is_unknown();
            Some(Self { name: now.name.clone(), files, is_unknown })
        });
        changed.filter(|each| each.is_unknown || !each.files.is_empty()).collect()
    }
}

/// `params.py` of `mine` has changed
impl fmt::Display for ChangedProgram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, files, is_unknown } = self;
        match files.as_slice() {
            [] if *is_unknown => write!(f, "it is not known whether the program of `{name}` has changed"),
            [] => write!(f, "the program of `{name}` has changed"),
            [file] => write!(f, "`{file}` of `{name}` has changed"),
            _ => {
                let first = files.iter().take(MAX_NAMED).map(|file| format!("`{file}`")).collect::<Vec<_>>().join(", ");
                let more = files.len().saturating_sub(MAX_NAMED);
                let more = if more > 0 { format!(" and {more} more files") } else { String::new() };
                write!(f, "{first}{more} of `{name}` have changed")
            }
        }
    }
}
