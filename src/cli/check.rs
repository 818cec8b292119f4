use std::io::Write;

use serde::Serialize;

use super::args::{CheckOptions, Format};
use super::front::{self, Gathered};
use super::{ExitCode, beginnings};
use crate::compile::Overrides;
use crate::diagnostic::{Severity, records, sarif};
use crate::lang::mistakes::mistakes;

const PLAIN: &str = "texts and numbers can be written as JSON";

/// `falsify check`
pub fn check(options: &CheckOptions) -> ExitCode {
    if options.format == Format::Sarif && options.sample.is_some() {
        front::fail("SARIF has no place for samples; take `--format json`");
        return ExitCode::Usage;
    }
    let overrides = Overrides { only_checked: true, ..options.given.overrides() };
    let gathered = match front::gather(&options.files, &options.given, overrides) {
        Ok(gathered) => gathered,
        Err(code) => return code,
    };
    let checked = match options.format {
        Format::Human => for_people(&gathered, options),
        Format::Json => json(&gathered),
        Format::Sarif => log(&gathered),
    };
    let plan = gathered.compiled.plan.as_ref().or(gathered.compiled.unplaced.as_ref());
    let sampled = match options.sample.zip(plan) {
        Some((count, plan)) => beginnings::sample(plan, count, options),
        None => ExitCode::Done,
    };
    // The program ends here; to take a plan to pieces first is lost time.
    std::mem::forget(gathered);
    if checked == ExitCode::Done { sampled } else { checked }
}

fn for_people(gathered: &Gathered, options: &CheckOptions) -> ExitCode {
    if let Err(code) = front::tell(gathered, &options.given, "") {
        return code;
    }
    let campaigns = gathered.compiled.plan.as_ref().map_or(0, |plan| plan.campaigns.len());
    let (files, campaigns) = (front::count(gathered.records.len(), "file"), front::count(campaigns, "campaign"));
    front::say(&format!("{files} and {campaigns} checked: no errors"));
    if let Some(plan) = gathered.compiled.plan.as_ref().filter(|plan| plan.campaigns.is_empty())
        && !plan.imported_campaigns.is_empty()
    {
        front::say(&plan.without_campaigns());
    }
    ExitCode::Done
}

/// Prints what was found for programs, one object a line.
fn json(gathered: &Gathered) -> ExitCode {
    lines(&records(&gathered.compiled.diagnostics, &gathered.sources));
    code(gathered)
}

/// Prints what was found as SARIF.
fn log(gathered: &Gathered) -> ExitCode {
    let mistakes = mistakes();
    let rules: Vec<(&str, &str)> = mistakes.iter().map(|mistake| (mistake.code, mistake.text)).collect();
    let records = records(&gathered.compiled.diagnostics, &gathered.sources);
    front::say(&serde_json::to_string_pretty(&sarif(&records, &rules)).expect(PLAIN));
    code(gathered)
}

fn code(gathered: &Gathered) -> ExitCode {
    let errors = gathered.compiled.diagnostics.iter().any(|each| each.severity == Severity::Error);
    if errors { ExitCode::Scenario } else { ExitCode::Done }
}

/// Prints objects, one a line; in one piece, since there may be very many.
pub fn lines(objects: &[impl Serialize]) {
    let lines: Vec<String> = objects.iter().map(|object| serde_json::to_string(object).expect(PLAIN) + "\n").collect();
    // A reader that has gone away is no mistake.
    let _ = std::io::stdout().write_all(lines.concat().as_bytes());
}
