use super::names::{head, names};
use crate::report::render::table::{Column, Depth, Section, Table, Value};
use crate::report::{BeatsUntrained, Findings};

/// Whether the trainings beat untrained pedestrians, and the doubts about them; `None` if no trained controller was evaluated.
pub fn learnt(found: &Findings<'_>) -> Option<Section> {
    let Findings { cells, doubts, .. } = found;
    let learning = |cell| Some((cell, found.evidence(cell)?.learning.as_ref()?));
    let judged: Vec<_> = cells.iter().filter_map(learning).collect();
    if judged.is_empty() {
        return None;
    }
    let mut untrained: Vec<&str> = Vec::new();
    for baseline in judged.iter().flat_map(|(_, learning)| &learning.baselines) {
        if !untrained.contains(&baseline.controller.as_str()) {
            untrained.push(&baseline.controller);
        }
    }
    let mut columns = head();
    columns.push(Column::text("reward of each training"));
    columns.extend(untrained.iter().map(|other| Column::number(format!("less {other} (95 %)"))));
    columns.extend(["beats untrained", "trainings"].map(Column::text));
    let mut rows = Vec::new();
    for (cell, learning) in judged {
        let each: Vec<String> =
            learning.rewards.iter().map(|reward| Value::number(Some(*reward), 2).to_string()).collect();
        let less = |other: &&str| {
            let found = learning.baselines.iter().find(|baseline| baseline.controller == **other);
            let (difference, interval) = found.map(|found| found.difference).unzip();
            Value::difference(difference, interval)
        };
        let answer = learning.beats_untrained();
        let name = answer.name().to_string();
        let mut row = names(cell, cells);
        row.push(each.join(" ").into());
        row.extend(untrained.iter().map(less));
        row.push(if answer == BeatsUntrained::Yes { Value::text(name) } else { Value::warning(name) });
        row.push(match learning.disagree() {
            Some(true) => Value::warning("disagree"),
            Some(false) => Value::text("agree"),
            None => Value::text("one"),
        });
        rows.push(row);
    }
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
        tables: vec![Table { head: columns, rows, ..Table::default() }],
        notes,
        ..Section::default()
    })
}
