mod stored;

use std::time::{Duration, SystemTime};

use clap::Args;
use indicatif::FormattedDuration;

use crate::cli::console;
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::cli::output::Output;
use crate::cli::progress::Learnt;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{self, CampaignProgress, CampaignState};
use results::store::TaskStatus;
use stored::stored;

/// The most tasks under way that are named.
const SHOWN: usize = 8;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify status                             the campaigns of reports/
  falsify status --format json --out shared  one JSON object for each campaign, for programs
  falsify status --stored                    what is stored in reports/.falsify, by campaign
  falsify status --prune                     remove what no campaign needed in its last run
  falsify status --cache /scratch/cache --prune --gone
                                             in a shared folder; also what belongs to deleted reports

Exit codes: 0 finished or running   2 nothing was run there   9 something is missing and no process works on it";

/// Options of `falsify status`.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The folder and its cache.
    #[command(flatten)]
    pub of: session::StatusOptions,
    /// Form of the output; `json` is one object for each campaign.
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT")]
    pub format: Output,
    /// Show how much finished work is stored for each campaign instead.
    #[arg(long)]
    pub stored: bool,
    /// Remove stored tasks that no campaign needed in its last run, for any folder for reports.
    #[arg(long)]
    pub prune: bool,
    /// Also remove tasks of folders for reports that do not exist, or cannot be seen from here.
    #[arg(long, requires = "prune")]
    pub gone: bool,
}

/// `falsify status`
pub fn status(options: &StatusArgs) -> Ended {
    if options.stored || options.prune {
        return stored(options);
    }
    let campaigns = session(false).status(&options.of).map_err(failed)?;
    for campaign in &campaigns {
        match options.format {
            Output::Json => console::say_object(campaign),
            Output::Human => tell(campaign),
        }
    }
    let stopped = campaigns.iter().any(|campaign| campaign.state == CampaignState::Stopped);
    Ok(if stopped { ExitCode::Incomplete } else { ExitCode::Done })
}

fn tell(campaign: &CampaignProgress) {
    let processes = match campaign.processes {
        0 => String::new(),
        1 => ", one process works on the folder".into(),
        several => format!(", {several} processes work on the folder"),
    };
    console::say(&format!("{}: {}{processes}", campaign.campaign, campaign.state.name()));
    for kind in &campaign.kinds {
        console::say(&format!(
            "  {:11} {:>width$} of {} tasks, {:.0} % of the work",
            kind.kind,
            kind.finished,
            kind.all,
            (100.0 * kind.share).floor(),
            width = kind.all.to_string().len()
        ));
    }
    for task in campaign.under_way.iter().take(SHOWN) {
        let newest = campaign.learning.iter().find(|newest| task.what.strip_prefix("train ") == Some(&newest.training));
        let learnt = newest.and_then(|newest| Learnt::from(newest).told()).map(|learnt| format!(", {learnt}"));
        console::say(&format!("  under way: {}{}{}", task.what, saved(task), learnt.unwrap_or_default()));
    }
    if campaign.in_hand.len() > SHOWN {
        console::say(&format!("  … and {} more under way", campaign.in_hand.len() - SHOWN));
    }
    if let Some(error) = &campaign.last_error {
        console::say(&format!("  last error: {error}"));
    }
    if campaign.state == CampaignState::Finished {
        return;
    }
    match (campaign.left_s, campaign.left_thread_s) {
        (Some(left), _) => {
            console::say(&format!("  about {} left with {} tasks under way", clock(left), campaign.in_hand.len()));
        }
        (None, Some(left)) => console::say(&format!("  about {} left for one thread", clock(left))),
        (None, None) if campaign.measured_s > 0.0 => {
            let known = clock(campaign.measured_s);
            let unknown = campaign.unmeasured.join(" and ");
            console::say(&format!("  about {known} left for one thread, and the {unknown}, of which none is done yet"));
        }
        (None, None) => console::say("  too little is done to say how long the rest will take"),
    }
    if campaign.state == CampaignState::Stopped && !campaign.command.is_empty() {
        // A shard makes a part of the tasks, and other shards may write elsewhere.
        let of_shard = campaign.command.split(' ').any(|word| word.starts_with("--shard"));
        let command = &campaign.command;
        console::say(&match (of_shard, campaign.is_command_done) {
            (true, true) => {
                format!("  the shard of `{command}` is finished; `falsify merge` names the shards that are missing")
            }
            (true, false) => {
                format!("  go on with this shard: {command}; `falsify merge` names the shards that are missing")
            }
            (false, _) => format!("  go on with: {command}"),
        });
    }
}

/// What is stored of a task, and how long ago it was saved.
fn saved(task: &TaskStatus) -> String {
    let ago = task.written.and_then(|written| SystemTime::now().duration_since(written).ok());
    match ago {
        Some(ago) => {
            let share = (100 * task.done()).checked_div(task.amount).unwrap_or(0);
            format!(", {share} % of it saved {} s ago", ago.as_secs())
        }
        None => ", nothing saved yet".into(),
    }
}

fn clock(seconds: f64) -> FormattedDuration {
    FormattedDuration(Duration::from_secs_f64(seconds.max(0.0).ceil()))
}
