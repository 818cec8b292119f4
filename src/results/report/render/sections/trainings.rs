use crate::campaign::TrainingResult;
use crate::report::Spread;
use crate::report::render::table::{Column, Section, Table, Value};
use compile::TrainingKey;
use learn::UpdateLog;

/// The end of each training; none without any.
pub fn trainings_section(trainings: &[TrainingResult]) -> Option<Section> {
    if trainings.is_empty() {
        return None;
    }
    let mut head: Vec<Column> = ["reward", "town", "policy"].map(Column::text).into();
    head.extend(
        [
            "runs",
            "decisions each",
            "mean reward at the end",
            "collision rate at the end",
            "episode length at the end (decisions)",
            "failed",
        ]
        .map(Column::number),
    );
    let row = |(key, members): &(&TrainingKey, Vec<&TrainingResult>)| {
        let ends: Vec<&UpdateLog> = members
            .iter()
            .filter_map(|member| member.result.as_ref().ok())
            .filter_map(|trained| trained.learning_curve.last())
            .collect();
        let over =
            |value: fn(&UpdateLog) -> Option<f64>| -> Vec<f64> { ends.iter().filter_map(|log| value(log)).collect() };
        vec![
            Value::from(&key.reward),
            Value::from(&key.town),
            Value::from(&key.policy),
            Value::Count(members.len() as u64),
            Value::Count(ends.first().map_or(0, |log| log.steps)),
            over_runs(&over(|log| log.mean_reward)).into(),
            over_runs(&over(|log| log.success_rate)).into(),
            over_runs(&over(|log| log.mean_length)).into(),
            Value::Count((members.len() - ends.len()) as u64),
        ]
    };
    Some(Section {
        id: "trainings",
        name: "Trainings",
        title: "Trainings",
        tables: vec![Table { head, rows: groups(trainings).iter().map(row).collect(), ..Table::default() }],
        notes: vec![
            "Means of the last episodes of each training, while the controller still explored. \"±\" is the standard deviation over trainings. \
             `learning_reward.svg`, `learning_collisions.svg` and `learning_length.svg` draw the whole course, `learning_curve.csv` has every update, \
             `pedestrians/` has the networks."
                .into(),
        ],
    })
}

/// Trainings that differ only in their runs, in the order of the first.
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
