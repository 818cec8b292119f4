//! Conditions under which a run fails, and the report for a server of continuous integration.

use std::path::PathBuf;

use clap::Args;

use super::console;
use super::exit_code::ExitCode;
use crate::report::{self, Gate, Judged, SearchCell, Suite};
use crate::session::{CampaignReport, RunReport};

/// Options that make a run pass or fail.
#[derive(Debug, Default, Args)]
pub struct GateOptions {
    /// Fail (exit code 7) when this is true of a cell, as 'preventable_rate > 0.05' or 'collision_rate_wilson_low > 0.2 and town == village':
    /// columns of the table `cells`, or of `search_cells`, as 'attributable_failures > 0'; may be given several times. `max over controllers
    /// COLUMN` judges the worst controller of each place, 'learnt != yes' requires that every training learnt.
    #[arg(long, value_name = "CONDITION", help_heading = "Gates")]
    pub fail_if: Vec<String>,
    /// Also write the results as JUnit XML, one test case for each cell.
    #[arg(long, value_name = "FILE", help_heading = "Gates")]
    pub junit: Option<PathBuf>,
}

impl GateOptions {
    /// Reads the conditions.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn gates(&self) -> Result<Vec<Gate>, ExitCode> {
        self.fail_if.iter().map(|text| Gate::parse(text)).collect::<Result<_, _>>().map_err(|error| {
            console::fail(&format!("--fail-if: {error}"));
            ExitCode::Usage
        })
    }

    /// Writes the JUnit file, if one is asked for.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn write(&self, run: &RunReport) -> Result<(), ExitCode> {
        let Some(path) = &self.junit else { return Ok(()) };
        let suite = |report: &CampaignReport| Suite {
            manifest: report.manifest.clone(),
            cells: report.cells.clone(),
            searches: report.searches.clone(),
            gates: report.gates.clone(),
        };
        let suites: Vec<Suite> = run.reports().map(suite).collect();
        report::write_file(path, report::junit(&suites).as_bytes()).map_err(|error| {
            console::fail(&error.to_string());
            ExitCode::WriteFailed
        })
    }
}

/// Reports which conditions are true of which cells of a campaign, and which cannot be judged.
pub fn show(report: &CampaignReport) {
    let campaign = &report.manifest.campaign;
    for (gate, judged) in &report.gates {
        let names: Vec<String> = if gate.is_about_searches() {
            report.searches.iter().map(SearchCell::in_full).collect()
        } else {
            report.cells.iter().map(|cell| cell.key.in_full()).collect()
        };
        for (name, judged) in names.iter().zip(judged) {
            let cell = format!("{campaign}, {name}");
            match judged {
                Judged::Broken(values) => {
                    console::fail(&format!("--fail-if {}: {} in {cell}", gate.text(), report::shown(values)));
                }
                Judged::Missing(column) => {
                    console::warn(&format!("--fail-if {}: there is no {column} in {cell}", gate.text()));
                }
                Judged::Passed | Judged::Elsewhere => {}
            }
        }
        if judged.iter().all(|judged| *judged == Judged::Elsewhere) {
            console::warn(&format!("--fail-if {}: no cell of {campaign} matches it", gate.text()));
        }
    }
}
