use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Change, Evidence, Transfer};

/// The loss in another town or against another driver; none when no controller was evaluated elsewhere.
pub fn transfer(evidence: &Evidence) -> Option<Section> {
    if evidence.transfers.is_empty() {
        return None;
    }
    let mut head: Vec<Column> =
        ["controller", "reward", "trained in, against", "evaluated in", "against"].map(Column::text).into();
    let rates = ["gap of collisions", "preventable", "fault"];
    head.extend(rates.map(|rate| Column::number(format!("{rate} (95 %)"))));
    let (columns, mut rows) = (head.len(), Vec::<Vec<Value>>::new());
    for found in &evidence.transfers {
        let names = names(found);
        let gap = match (found.interval, found.by_run.len()) {
            (None, 2..) => Value::Runs(found.by_run.clone(), 2, true),
            (interval, _) => Value::Difference(Some(found.gap), interval),
        };
        // The rates of a change are consecutive.
        match rows.last_mut().filter(|row| row.starts_with(&names) && row.len() < columns) {
            Some(row) => row.push(gap),
            None => rows.push(names.into_iter().chain([gap]).collect()),
        }
    }
    rows.iter_mut().for_each(|row| row.resize(columns, Value::Number(None, 2)));
    Some(Section {
        id: "transfer",
        name: "Transfer",
        title: "Does it transfer?",
        tables: vec![Table { head, rows, ..Table::default() }],
        notes: vec![
            "The rate where the controller was trained, less the rate of the same trainings elsewhere. Above 0, the controller loses by the change. \
             The interval is Student's over the gaps of the trainings and over episodes; with fewer than four the gap of each stands there. \
             Drivers of a town meet the same starts, so their episodes are paired; towns have starts of their own."
                .into(),
        ],
    })
}

fn names(found: &Transfer) -> Vec<Value> {
    let (home, away) = (&found.home, &found.away);
    let arrow = |here: &str, there: &str| Value::from(format!("{here} → {there}"));
    let (town, policy) = match found.change {
        Change::Town => (arrow(&home.town, &away.town), Value::from(&home.policy)),
        Change::Policy => (Value::from(&home.town), arrow(&home.policy, &away.policy)),
    };
    let trained = format!("{}, {}", home.train_town, home.train_policy);
    vec![Value::from(&home.controller), Value::from(&home.reward), trained.into(), town, policy]
}
