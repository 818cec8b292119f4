//! Conditions under which a run fails, and the report for a server of continuous integration.

use std::path::PathBuf;

use clap::Args;

use crate::cli::console;
use crate::cli::failure::{failed, misused, unwritten};
use crate::cli::output::Output;
use crate::commands::causes;
use crate::commands::compare;
use crate::commands::condition::{self, Condition};
use crate::commands::episode::RepeatArgs;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{CampaignReport, RunReport};
use results::failure::Failure;
use results::report::{self, Gate, GateError, Judged, SearchCell, StoredReport, Suite};
use results::tables::Cell;

/// Options that make a run pass or fail.
#[derive(Debug, Args)]
pub struct GateArgs {
    /// Fail (exit code 7) when this is true of a cell, as 'preventable_rate > 0.05' or 'collision_rate_wilson_low > 0.2 and town == village':
    /// metrics, also of searches, as 'fault_start_rate > 0.1'; may be given several times. `max over pedestrians
    /// COLUMN` judges the worst pedestrian of each place, 'beats_untrained != yes' wants trainings above untrained pedestrians.
    #[arg(long, value_name = "CONDITION", help_heading = "Gates")]
    pub fail_if: Vec<String>,
    /// Let a row pass that a condition cannot judge, since a column has no value there; without it such a row fails.
    #[arg(long, help_heading = "Gates")]
    pub allow_unjudged: bool,
    /// Compare each report with this one from before, or with that of the same name in this folder of reports. --fail-if then also knows
    /// the columns of `falsify compare`, as 'fault_rate_p_holm < 0.05 and fault_rate_difference > 0'.
    #[arg(long, value_name = "DIR", help_heading = "Gates")]
    pub baseline: Option<PathBuf>,
    /// Also write the results as JUnit XML, one test case for each cell.
    #[arg(long, value_name = "FILE", help_heading = "Gates")]
    pub junit: Option<PathBuf>,
}

impl GateArgs {
    /// Reads the conditions.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn gates(&self) -> Result<Vec<Gate>, ExitCode> {
        let own = self.fail_if.iter().filter(|text| !self.is_of_comparison(text));
        let refused = |text: &String, error: GateError| {
            let compared = self.baseline.as_ref().and(Condition::parse(text, &compare::tables(&self.fail_if)).err());
            let compared = compared.filter(|_| matches!(error, GateError::Column { .. }));
            let known = compared.filter(|other| !matches!(other, GateError::Column { .. }));
            misused(format!("--fail-if: {}", known.unwrap_or(error)))
        };
        let gate = |text| Gate::parse(text).map(|gate| gate.allowing_unjudged(self.allow_unjudged));
        own.map(|text| gate(text).map_err(|error| refused(text, error))).collect()
    }

    /// Whether a condition names columns that only the comparison with the baseline has.
    fn is_of_comparison(&self, text: &str) -> bool {
        self.baseline.is_some()
            && Gate::parse(text).is_err()
            && Condition::parse(text, &compare::tables(&self.fail_if)).is_ok()
    }

    /// Compares the reports of a run with the baseline, if there is one, and judges the conditions on the comparison.
    pub fn compare(&self, run: &RunReport, output: Output) -> ExitCode {
        let Some(baseline) = &self.baseline else { return ExitCode::Done };
        let conditions = self.fail_if.iter().filter(|text| self.is_of_comparison(text));
        let conditions = conditions.filter_map(|text| Condition::parse(text, &compare::tables(&self.fail_if)).ok());
        let conditions: Vec<Condition> =
            conditions.map(|condition| condition.allowing_unjudged(self.allow_unjudged)).collect();
        let is_report = baseline.join("manifest.toml").is_file();
        let against = |report: &CampaignReport| -> Ended {
            let before = if is_report { baseline.clone() } else { baseline.join(&report.name) };
            let comparison = compare::compared(&[before, report.folder.clone()], [None; 2]).map_err(failed)?;
            let text = compare::text(&comparison);
            match output {
                Output::Human => console::say(&text),
                // The output has events only.
                Output::Json => console::note(&text),
            }
            let failed = compare::judge(&conditions, &comparison)?;
            let allow_external = report.manifest.call.allow_external;
            compare::tell_causes(&failed, &comparison, &RepeatArgs { allow_external, ..RepeatArgs::default() });
            compare::tell_worse(&conditions, &failed, &comparison);
            Ok(ExitCode::of_gate(failed.is_empty()))
        };
        let codes = run.reports().map(|report| against(report).unwrap_or_else(|code| code));
        codes.fold(ExitCode::Done, ExitCode::or)
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
        report::write_file(path, report::junit(&suites).as_bytes()).map_err(unwritten)
    }
}

/// Reports which conditions are true of which cells of a campaign, and which cannot be judged.
pub fn show(report: &CampaignReport) {
    let campaign = &report.manifest.campaign;
    if report.manifest.smoke && !report.gates.is_empty() {
        console::warn("--fail-if was judged on a smoke run, which is too short to show anything about a driver");
    }
    let found =
        report.drivers.iter().filter_map(|result| result.searched).map(|searched| searched.fault).sum::<usize>();
    let is_of_searches = report.gates.iter().any(|(gate, _)| gate.is_about_searches());
    if found > 0 && !report.gates.is_empty() && !is_of_searches && report.passes() {
        console::warn(&format!(
            "--fail-if judged the evaluations of {campaign} alone, and its searches found {}: `faults > 0` is about them",
            console::count(found, "fault")
        ));
    }
    for (gate, judged) in &report.gates {
        let names: Vec<String> = if gate.is_about_searches() {
            report.searches.iter().map(SearchCell::in_full).collect()
        } else {
            report.cells.iter().map(|cell| cell.key.in_full()).collect()
        };
        let titles: Vec<String> = names.iter().map(|name| format!("{campaign}, {name}")).collect();
        condition::tell(gate, judged, &titles);
        if judged.iter().all(|judged| *judged == Judged::Elsewhere) {
            console::warn(&format!("--fail-if {}: no row of {campaign} matches it", gate.text()));
        }
    }
    tell_causes(report);
}

/// Says why the worst failures in the rows happened of which a condition is true.
fn tell_causes(report: &CampaignReport) {
    let of_cell = |Cell { key, .. }: &Cell| [key.policy.clone(), key.town.clone(), key.controller.clone()];
    let of_search = |SearchCell { key, .. }: &SearchCell| [key.policy.clone(), key.town.clone(), key.falsifier.clone()];
    let failed = |(gate, judged): &(Gate, Vec<Judged>)| -> Vec<[String; 3]> {
        let rows: Vec<[String; 3]> = match gate.is_about_searches() {
            true => report.searches.iter().map(of_search).collect(),
            false => report.cells.iter().map(of_cell).collect(),
        };
        rows.into_iter().zip(judged).filter(|(_, judged)| judged.fails()).map(|(row, _)| row).collect()
    };
    let failed: Vec<[String; 3]> = report.gates.iter().flat_map(failed).collect();
    let stored = (!failed.is_empty()).then(|| StoredReport::open(&report.folder).ok()?.failures().ok());
    let mut failures: Vec<Failure> = stored.flatten().unwrap_or_default();
    failures.retain(|Failure { key, .. }| {
        failed.contains(&[key.cell.policy.clone(), key.cell.town.clone(), key.cell.controller.clone()])
    });
    failures.sort_by(Failure::worse_first);
    let options = RepeatArgs { allow_external: report.manifest.call.allow_external, ..RepeatArgs::default() };
    causes::tell(&report.folder, failures.iter().take(causes::MAX_TOLD).map(Failure::name).collect(), &options);
}
