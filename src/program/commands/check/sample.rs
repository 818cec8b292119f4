//! `falsify check --sample`: where episodes would start, and which starts are rejected.

use serde::Serialize;

use super::{CheckArgs, Format};
use crate::cli::console;
use crate::cli::failure::unwritten;
use crate::commands::starts::{EndsOfRoads, SampledStarts, sampled_starts};
use crate::exit_code::{Ended, ExitCode};
use compile::{Campaign, Plan};
use results::report::{self, WriteError};

/// Maximum number of starts in a picture; more would hide each other.
const DRAWN: usize = 500;

/// The starts that were drawn from one spawn rule in one town.
#[derive(Serialize)]
struct Sample<'a> {
    campaign: &'a str,
    spawn: String,
    town: String,
    tried: u32,
    accepted: u32,
    constraints: Vec<Share>,
    /// Accepted starts from which a road that leads nowhere may end within the episode.
    near_road_end: usize,
    /// Accepted starts whose pedestrian stands past such an end.
    past_road_end: usize,
    #[serde(skip)]
    ends: EndsOfRoads,
    picture: String,
}

/// The number of starts that satisfy a constraint.
#[derive(Serialize)]
struct Share {
    constraint: String,
    passed: u32,
}

/// Draws this number of starts for each spawn in each town of all campaigns.
pub fn sample(plan: &Plan, count: u32, options: &CheckArgs) -> Ended {
    if plan.campaigns.is_empty() {
        console::fail("the files hold no campaign, so there is nothing to sample");
        return Err(ExitCode::Nothing);
    }
    for campaign in &plan.campaigns {
        let samples = survey(campaign, count, options).map_err(unwritten)?;
        if options.format == Format::Json {
            console::say_objects(&samples);
        } else {
            show(campaign, &samples);
        }
    }
    Ok(ExitCode::Done)
}

fn survey<'a>(campaign: &'a Campaign, count: u32, options: &CheckArgs) -> Result<Vec<Sample<'a>>, WriteError> {
    let mut samples = Vec::new();
    for SampledStarts { town, scenario, survey, ends } in sampled_starts(campaign, count, options.seed) {
        let spawn = scenario.spawn.name.clone();
        let picture = options.out.join(format!("spawn-{}-{spawn}-{town}.svg", campaign.name));
        let shown = &survey.spawns[..survey.spawns.len().min(DRAWN)];
        report::write_file(&picture, report::spawn_map(&scenario.town, shown).as_bytes())?;
        let constraints = survey.constraints.into_iter().map(|(constraint, passed)| Share { constraint, passed });
        samples.push(Sample {
            campaign: &campaign.name,
            spawn,
            town,
            tried: survey.tried,
            accepted: survey.accepted,
            constraints: constraints.collect(),
            near_road_end: ends.near,
            past_road_end: ends.past,
            ends,
            picture: picture.display().to_string(),
        });
    }
    Ok(samples)
}

fn show(campaign: &Campaign, samples: &[Sample]) {
    console::say(&format!("campaign {}", campaign.name));
    for sample in samples {
        let Sample { spawn, town, tried, accepted, .. } = sample;
        let share = |passed: u32| 100.0 * f64::from(passed) / f64::from(*tried);
        let tries = console::count(*tried as usize, "start");
        console::say(&format!("  {spawn} in {town}: {accepted} of {tries} accepted ({:.2} %)", share(*accepted)));
        if !sample.constraints.is_empty() {
            console::say("    share of the starts that satisfy each constraint:");
        }
        for Share { constraint, passed } in &sample.constraints {
            console::say(&format!("    {:>6.2} %  {constraint}", share(*passed)));
        }
        let EndsOfRoads { way, near, past } = sample.ends;
        if near > 0 {
            console::say(&format!(
                "    from {near} of these {accepted} a road ends within {way:.0} m, which a car drives at the limit in a whole episode: an episode in \
                 which it drives past the end counts in no rate. Make the road longer, or end the episode before"
            ));
        }
        if past > 0 {
            console::say(&format!(
                "    the pedestrian stands past the end of a road in {past} of these {accepted}, where the map has none"
            ));
        }
        console::say(&format!("    {}", sample.picture));
    }
}
