use std::ops::ControlFlow;

use rayon::prelude::*;

use super::search::{SearchResult, search};
use super::{EpisodeRow, Observer, StoppingRule, watch};
use crate::compile::{Campaign, Evaluation, Pedestrian, Training, TrainingKey};
use crate::env::{Outcome, Recording};
use crate::falsifier::{TrainError, train};
use crate::judge::{NearMiss, judge};
use crate::rl::Trained;
use crate::seed::Seed;

/// What became of a training.
#[derive(Debug, Clone)]
pub struct TrainingResult {
    /// Which training.
    pub key: TrainingKey,
    /// What it brought forth.
    pub result: Result<Trained, TrainError>,
}

/// What came of a campaign.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The trainings, in the plan's order. Those that were never begun are missing.
    pub trainings: Vec<TrainingResult>,
    /// All episodes, in the plan's order.
    pub rows: Vec<EpisodeRow>,
    /// The searches, in the plan's order. Those that were never begun are missing.
    pub searches: Vec<SearchResult>,
    /// Whether every evaluation has all its episodes, or as many as its stopping rule asks for.
    pub all_tried: bool,
    /// Whether the observer stopped it.
    pub interrupted: bool,
}

/// Runs a campaign on the present rayon pool.
///
/// Every training and every evaluation has a seed of its own that depends on the names of its town, policy, reward and
/// run alone: nothing changes when others are added to the campaign.
pub fn run(campaign: &Campaign, seed: &Seed, observer: &dyn Observer) -> Finished {
    let trainings: Vec<Option<TrainingResult>> = campaign
        .trainings
        .par_iter()
        .enumerate()
        .with_max_len(1)
        .map(|(index, training)| {
            if observer.stop() {
                return None;
            }
            observer.training_begun(index);
            let result = carry_out(index, training, seed, observer);
            observer.training_ended(index, &result);
            Some(result)
        })
        .collect();
    let episodes: Vec<Vec<EpisodeRow>> = campaign
        .evaluations
        .par_iter()
        .enumerate()
        .with_max_len(1)
        .map(|(index, evaluation)| evaluate(index, evaluation, &trainings, seed, observer))
        .collect();
    let all_tried = campaign.evaluations.iter().zip(&episodes).all(|(evaluation, rows)| is_finished(evaluation, rows));
    let searches: Vec<Option<SearchResult>> = campaign
        .searches
        .par_iter()
        .enumerate()
        .with_max_len(1)
        .map(|(index, planned)| {
            let result = search(planned, seed, observer)?;
            observer.searched(index, &result);
            Some(result)
        })
        .collect();
    Finished {
        trainings: trainings.into_iter().flatten().collect(),
        rows: episodes.into_iter().flatten().collect(),
        searches: searches.into_iter().flatten().collect(),
        all_tried,
        interrupted: observer.stop(),
    }
}

fn carry_out(index: usize, training: &Training, seed: &Seed, observer: &dyn Observer) -> TrainingResult {
    let key = &training.key;
    let seed = seed.child("train").child(&key.town).child(&key.policy).child(&key.reward).index(key.run.into());
    let result = train(&training.scenario, training.environments, &training.config, &seed, &mut |log| {
        observer.trained(index, training, log);
        flow(observer)
    });
    TrainingResult { key: key.clone(), result }
}

fn evaluate(
    index: usize,
    evaluation: &Evaluation,
    trainings: &[Option<TrainingResult>],
    seed: &Seed,
    observer: &dyn Observer,
) -> Vec<EpisodeRow> {
    let trained = match evaluation.pedestrian {
        Pedestrian::Trained(training) | Pedestrian::Sampled(training) => {
            let Some(TrainingResult { result: Ok(trained), .. }) = &trainings[training] else { return Vec::new() };
            Some(&trained.actor_critic)
        }
        _ => None,
    };
    if observer.stop() {
        return Vec::new();
    }
    let mut note = |outcome: &Outcome, recording: &Recording| {
        let scenario = &evaluation.scenario;
        (*outcome, judge(scenario, recording), NearMiss::new(scenario, recording))
    };
    let mut tell = |_| {
        observer.tried(index, evaluation);
        flow(observer)
    };
    let mut rows: Vec<EpisodeRow> = Vec::new();
    for look in rule(evaluation).looks() {
        let first = rows.len() as u32;
        let noted = watch(evaluation, trained, first..look, seed, &mut note, &mut tell);
        let row = |(episode, (outcome, verdict, near_miss))| {
            EpisodeRow::new(evaluation, episode, outcome, verdict, near_miss)
        };
        rows.extend((first..).zip(noted).map(row));
        if (rows.len() as u32) < look || is_finished(evaluation, &rows) {
            break;
        }
    }
    rows
}

fn rule(evaluation: &Evaluation) -> StoppingRule {
    StoppingRule::new(evaluation.halfwidth, evaluation.episodes)
}

/// Whether an evaluation has all its episodes, or as many as its stopping rule asks for.
fn is_finished(evaluation: &Evaluation, rows: &[EpisodeRow]) -> bool {
    let (rule, count) = (rule(evaluation), rows.len() as u32);
    let valid = rows.iter().filter(|row| row.outcome.fault().is_none()).count() as u64;
    let collisions = rows.iter().filter(|row| row.outcome.is_collision()).count() as u64;
    count == evaluation.episodes || (rule.looks().contains(&count) && rule.is_met(collisions, valid))
}

pub(super) fn flow(observer: &dyn Observer) -> ControlFlow<()> {
    if observer.stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Shrinks a campaign to a trial of its machinery: one run, two updates, five episodes, searches as long as ten episodes.
pub fn smoke(campaign: &mut Campaign) {
    let kept: Vec<usize> =
        (0..campaign.trainings.len()).filter(|index| campaign.trainings[*index].key.run == 0).collect();
    campaign.trainings.retain(|training| training.key.run == 0);
    for training in &mut campaign.trainings {
        let update = (training.config.rollout_steps * training.environments) as u64;
        training.config.total_steps = training.config.total_steps.min(2 * update);
    }
    campaign.evaluations.retain(|evaluation| evaluation.trained.run == 0);
    for evaluation in &mut campaign.evaluations {
        evaluation.episodes = evaluation.episodes.min(5);
        if let Pedestrian::Trained(training) | Pedestrian::Sampled(training) = &mut evaluation.pedestrian {
            *training = kept.iter().position(|index| index == training).expect("run 0 is kept");
        }
    }
    campaign.searches.retain(|search| search.key.run == 0);
    for search in &mut campaign.searches {
        search.budget = search.budget.min(10 * u64::from(search.scenario.episode.ticks));
        search.tries = search.tries.min(5);
    }
}
