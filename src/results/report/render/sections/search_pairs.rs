use crate::report::SearchComparison;
use crate::report::render::table::{Column, Table, Value};

/// The greatest number of rows of a kind on a page; the file of the table has all.
const MOST: usize = 60;

/// The figures that the tables show, by the names of their columns in `searches`, and their heads.
const SHOWN: [(&str, &str); 3] = [
    ("failed_starts", "failed starts (95 %), p"),
    ("fault_start_rate", "starts with a fault (95 %), p"),
    ("avoidable_injury_per_thousand", "avoidable injury / 1,000 (95 %), p"),
];

/// Below this a difference is a finding.
const ALPHA: f64 = 0.05;

/// Pairs of falsifiers and pairs of drivers, a table each; none of a kind without any pair.
pub fn search_pairs(compared: &[SearchComparison]) -> Vec<Table> {
    let kinds = [("Falsifiers in pairs", true), ("Drivers in pairs", false)];
    let of = |(title, of_falsifiers)| {
        let found: Vec<_> = compared.iter().filter(|found| found.is_of_falsifiers() == of_falsifiers).collect();
        (!found.is_empty()).then(|| table(title, &found))
    };
    kinds.into_iter().filter_map(of).collect()
}

fn table(title: &str, found: &[&SearchComparison]) -> Table {
    let mut head: Vec<Column> = ["falsifier", "place", "less"].map(Column::text).into();
    head.extend(SHOWN.map(|(_, head)| Column::number(head)));
    let mut pairs: Vec<&SearchComparison> = Vec::new();
    for each in found {
        // The figures of a pair are consecutive.
        if !pairs.last().is_some_and(|last| last.is_of_same_pair(each)) {
            pairs.push(each);
        }
    }
    let row = |pair: &&SearchComparison| {
        let other = if pair.is_of_falsifiers() { &pair.other.0 } else { &pair.other.1 };
        let mut row =
            vec![Value::from(&pair.one.0), format!("{} · {}", pair.town, pair.one.1).into(), Value::from(other)];
        row.extend(SHOWN.map(|(figure, _)| {
            let of = found.iter().find(|each| each.figure == figure && each.is_of_same_pair(pair));
            of.map_or(Value::Number(None, 2), |of| {
                Value::Lines(vec![difference(of), Value::Text(probability(of.p_holm))])
            })
        }));
        row
    };
    let left = (pairs.len() > MOST)
        .then(|| format!("The first {MOST} of {} pairs; `search_comparisons.csv` has all.", pairs.len()));
    let rows = pairs.iter().take(MOST).map(row).collect();
    Table { title: title.into(), head, rows, notes: left.into_iter().collect() }
}

/// The difference with its interval; with too few runs for one, the values of the single runs.
fn difference(found: &SearchComparison) -> Value {
    match found.interval {
        Some(interval) => Value::Difference(Some(found.difference), Some(interval)),
        None => Value::Runs(found.differences.clone(), 2, true),
    }
}

fn probability(p: Option<f64>) -> String {
    match p {
        None => "no test".into(),
        Some(p) if p < 0.001 => "p < 0.001".into(),
        Some(p) => format!("p = {p:.3}"),
    }
}

/// What a terminal says below the table of falsifiers: which of them find more than by chance. None without any pair of falsifiers.
pub fn findings_of_pairs(compared: &[SearchComparison]) -> Option<String> {
    let of = |figure: &'static str| {
        let pairs = compared.iter().filter(move |found| found.is_of_falsifiers() && found.figure == figure);
        pairs.collect::<Vec<_>>()
    };
    let [(starts, _), (faults, _), _] = SHOWN;
    let all = of(starts);
    let runs = all.iter().map(|found| found.runs).max()?;
    if runs < 2 {
        return Some("One run of each falsifier cannot tell which one finds more: ask for `runs: 4` or more.".into());
    }
    let found =
        [(starts, "fails from more starts"), (faults, "finds faults from more of its starts")].map(|(figure, does)| {
            let pairs = of(figure);
            let told = pairs.iter().filter(|found| found.p_holm.is_some_and(|p| p < ALPHA)).count();
            (does, told, pairs.len())
        });
    Some(if found.iter().all(|(_, told, _)| *told == 0) {
        format!(
            "No falsifier fails from more starts, or finds faults from more of its starts, than another one beyond chance ({} pairs, {runs} runs): call it a tie.",
            all.len()
        )
    } else {
        let parts = found.map(|(does, told, pairs)| format!("one {does} than the other in {told} of {pairs} pairs"));
        format!(
            "Beyond chance (p < 0.05, {runs} runs), {}; call the rest ties. the table `search_comparisons` names them.",
            parts.join(", and ")
        )
    })
}
