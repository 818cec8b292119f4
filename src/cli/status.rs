//! `falsify status`: how far campaigns are, running or dead.

use std::time::{Duration, SystemTime};

use indicatif::FormattedDuration;
use serde::Serialize;

use super::args::{Output, StatusOptions};
use super::{ExitCode, front, run};
use crate::store::{CampaignStatus, CellStatus, Store};

/// Kinds of cells: the first word of what they are, and what to call several of them.
const KINDS: [(&str, &str); 3] = [("train", "trainings"), ("try", "evaluations"), ("search", "searches")];

/// Most cells under way that are named.
const SHOWN: usize = 8;

/// How far a campaign is, for programs.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    campaign: &'a str,
    /// `finished`, `running` or `stopped`.
    state: &'static str,
    /// Processes at work on the folder.
    processes: usize,
    cells: Vec<Kind>,
    in_hand: Vec<&'a str>,
    /// Work that is left, as one thread would take it (s); none before there is something of every kind to measure.
    left_thread_s: Option<f64>,
    /// The same without the kinds of which there is nothing yet.
    #[serde(skip)]
    measured: Left,
    /// Time that is left with as many cells in hand as now (s); none when nobody is at work.
    left_s: Option<f64>,
    last_error: Option<&'a str>,
    command: &'a str,
}

/// How far the cells of a kind are.
#[derive(Debug, Serialize)]
struct Kind {
    kind: &'static str,
    finished: usize,
    all: usize,
    /// Share of the work that is there, of cells in part too.
    share: f64,
}

/// Work that is left as one thread would take it.
#[derive(Debug)]
struct Left {
    /// That of which there is something to measure (s).
    seconds: f64,
    /// The kinds of which there is nothing.
    unknown: Vec<&'static str>,
}

/// `falsify status`
pub fn status(options: &StatusOptions) -> ExitCode {
    let store = match Store::look(&options.out, options.cache.as_deref(), Box::new(front::warn)) {
        Ok(store) => store,
        Err(error) => return run::no_store(&error),
    };
    let campaigns = store.campaigns();
    if campaigns.is_empty() {
        let out = options.out.display();
        let cache = options.cache.as_ref().map(|cache| cache.display());
        front::fail(&match cache {
            Some(cache) => format!("no campaign was run for `{out}` with the cache `{cache}`"),
            None => format!("no campaign was run in `{out}`; if it was run with --cache, name that folder here, too"),
        });
        return ExitCode::Usage;
    }
    let processes = store.processes();
    let mut code = ExitCode::Done;
    for name in campaigns {
        let campaign = store.status(&name);
        let summary = summary(&campaign, processes);
        match options.format {
            Output::Json => {
                front::say(&serde_json::to_string(&summary).expect("texts and numbers have a form in JSON"));
            }
            Output::Human => tell(&summary, &campaign),
        }
        if summary.state == "stopped" {
            code = ExitCode::Incomplete;
        }
    }
    code
}

fn summary(campaign: &CampaignStatus, processes: usize) -> Summary<'_> {
    let cells = &campaign.cells;
    let in_hand: Vec<&str> = cells.iter().filter(|cell| cell.is_in_hand).map(|cell| cell.what.as_str()).collect();
    let state = match cells.iter().all(CellStatus::is_finished) {
        true => "finished",
        false if processes > 0 => "running",
        false => "stopped",
    };
    let measured = left(cells);
    let left = measured.unknown.is_empty().then_some(measured.seconds);
    let failed = |cell: &CellStatus| {
        Some((cell.written?, cell.header.as_ref().filter(|head| !head.error.is_empty())?.error.clone()))
    };
    let last = cells.iter().filter_map(|cell| failed(cell).map(|(when, _)| (when, cell))).max_by_key(|(when, _)| *when);
    Summary {
        campaign: &campaign.name,
        state,
        processes,
        cells: KINDS.iter().filter_map(|(word, kind)| count(cells, word, kind)).collect(),
        left_thread_s: left,
        measured,
        left_s: left.filter(|_| !in_hand.is_empty()).map(|left| left / in_hand.len() as f64),
        in_hand,
        last_error: last.and_then(|(_, cell)| cell.header.as_ref()).map(|header| header.error.as_str()),
        command: &campaign.command,
    }
}

fn of_kind<'a>(cells: &'a [CellStatus], word: &str) -> impl Iterator<Item = &'a CellStatus> {
    cells.iter().filter(move |cell| cell.what.split(' ').next() == Some(word))
}

fn count(cells: &[CellStatus], word: &str, kind: &'static str) -> Option<Kind> {
    let all = of_kind(cells, word).count();
    let amount: u64 = of_kind(cells, word).map(|cell| cell.amount).sum();
    let done: u64 = of_kind(cells, word).map(CellStatus::done).sum();
    let finished = of_kind(cells, word).filter(|cell| cell.is_finished()).count();
    (all > 0).then(|| Kind { kind, finished, all, share: done as f64 / amount.max(1) as f64 })
}

/// Work that is left as one thread would take it, from what the cells took that are there.
fn left(cells: &[CellStatus]) -> Left {
    let mut all = Left { seconds: 0.0, unknown: Vec::new() };
    for (word, kind) in KINDS {
        let left: u64 = of_kind(cells, word).map(|cell| cell.amount - cell.done()).sum();
        if left == 0 {
            continue;
        }
        let done: u64 = of_kind(cells, word).map(CellStatus::done).sum();
        let took: f64 = of_kind(cells, word)
            .filter(|cell| cell.done() > 0)
            .filter_map(|cell| Some(cell.header.as_ref()?.seconds))
            .sum();
        if done == 0 {
            all.unknown.push(kind);
        } else {
            all.seconds += took / done as f64 * left as f64;
        }
    }
    all
}

fn tell(summary: &Summary<'_>, campaign: &CampaignStatus) {
    let processes = match summary.processes {
        0 => String::new(),
        1 => ", one process is at work on the folder".into(),
        several => format!(", {several} processes are at work on the folder"),
    };
    front::say(&format!("{}: {}{processes}", summary.campaign, summary.state));
    for kind in &summary.cells {
        front::say(&format!(
            "  {:11} {:>width$} of {} cells, {:.0} % of the work",
            kind.kind,
            kind.finished,
            kind.all,
            (100.0 * kind.share).floor(),
            width = kind.all.to_string().len()
        ));
    }
    for cell in campaign.cells.iter().filter(|cell| cell.is_in_hand).take(SHOWN) {
        front::say(&format!("  in hand: {}{}", cell.what, saved(cell)));
    }
    if summary.in_hand.len() > SHOWN {
        front::say(&format!("  … and {} more in hand", summary.in_hand.len() - SHOWN));
    }
    if let Some(error) = summary.last_error {
        front::say(&format!("  last error: {error}"));
    }
    if summary.state == "finished" {
        return;
    }
    match (summary.left_s, summary.left_thread_s) {
        (Some(left), _) => {
            front::say(&format!("  about {} left with {} cells in hand", clock(left), summary.in_hand.len()));
        }
        (None, Some(left)) => front::say(&format!("  about {} left for one thread", clock(left))),
        (None, None) if summary.measured.seconds > 0.0 => {
            let (known, unknown) = (clock(summary.measured.seconds), summary.measured.unknown.join(" and "));
            front::say(&format!("  about {known} left for one thread, and the {unknown}, of which none is done yet"));
        }
        (None, None) => front::say("  too little is done to say how long the rest will take"),
    }
    if summary.state == "stopped" && !summary.command.is_empty() {
        front::say(&format!("  go on with: {}", summary.command));
    }
}

/// What a cell has saved, and how long ago.
fn saved(cell: &CellStatus) -> String {
    let ago = cell.written.and_then(|written| SystemTime::now().duration_since(written).ok());
    match ago {
        Some(ago) => {
            let share = (100 * cell.done()).checked_div(cell.amount).unwrap_or(0);
            format!(", {share} % of it saved {} s ago", ago.as_secs())
        }
        None => ", nothing saved yet".into(),
    }
}

fn clock(seconds: f64) -> FormattedDuration {
    FormattedDuration(Duration::from_secs_f64(seconds.max(0.0).ceil()))
}
