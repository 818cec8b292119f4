use std::fmt::Write;

use super::Spread;
use super::render::spread;
use crate::campaign::TrainingResult;
use crate::compile::TrainingKey;
use crate::rl::UpdateLog;

/// The section of the summary about trainings: where each ended, and the pictures of how it went there; empty without any.
pub fn trainings_summary(trainings: &[TrainingResult]) -> String {
    let mut page = String::new();
    let groups = groups(trainings);
    if groups.is_empty() {
        return page;
    }
    page.push_str(
        "\n## Trainings\n\n| reward | town | policy | runs | decisions each | mean reward at the end | episode length at the end | failed |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for (key, members) in &groups {
        let ends: Vec<&UpdateLog> = members
            .iter()
            .filter_map(|member| member.result.as_ref().ok())
            .filter_map(|trained| trained.learning_curve.last())
            .collect();
        let decisions = ends.first().map_or(0, |log| log.steps);
        let over = |value: &dyn Fn(&UpdateLog) -> Option<f64>| -> Vec<f64> {
            ends.iter().filter_map(|log| value(log)).collect()
        };
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {decisions} | {} | {} decisions | {} |",
            key.reward,
            key.town,
            key.policy,
            members.len(),
            spread(over_runs(&over(&|log| log.mean_reward))),
            spread(over_runs(&over(&|log| log.mean_length))),
            members.len() - ends.len(),
        );
    }
    page.push_str(
        "\nMeans of the last episodes of each training, while it still explored; \"±\" is the standard deviation over trainings. \
         `learning_reward.svg` and `learning_length.svg` draw all of it, `learning_curve.csv` has every update, \
         `pedestrians/` the networks.\n",
    );
    page
}

/// Trainings that differ in their runs alone, in the order of the first.
fn groups(trainings: &[TrainingResult]) -> Vec<(&TrainingKey, Vec<&TrainingResult>)> {
    let mut groups: Vec<(&TrainingKey, Vec<&TrainingResult>)> = Vec::new();
    for training in trainings {
        let key = &training.key;
        let same = |(other, _): &&mut (&TrainingKey, _)| {
            (&other.reward, &other.town, &other.policy) == (&key.reward, &key.town, &key.policy)
        };
        match groups.iter_mut().find(same) {
            Some((_, members)) => members.push(training),
            None => groups.push((key, vec![training])),
        }
    }
    groups
}

fn over_runs(values: &[f64]) -> Spread {
    let n = values.len() as f64;
    let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / n);
    let variance = |mean: f64| values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Spread { mean, sd: mean.filter(|_| values.len() > 1).map(|mean| variance(mean).sqrt()) }
}
