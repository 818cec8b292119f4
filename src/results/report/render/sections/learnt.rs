use super::names::names;
use crate::report::render::table::{Column, Depth, Section, Value, unique};
use crate::report::{BeatsUntrained, Findings, Learning};
use crate::tables::Cell;

/// Whether the trainings beat untrained pedestrians, and the doubts about them; `None` if no trained controller was evaluated.
pub fn learnt(found: &Findings<'_>) -> Option<Section> {
    let Findings { cells, doubts, .. } = found;
    let learning = |cell| Some((cell, found.evidence(cell)?.learning.as_ref()?));
    let judged: Vec<(&Cell, &Learning)> = cells.iter().filter_map(learning).collect();
    if judged.is_empty() {
        return None;
    }
    let baselines = judged.iter().flat_map(|(_, learning)| &learning.baselines);
    let untrained = unique(baselines.map(|baseline| baseline.controller.as_str()));
    let shown = names(cells)
        .of(|row: &(&Cell, &Learning)| row.0)
        .text("reward of each training", |(_, learning)| {
            let each: Vec<String> = learning.rewards.iter().map(|reward| format!("{reward:.2}")).collect();
            each.join(" ")
        })
        .each(
            untrained,
            |other| Column::number(format!("less {other} (95 %)")),
            |other, (_, learning)| {
                let found = learning.baselines.iter().find(|baseline| baseline.controller == **other);
                let (difference, interval) = found.map(|found| found.difference).unzip();
                Value::difference(difference, interval)
            },
        )
        .text("beats untrained", |(_, learning)| match learning.beats_untrained() {
            BeatsUntrained::Yes => BeatsUntrained::Yes.name().into(),
            answer => Value::warning(answer.name()),
        })
        .text("trainings", |(_, learning)| match learning.disagree() {
            Some(true) => Value::warning("disagree"),
            Some(false) => "agree".into(),
            None => "one".into(),
        });
    let mut notes = vec![
        "Mean reward of an episode of each training, and their mean less that of pedestrians that learn nothing, from the same starts. *Beats untrained*: **yes** where each training is \
         significantly above one of these and none is below, **no** where one is below, else **unclear** (5 %, Holm). Trainings *disagree* where their standard deviation is more than \
         twice what the episodes explain and more than half of their mean gain over `random`. `--fail-if 'beats_untrained != yes'` and `--fail-if 'trainings_disagree == yes'` require it."
            .to_string(),
    ];
    if !doubts.is_empty() {
        let each: Vec<String> = doubts.iter().map(|doubt| format!("- {doubt}")).collect();
        notes.insert(0, each.join("\n"));
    }
    Some(Section {
        id: "beats-untrained",
        name: "Learnt?",
        title: "Do the trainings beat untrained pedestrians?",
        depth: if doubts.is_empty() { Depth::Page } else { Depth::Summary },
        tables: vec![shown.table(&judged)],
        notes,
        ..Section::default()
    })
}
