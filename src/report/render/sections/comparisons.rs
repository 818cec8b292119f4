use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Comparison, Evidence, Test};

/// The greatest number of rows of drivers on a page; the file of the table has all.
const MOST_DRIVERS: usize = 60;

/// Comparisons of controllers and of drivers with the same starts; none without any pair.
pub fn comparisons(evidence: &Evidence) -> Option<Section> {
    let (drivers, controllers): (Vec<&Comparison>, Vec<&Comparison>) =
        evidence.comparisons.iter().partition(|found| found.is_of_drivers());
    let kinds = [("Controllers", controllers), ("Drivers", drivers)].into_iter().filter(|(_, found)| !found.is_empty());
    let tables: Vec<Table> = kinds.map(|(title, found)| table(title, &found)).collect();
    if tables.is_empty() {
        return None;
    }
    Some(Section {
        id: "comparisons",
        name: "Compared",
        title: "Better than others from the same starts?",
        tables,
        notes: vec![
            "Differences of rates: each trained controller less another one that met the same starts, and each driver less another one that met \
             the same starts with the same controller. p is the probability of at least such a difference by chance, after Holm's \
             correction for all tests of controllers, or of drivers, of this campaign; call it a tie above 0.05."
                .into(),
            "Intervals and p are Student's over trainings and common episodes. ¹ marks McNemar's exact test, for one run each: it is about these two \
             alone, and its interval is a bootstrap over episodes. `comparisons.csv` has the uncorrected p, Benjamini and \
             Hochberg's, and the bootstrap intervals."
                .into(),
        ],
    })
}

/// A row for each pair, with its rates side by side.
fn table(title: &str, found: &[&Comparison]) -> Table {
    let mut head: Vec<Column> =
        ["controller", "reward", "trained in, against", "town", "policy", "less"].map(Column::text).into();
    for rate in ["collisions", "with a moving car", "preventable", "attributable"] {
        head.extend([Column::number(format!("{rate} (95 %)")), Column::number("p")]);
    }
    let (columns, mut rows) = (head.len(), Vec::<Vec<Value>>::new());
    for found in found {
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
    let all = rows.len();
    let shown = if found.iter().any(|found| found.is_of_drivers()) { MOST_DRIVERS } else { all };
    rows.truncate(shown);
    let left = (all > shown).then(|| format!("The first {shown} of {all} pairs; `comparisons.csv` has all."));
    Table { title: title.into(), head, rows, notes: left.into_iter().collect() }
}

fn names(found: &Comparison) -> Vec<Value> {
    let (first, second) = (&found.first, &found.second);
    let other = if found.is_of_drivers() {
        second.policy.clone()
    } else if second.reward == first.reward {
        second.controller.clone()
    } else {
        format!("{} {}", second.controller, second.reward)
    };
    vec![
        Value::from(&first.controller),
        Value::from(&first.reward),
        (if first.is_trained() { format!("{}, {}", first.train_town, first.train_policy) } else { "–".into() }).into(),
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
