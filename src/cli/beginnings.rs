//! `falsify check --sample`: where episodes would begin, and what is rejected.

use std::sync::Arc;

use serde::Serialize;

use super::args::{CheckOptions, Format};
use super::check::lines;
use super::{ExitCode, front};
use crate::compile::{Campaign, Plan};
use crate::env::Scenario;
use crate::report::{self, WriteError};
use crate::seed::Seed;

/// Beginnings that are drawn in a picture; more would hide each other.
const DRAWN: usize = 500;

/// What came of the beginnings of one spawn rule in one town.
#[derive(Serialize)]
struct Sample<'a> {
    campaign: &'a str,
    spawn: &'a str,
    town: &'a str,
    tried: u32,
    accepted: u32,
    constraints: Vec<Share>,
    picture: String,
}

/// How many beginnings satisfy a constraint.
#[derive(Serialize)]
struct Share {
    constraint: String,
    passed: u32,
}

/// Draws beginnings of all campaigns.
pub fn sample(plan: &Plan, count: u32, options: &CheckOptions) -> ExitCode {
    if plan.campaigns.is_empty() {
        front::fail("the files hold no campaign, so there is nothing to sample");
        return ExitCode::Nothing;
    }
    for campaign in &plan.campaigns {
        let samples = match survey(campaign, count, options) {
            Ok(samples) => samples,
            Err(error) => {
                front::fail(&error.to_string());
                return ExitCode::WriteFailed;
            }
        };
        match options.format {
            Format::Human => show(campaign, &samples),
            _ => lines(&samples),
        }
    }
    ExitCode::Done
}

fn survey<'a>(campaign: &'a Campaign, count: u32, options: &CheckOptions) -> Result<Vec<Sample<'a>>, WriteError> {
    let mut samples = Vec::new();
    let begins = |(_, scenario): &(&str, &Arc<Scenario>)| scenario.spawn.begins_in(&scenario.town);
    for (town, scenario) in campaign.beginnings().into_iter().filter(begins) {
        let rule = &scenario.spawn;
        let mut stream = Seed::root(options.seed).child("sample").child(town).child(&rule.name).stream();
        let first = scenario.cast.pedestrian.first_heading;
        let survey = rule.survey(&scenario.town, &scenario.obstacles, first, count, &mut stream);
        let picture = options.out.join(format!("spawn-{}-{}-{town}.svg", campaign.name, rule.name));
        let shown = &survey.spawns[..survey.spawns.len().min(DRAWN)];
        report::write_file(&picture, report::spawn_map(&scenario.town, shown).as_bytes())?;
        let constraints = survey.constraints.into_iter().map(|(constraint, passed)| Share { constraint, passed });
        samples.push(Sample {
            campaign: &campaign.name,
            spawn: &rule.name,
            town,
            tried: survey.tried,
            accepted: survey.accepted,
            constraints: constraints.collect(),
            picture: picture.display().to_string(),
        });
    }
    Ok(samples)
}

fn show(campaign: &Campaign, samples: &[Sample]) {
    front::say(&format!("campaign {}", campaign.name));
    for sample in samples {
        let Sample { spawn, town, tried, accepted, .. } = sample;
        let share = |passed: u32| 100.0 * f64::from(passed) / f64::from(*tried);
        let tries = front::count(*tried as usize, "beginning");
        front::say(&format!("  {spawn} in {town}: {accepted} of {tries} accepted ({:.2} %)", share(*accepted)));
        for Share { constraint, passed } in &sample.constraints {
            front::say(&format!("    {:>6.2} %  {constraint}", share(*passed)));
        }
        front::say(&format!("    {}", sample.picture));
    }
}
