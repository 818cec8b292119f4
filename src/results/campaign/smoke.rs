use std::sync::Arc;

use compile::{Campaign, ControllerKind};

/// The decisions in which a driver is imitated.
const DEMONSTRATIONS: u32 = 1000;

/// Shrinks a campaign to a quick check of the whole pipeline: one run, two updates, five episodes, searches as long as ten episodes, estimates of a single
/// batch, covers of thirty, one small round of a hardening.
pub fn smoke(campaign: &mut Campaign) {
    let kept: Vec<usize> =
        (0..campaign.trainings.len()).filter(|index| campaign.trainings[*index].key.run == 0).collect();
    campaign.trainings.retain(|training| training.key.run == 0);
    for training in &mut campaign.trainings {
        let update = (training.config.rollout_steps * training.environments) as u64;
        training.config.total_steps = training.config.total_steps.min(2 * update);
        if let Some(rule) = &mut training.drive {
            let rule = Arc::make_mut(rule);
            rule.demonstrations = rule.demonstrations.min(DEMONSTRATIONS);
        }
    }
    campaign.evaluations.retain(|evaluation| evaluation.trained.run == 0);
    for evaluation in &mut campaign.evaluations {
        evaluation.episodes = evaluation.episodes.min(5);
        if let ControllerKind::Trained(training) | ControllerKind::Stochastic(training) = &mut evaluation.controller {
            *training = kept.iter().position(|index| index == training).expect("run 0 is kept");
        }
    }
    campaign.searches.retain(|search| search.key.run == 0);
    for search in &mut campaign.searches {
        search.budget =
            search.budget.min(10 * u64::from(search.scenario.episode.ticks + search.scenario.most_run_up()));
        search.tries = search.tries.min(5);
    }
    campaign.estimations.retain(|estimation| estimation.key.run == 0);
    for estimation in &mut campaign.estimations {
        estimation.budget = estimation
            .budget
            .min(10 * u64::from(estimation.scenario.episode.ticks + estimation.scenario.most_run_up()));
    }
    for cover in &mut campaign.covers {
        cover.budget = cover.budget.min(30);
    }
    campaign.hardenings.retain(|harden| harden.key.run == 0);
    for harden in &mut campaign.hardenings {
        let small = std::sync::Arc::make_mut(&mut harden.hardening);
        let longest = small.towns.iter().map(|(_, town)| u64::from(town.episode.ticks + town.most_run_up())).max();
        small.budget = small.budget.min(10 * longest.unwrap_or(0));
        small.rounds = 1;
        small.candidates = small.candidates.min(3);
        small.lessons = small.lessons.min(2);
        small.traffic = small.traffic.min(2);
        small.episodes = small.episodes.min(5);
    }
}
