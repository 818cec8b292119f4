use super::TrainingResult;
use super::picture::{LEVEL, learning};
use crate::report::table::{Depth, Section, Selection, Value};
use crate::report::{Findings, Rate};
use crate::tables::{Cell, Metric};
use compile::TrainingKey;
use learn::UpdateLog;

/// Trainings that differ only in their runs.
type Members<'a> = Vec<&'a TrainingResult>;

/// The end of each training; `None` without any.
pub fn trainings(found: &Findings<'_>) -> Option<Section> {
    let trainings = found.finished.all::<TrainingResult>();
    if trainings.is_empty() {
        return None;
    }
    let is_judged = last_updates(trainings).any(|log| log.fault_rate.is_some());
    let is_validated = trainings.iter().any(|training| !training.validation.is_empty());
    let firsts = trainings.iter().enumerate().filter(|(place, training)| {
        !trainings[..*place].iter().any(|earlier| earlier.key.is_of_same_cell(&training.key))
    });
    let members =
        |first: &TrainingResult| trainings.iter().filter(|each| each.key.is_of_same_cell(&first.key)).collect();
    let cells: Vec<Members<'_>> = firsts.map(|(_, first)| members(first)).collect();
    let validated = |members: &Members<'_>, is_kept: bool| {
        let rewards = members.iter().flat_map(|member| {
            let chosen = member.validation.iter().enumerate();
            chosen.filter(move |(number, _)| (*number == member.kept()) == is_kept).map(|(_, reward)| *reward)
        });
        Value::from(&Rate::of_runs(rewards.collect()))
    };
    let shown = Selection::new()
        .text("reward", |members: &Members<'_>| members[0].key.reward.clone())
        .text("town", |members| members[0].key.town.clone())
        .text("driver", |members| members[0].key.policy.clone())
        .number("runs", Vec::len)
        .number("decisions each", |members| last_updates(members.iter().copied()).next().map_or(0, |log| log.steps))
        .number("mean reward at the end", at_the_end(|log| log.mean_reward))
        .number("collision rate at the end", at_the_end(|log| log.success_rate))
        .when(is_judged, |shown| shown.number("fault rate at the end", at_the_end(|log| log.fault_rate)))
        .number("episode length at the end (decisions)", at_the_end(|log| log.mean_length))
        .when(is_validated, |shown| {
            shown
                .number("candidates each", |members| members[0].validation.len())
                .number("validation, kept", move |members| validated(members, true))
                .number("validation, not kept", move |members| validated(members, false))
        })
        .number("failed", |members| members.len() - last_updates(members.iter().copied()).count());
    Some(Section {
        id: "trainings",
        name: "Trainings",
        title: "Trainings",
        depth: Depth::Page,
        figures: learning(trainings, &|key, metric| level(found, key, metric)),
        tables: vec![shown.table(&cells)],
        notes: vec![
            "Means of the last episodes of each training, while the pedestrian still explored. \"±\" is the standard deviation over trainings. \
             Of several candidates the one with the greatest mean reward on 1,000 validation starts is kept and shown. `figures/learning_*.svg` draw the whole course, `learning_curve.csv` has every update, \
             `pedestrians/` has the networks."
                .into(),
        ],
        ..Section::default()
    })
}

/// The mean of a metric of the pedestrian that learns nothing, in the town of a training, against its driver; of a reward that of the training.
fn level(found: &Findings<'_>, key: &TrainingKey, metric: &Metric) -> Option<f64> {
    let is_beside = |cell: &&Cell| {
        let is_paid = metric.is_share() || cell.key.reward == key.reward;
        cell.key.controller == LEVEL.0 && cell.key.town == key.town && cell.key.policy == key.policy && is_paid
    };
    found.cells.iter().chain(found.gathered.copies.iter()).find(is_beside)?.value(metric)
}

/// The last update of each training that did not fail.
fn last_updates<'a>(trainings: impl IntoIterator<Item = &'a TrainingResult>) -> impl Iterator<Item = &'a UpdateLog> {
    trainings.into_iter().filter_map(|training| training.result.as_ref().ok()?.learning_curve.last())
}

/// Mean and standard deviation of a figure of the last updates.
fn at_the_end(figure: fn(&UpdateLog) -> Option<f64>) -> impl Fn(&Members<'_>) -> Value {
    move |members| {
        let ends = last_updates(members.iter().copied());
        (&Rate::of_runs(ends.filter_map(figure).collect())).into()
    }
}
