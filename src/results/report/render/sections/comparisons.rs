use std::collections::BTreeSet;

use super::search_pairs::{first_pairs, probability};
use crate::record::CellKey;
use crate::report::render::table::{Column, Depth, Section, Selection, Table, Value};
use crate::report::{Comparison, Findings, Test};

/// Comparisons of pedestrians and of drivers with the same starts; `None` without any pair.
pub fn comparisons(found: &Findings<'_>) -> Option<Section> {
    let evidence = &found.gathered.evidence;
    let (drivers, pedestrians): (Vec<&Comparison>, Vec<&Comparison>) =
        evidence.comparisons.iter().partition(|found| found.is_of_drivers());
    let kinds = [("Pedestrians", pedestrians), ("Drivers", drivers)].into_iter().filter(|(_, found)| !found.is_empty());
    let tables: Vec<Table> = kinds.map(|(title, found)| table(title, &found)).collect();
    if tables.is_empty() {
        return None;
    }
    Some(Section {
        id: "comparisons",
        name: "Compared",
        title: "Better than others from the same starts?",
        depth: Depth::Page,
        tables,
        notes: vec![
            "Differences of rates: each trained pedestrian less another one that met the same starts, and each driver less another one that met \
             the same starts with the same pedestrian. p is the probability of at least such a difference by chance, after Holm's \
             correction for all tests of pedestrians, or of drivers, of this campaign: in 95 % of campaigns no p below 0.05 of a kind is a false finding. Call it \
             a tie above 0.05."
                .into(),
            "Intervals and p are Student's over trainings and common episodes. In 95 % of campaigns all intervals of a kind hold the truth together. Two \
             and three runs have no interval; their single values stand there. Two runs have no p either: their spread says too little. ¹ marks McNemar's exact test, for one run each: it and its interval are \
             about these two alone."
                .into(),
        ],
        ..Section::default()
    })
}

/// A row for each pair, with its rates side by side.
fn table(title: &str, found: &[&Comparison]) -> Table {
    let trainings: BTreeSet<(&str, &str)> =
        found.iter().map(|found| (found.first.train_town.as_str(), found.first.train_policy.as_str())).collect();
    let several = trainings.iter().filter(|training| !training.0.is_empty()).count() > 1;
    // The rates of a pair are consecutive.
    let pairs = found.chunk_by(|one, next| (&one.first, &one.second) == (&next.first, &next.second));
    let pairs: Vec<&[&Comparison]> = pairs.collect();
    let shown = Selection::new()
        .text("pedestrian", |pair: &&[&Comparison]| {
            let first = &pair[0].first;
            let training = match first.is_trained() && several {
                true => format!(" ({}, {})", first.train_town, first.train_policy),
                false => String::new(),
            };
            format!("{}{training}", who(first))
        })
        .text("place", |pair| format!("{} · {}", pair[0].first.town, pair[0].first.policy))
        .text("less", |pair| {
            let second = &pair[0].second;
            if pair[0].is_of_drivers() { second.policy.clone() } else { who(second) }
        })
        .each(
            ["collisions", "preventable", "fault"].into_iter().enumerate(),
            |(_, rate)| Column::number(format!("{rate} (95 %), p")),
            |(number, _), pair| {
                let found = pair.get(*number)?;
                let mark = if found.test == Test::McNemar { "¹" } else { "" };
                let p = format!("{}{mark}", probability(found.holm)).into();
                Some(Value::Lines(difference(found).into_iter().chain([p]).collect()))
            },
        );
    let table = Table { title: title.into(), ..shown.table(&pairs) };
    if found.iter().any(|found| found.is_of_drivers()) { first_pairs(table) } else { table }
}

fn who(key: &CellKey) -> String {
    if key.is_of_reward() { format!("{}, {}", key.controller, key.reward) } else { key.controller.clone() }
}

/// The difference with its interval; with too few runs for one, the values of the single runs.
fn difference(found: &Comparison) -> Vec<Value> {
    if !found.has_few_runs() {
        return vec![Value::difference(Some(found.difference), found.interval)];
    }
    let [first, second] = &found.by_run;
    let runs = |values: &[f64]| match values {
        [one] => Value::number(Some(*one), 2),
        each => Value::runs(each.to_vec(), 2, false),
    };
    if second.is_empty() {
        return vec![Value::runs(first.clone(), 2, true)];
    }
    vec![runs(first), Value::text(format!("less {}", runs(second)))]
}
