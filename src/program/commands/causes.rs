//! What is said of causes below a gate that fails.

use std::path::Path;

use super::episode::RepeatArgs;
use crate::cli::console;
use crate::cli::input::session;
use crate::session::{EpisodeName, Error};
use results::report::StoredReport;
use verdict::cause::explain_any;

/// Maximum number of failures whose cause a gate says.
pub const MAX_TOLD: usize = 3;

/// Says why the first of these failures of a report happened, or which command asks. A program is asked only if it may start,
/// another simulator never.
pub fn tell(folder: &Path, names: Vec<String>, options: &RepeatArgs) {
    if names.is_empty() {
        return;
    }
    let report = StoredReport::open(folder).map_err(Error::from);
    let needed = report.as_ref().map_or("", |report| report.manifest().call.replay_options());
    let source = report.and_then(|report| session(options.allow_external).reopen(report, &options.repeat));
    let cause = |name: &String| {
        let repeated = source.as_ref().ok()?.repeat(EpisodeName::of_table(name.clone()).ok()?).ok()?;
        explain_any(repeated.as_in_report().filter(|incident| incident.scenario.external_world.is_none())?)
    };
    for name in names.into_iter().take(MAX_TOLD) {
        let path = folder.join(&name).display().to_string();
        console::note(&match cause(&name) {
            Some(cause) => format!("{path}: {}", cause.sentence()),
            None => format!("{path}: not asked why; `falsify replay --why {needed}{path}` asks"),
        });
    }
}
