use super::TrainingResult;
use super::picture::learning;
use crate::report::table::{Column, Depth, Section, Table, Value};
use crate::report::{Findings, Rate};
use compile::TrainingKey;
use learn::UpdateLog;

/// The end of each training; `None` without any.
pub fn trainings(found: &Findings<'_>) -> Option<Section> {
    let trainings = found.finished.all::<TrainingResult>();
    if trainings.is_empty() {
        return None;
    }
    let mut head: Vec<Column> = ["reward", "town", "driver"].map(Column::text).into();
    let is_judged = last_updates(trainings).any(|log| log.fault_rate.is_some());
    head.extend(["runs", "decisions each", "mean reward at the end", "collision rate at the end"].map(Column::number));
    head.extend(is_judged.then(|| Column::number("fault rate at the end")));
    head.push(Column::number("episode length at the end (decisions)"));
    let is_validated = trainings.iter().any(|training| !training.validation.is_empty());
    head.extend(
        is_validated
            .then(|| ["candidates each", "validation, kept", "validation, not kept"].map(Column::number))
            .into_iter()
            .flatten(),
    );
    head.push(Column::number("failed"));
    let row = |(key, members): &(&TrainingKey, Vec<&TrainingResult>)| {
        let ends: Vec<&UpdateLog> = last_updates(members.iter().copied()).collect();
        let over =
            |value: fn(&UpdateLog) -> Option<f64>| -> Vec<f64> { ends.iter().filter_map(|log| value(log)).collect() };
        let mut row = vec![
            Value::from(&key.reward),
            Value::from(&key.town),
            Value::from(&key.policy),
            Value::Count(members.len() as u64),
            Value::Count(ends.first().map_or(0, |log| log.steps)),
            over_runs(over(|log| log.mean_reward)),
            over_runs(over(|log| log.success_rate)),
        ];
        row.extend(is_judged.then(|| over_runs(over(|log| log.fault_rate))));
        row.push(over_runs(over(|log| log.mean_length)));
        if is_validated {
            let kept: Vec<f64> =
                members.iter().filter_map(|member| member.validation.get(member.kept()).copied()).collect();
            let others = members.iter().flat_map(|member| {
                member
                    .validation
                    .iter()
                    .enumerate()
                    .filter(|(number, _)| *number != member.kept())
                    .map(|(_, reward)| *reward)
            });
            row.push(Value::Count(members[0].validation.len() as u64));
            row.extend([over_runs(kept), over_runs(others.collect::<Vec<_>>())]);
        }
        row.push(Value::Count((members.len() - ends.len()) as u64));
        row
    };
    Some(Section {
        id: "trainings",
        name: "Trainings",
        title: "Trainings",
        depth: Depth::Page,
        figures: learning(trainings),
        tables: vec![Table { head, rows: groups(trainings).iter().map(row).collect(), ..Table::default() }],
        notes: vec![
            "Means of the last episodes of each training, while the pedestrian still explored. \"±\" is the standard deviation over trainings. \
             Of several candidates the one with the greatest mean reward on 1,000 validation starts is kept and shown. `figures/learning_*.svg` draw the whole course, `learning_curve.csv` has every update, \
             `pedestrians/` has the networks."
                .into(),
        ],
        ..Section::default()
    })
}

/// The last update of each training that did not fail.
fn last_updates<'a>(trainings: impl IntoIterator<Item = &'a TrainingResult>) -> impl Iterator<Item = &'a UpdateLog> {
    trainings.into_iter().filter_map(|training| training.result.as_ref().ok()?.learning_curve.last())
}

/// Trainings that differ only in their runs, in the order of the first.
fn groups(trainings: &[TrainingResult]) -> Vec<(&TrainingKey, Vec<&TrainingResult>)> {
    let mut groups: Vec<(&TrainingKey, Vec<&TrainingResult>)> = Vec::new();
    for training in trainings {
        let key = &training.key;
        match groups.iter_mut().find(|(other, _)| other.is_of_same_cell(key)) {
            Some((_, members)) => members.push(training),
            None => groups.push((key, vec![training])),
        }
    }
    groups
}

/// Mean and standard deviation.
fn over_runs(values: Vec<f64>) -> Value {
    (&Rate::of_runs(values)).into()
}
