use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Comparison, Evidence, Test};

/// Comparisons of controllers with the same starts; none without any pair.
pub fn comparisons(evidence: &Evidence) -> Option<Section> {
    if evidence.comparisons.is_empty() {
        return None;
    }
    let mut head: Vec<Column> =
        ["controller", "reward", "trained in, against", "town", "policy", "less"].map(Column::text).into();
    for rate in ["collisions", "with a moving car", "preventable", "attributable"] {
        head.extend([Column::number(format!("{rate} (95 %)")), Column::number("p")]);
    }
    let (columns, mut rows) = (head.len(), Vec::<Vec<Value>>::new());
    for found in &evidence.comparisons {
        let names = names(found);
        let difference = [
            Value::Difference(Some(found.difference), found.student.or(Some(found.bootstrap))),
            Value::Text(probability(found)),
        ];
        // The rates of a pair are consecutive.
        match rows.last_mut().filter(|row| row.starts_with(&names) && row.len() < columns) {
            Some(row) => row.extend(difference),
            None => rows.push(names.into_iter().chain(difference).collect()),
        }
    }
    rows.iter_mut().for_each(|row| row.resize(columns, Value::Number(None, 2)));
    Some(Section {
        id: "comparisons",
        name: "Compared",
        title: "Better than others from the same starts?",
        tables: vec![Table { head, rows, ..Table::default() }],
        notes: vec![
            "Differences of rates: each trained controller less another one that met the same starts. p is the probability of \
             at least such a difference by chance, after Holm's correction for all tests of this campaign; call it a tie above 0.05."
                .into(),
            "Intervals and p are Student's over trainings and common episodes. ¹ marks McNemar's exact test, for one run each: it is about these two \
             controllers only, and its interval is a bootstrap over episodes. `comparisons.csv` has the uncorrected p, Benjamini and \
             Hochberg's, and the bootstrap intervals."
                .into(),
        ],
    })
}

fn names(found: &Comparison) -> Vec<Value> {
    let (first, second) = (&found.first, &found.second);
    let other = if second.reward == first.reward {
        second.controller.clone()
    } else {
        format!("{} {}", second.controller, second.reward)
    };
    vec![
        Value::from(&first.controller),
        Value::from(&first.reward),
        format!("{}, {}", first.train_town, first.train_policy).into(),
        Value::from(&first.town),
        Value::from(&first.policy),
        other.into(),
    ]
}

fn probability(found: &Comparison) -> String {
    let mark = if found.test == Test::McNemar { "¹" } else { "" };
    match found.holm {
        None => format!("–{mark}"),
        Some(p) if p < 0.001 => format!("<0.001{mark}"),
        Some(p) => format!("{p:.3}{mark}"),
    }
}
