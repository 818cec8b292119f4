use super::{ExitCode, args::CheckOptions, front};
use crate::compile::{Campaign, Plan};
use crate::report::{self, WriteError};
use crate::seed::Seed;

/// Beginnings that are drawn in a picture; more would hide each other.
const DRAWN: usize = 500;

/// `falsify check`
pub fn check(options: &CheckOptions) -> ExitCode {
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
        let picture = options.out.join(format!("spawn-{}-{town}.svg", rule.name));
        let shown = &survey.spawns[..survey.spawns.len().min(DRAWN)];
        report::write_file(&picture, report::spawn_map(&scenario.town, shown).as_bytes())?;
        front::say(&format!("    {}", picture.display()));
    }
    Ok(())
}
