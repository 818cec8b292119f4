use std::io::Write;

use super::args::{CheckOptions, Format};
use super::{ExitCode, front};
use crate::compile::{Campaign, Plan};
use crate::diagnostic::{Severity, records, sarif};
use crate::lang::mistakes::mistakes;
use crate::report::{self, WriteError};
use crate::seed::Seed;

const PLAIN: &str = "texts and numbers can be written as JSON";

/// Beginnings that are drawn in a picture; more would hide each other.
const DRAWN: usize = 500;

/// `falsify check`
pub fn check(options: &CheckOptions) -> ExitCode {
    if options.format != Format::Human {
        return for_programs(options);
    }
    match front::compile_files(&options.files, &options.given) {
        Ok((plan, files)) => {
            let (files, campaigns) = (files.len(), plan.campaigns.len());
            let plural = |n: usize| if n == 1 { "" } else { "s" };
            front::say(&format!(
                "{files} file{} and {campaigns} campaign{} checked: no errors",
                plural(files),
                plural(campaigns)
            ));
            options.sample.map_or(ExitCode::Done, |count| sample(&plan, count, options))
        }
        Err(code) => code,
    }
}

/// Draws beginnings of all campaigns.
fn sample(plan: &Plan, count: u32, options: &CheckOptions) -> ExitCode {
    if plan.campaigns.is_empty() {
        front::fail("the files hold no campaign, so there is nothing to sample");
        return ExitCode::Nothing;
    }
    for campaign in &plan.campaigns {
        if let Err(error) = survey(campaign, count, options) {
            front::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    }
    ExitCode::Done
}

fn survey(campaign: &Campaign, count: u32, options: &CheckOptions) -> Result<(), WriteError> {
    front::say(&format!("campaign {}", campaign.name));
    for (town, scenario) in campaign.beginnings() {
        let rule = &scenario.spawn;
        let mut stream = Seed::root(options.seed).child("sample").child(town).child(&rule.name).stream();
        let first = scenario.adversary.first_heading;
        let survey = rule.survey(&scenario.town, &scenario.obstacles, first, count, &mut stream);
        let share = |passed: u32| 100.0 * f64::from(passed) / f64::from(survey.tried);
        front::say(&format!(
            "  {} in {town}: {} of {} beginnings accepted ({:.2} %)",
            rule.name,
            survey.accepted,
            survey.tried,
            share(survey.accepted)
        ));
        for (constraint, passed) in &survey.constraints {
            front::say(&format!("    {:>6.2} %  {constraint}", share(*passed)));
        }
        let picture = options.out.join(format!("spawn-{}-{}-{town}.svg", campaign.name, rule.name));
        let shown = &survey.spawns[..survey.spawns.len().min(DRAWN)];
        report::write_file(&picture, report::spawn_map(&scenario.town, shown).as_bytes())?;
        front::say(&format!("    {}", picture.display()));
    }
    Ok(())
}

/// Prints what was found for programs, and nothing else.
fn for_programs(options: &CheckOptions) -> ExitCode {
    let gathered = match front::gather(&options.files, &options.given) {
        Ok(gathered) => gathered,
        Err(code) => return code,
    };
    let records = records(&gathered.compiled.diagnostics, &gathered.sources);
    match options.format {
        Format::Sarif => {
            let mistakes = mistakes();
            let rules: Vec<(&str, &str)> = mistakes.iter().map(|mistake| (mistake.code, mistake.text)).collect();
            front::say(&serde_json::to_string_pretty(&sarif(&records, &rules)).expect(PLAIN));
        }
        _ => {
            let lines: Vec<String> =
                records.iter().map(|record| serde_json::to_string(record).expect(PLAIN) + "\n").collect();
            // In one piece, since there may be very many; a reader that has gone away is no mistake.
            let _ = std::io::stdout().write_all(lines.concat().as_bytes());
        }
    }
    let errors = gathered.compiled.diagnostics.iter().any(|each| each.severity == Severity::Error);
    if errors { ExitCode::Scenario } else { ExitCode::Done }
}
