use std::path::PathBuf;

use compile::SearchKey;
use results::campaign::Shard;
use results::report::{Doubt, DriverResult, Gate, Judged, Manifest, Section};
use results::tables::{Cells, Rows};

/// The overview of the reports of a call: the variants of a matrix, the campaigns of several files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverviewFiles {
    /// Its page. The table `overview.csv` is beside it.
    pub page: PathBuf,
    /// Its table for a terminal.
    pub text: String,
}

/// The result of a run of campaigns.
#[derive(Debug)]
pub struct RunReport {
    /// The campaigns that were run, in order.
    pub campaigns: Vec<CampaignOutcome>,
    /// Whether the run was stopped. Then later campaigns are missing.
    pub interrupted: bool,
    /// The overview; `None` for a single report.
    pub overview: Option<OverviewFiles>,
}

impl RunReport {
    /// The reports that were written.
    pub fn reports(&self) -> impl Iterator<Item = &CampaignReport> {
        self.campaigns.iter().filter_map(|outcome| match outcome {
            CampaignOutcome::Reported(report) => Some(report.as_ref()),
            CampaignOutcome::Empty { .. } => None,
        })
    }
}

/// The result of a run of one campaign.
#[derive(Debug)]
pub enum CampaignOutcome {
    Reported(Box<CampaignReport>),
    /// No task was finished, so there is no report.
    Empty {
        /// The name that the report would have.
        name: String,
        /// Whether it was stopped.
        interrupted: bool,
    },
}

/// A report, with its main results.
#[derive(Debug)]
pub struct CampaignReport {
    /// The name of the report.
    pub name: String,
    pub folder: PathBuf,
    /// How it was made.
    pub manifest: Manifest,
    /// Means and intervals of each cell of the grid, in the order of the table `results`.
    pub cells: Cells,
    /// What changed since the report that it replaces, in a line; `None` if it replaces none.
    pub since: Option<String>,
    /// What was found about each driver, the worst first.
    pub drivers: Vec<DriverResult>,
    /// Means of the searches, in the order of their rows in `metrics`.
    pub searches: Rows<SearchKey>,
    /// The sections of the report.
    pub sections: Vec<Section>,
    /// The doubts about its trainings.
    pub doubts: Vec<Doubt>,
    /// The gates, each with its judgement of each row of the table that it is about.
    pub gates: Vec<(Gate, Vec<Judged>)>,
    /// The number of its tasks whose results, or parts of them, were stored before and not made by this run.
    pub reused: usize,
    pub tasks: usize,
    /// Whether a training or a search failed, or episodes in another simulator, more than a few.
    pub failed: bool,
}

impl CampaignReport {
    /// Whether nothing failed but a few episodes in another simulator, and the report is complete or the run was stopped.
    pub fn is_sound(&self) -> bool {
        let whole = self.manifest.complete || self.manifest.stopped;
        !self.failed && whole
    }

    /// Whether no gate is broken, and none wants an interval over too few runs.
    pub fn passes(&self) -> bool {
        !self.gates.iter().flat_map(|(_, judged)| judged).any(Judged::fails)
    }
}

/// The result of one shard of a campaign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShardReport {
    pub shard: Shard,
    /// The name that the campaign's report will have.
    pub name: String,
    /// The number of its finished tasks.
    pub finished: usize,
    /// The number of all its tasks.
    pub all: usize,
}
