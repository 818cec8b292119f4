use std::collections::BTreeMap;

use crate::report::SearchComparison;
use crate::report::render::table::{Column, Table, Value};

/// The greatest number of rows of a kind on a page; the file of the table has all.
const MOST: usize = 60;

/// The figures that the tables show, by the names of their columns in `searches`, and their heads.
const SHOWN: [(&str, &str); 4] = [
    ("failed_starts", "failed starts (95 %), p"),
    ("fault_starts", "starts with a fault (95 %), p"),
    ("fault_start_rate", "their share (95 %), p"),
    ("avoidable_injury_per_thousand", "avoidable injury / 1,000 (95 %), p"),
];

/// Below this a difference is a finding.
const ALPHA: f64 = 0.05;

/// Pairs of falsifiers and pairs of drivers, a table each; none of a kind without any pair.
pub fn search_pairs(compared: &[SearchComparison]) -> Vec<Table> {
    let kinds = [("Searches in pairs", true), ("Drivers in pairs", false)];
    let of = |(title, of_falsifiers)| {
        let found: Vec<_> = compared.iter().filter(|found| found.is_of_falsifiers() == of_falsifiers).collect();
        (!found.is_empty()).then(|| table(title, &found))
    };
    kinds.into_iter().filter_map(of).collect()
}

fn table(title: &str, found: &[&SearchComparison]) -> Table {
    let mut head: Vec<Column> = ["search", "place", "less"].map(Column::text).into();
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
    let left =
        (pairs.len() > MOST).then(|| format!("The first {MOST} of {} pairs; `comparisons.csv` has all.", pairs.len()));
    let rows = pairs.iter().take(MOST).map(row).collect();
    Table { title: title.into(), head, rows, notes: left.into_iter().collect(), ..Table::default() }
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

/// What a terminal says below the table of methods: which of them find more than by chance. `None` without any pair of falsifiers.
pub fn findings_of_pairs(compared: &[SearchComparison]) -> Option<String> {
    let pairs: Vec<&SearchComparison> = compared.iter().filter(|found| found.is_of_falsifiers()).collect();
    let runs = pairs.iter().map(|found| found.runs).max()?;
    if runs < 2 {
        return Some("One run of each search cannot tell which one finds more: ask for `runs: 4` or more.".into());
    }
    let [(starts, _), (faults, _), ..] = SHOWN;
    let figures = [(starts, "fails from more starts than"), (faults, "finds faults from more starts than")];
    let told: Vec<String> = figures.iter().flat_map(|(figure, does)| winners(&pairs, figure, does)).collect();
    Some(if told.is_empty() {
        format!(
            "In pairs, no search is shown to find more than another one ({runs} runs); the table `comparisons` has the intervals."
        )
    } else {
        format!(
            "In pairs, beyond chance (p < 0.05, {runs} runs): {}. The table `comparisons` has each pair and each figure.",
            told.join("; ")
        )
    })
}

/// The falsifiers that have more of a figure than others, each with the number of towns and drivers where that is so.
fn winners(pairs: &[&SearchComparison], figure: &str, does: &str) -> Vec<String> {
    let mut places: BTreeMap<(&str, &str), [usize; 2]> = BTreeMap::new();
    for found in pairs.iter().filter(|found| found.figure == figure) {
        let (one, other) = (found.one.0.as_str(), found.other.0.as_str());
        let is_told = found.p_holm.is_some_and(|p| p < ALPHA);
        for (better, worse, more) in [(one, other, found.difference > 0.0), (other, one, found.difference < 0.0)] {
            let [told, all] = places.entry((better, worse)).or_default();
            *told += usize::from(is_told && more);
            *all += 1;
        }
    }
    let told = places.into_iter().filter(|(_, [told, _])| *told > 0);
    told.map(|((better, worse), [told, all])| format!("`{better}` {does} `{worse}` in {told} of {all} places"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falsifier_finds_more_only_where_the_difference_is_beyond_chance() {
        let of = SearchComparison::of_failed_starts;
        let differences = [4.0, 5.0, 6.0];
        let told = |compared: &[SearchComparison]| findings_of_pairs(compared).unwrap();
        let (chance, meet) = ("chance", "meet");
        let clear = of("a", [chance, meet], &differences.map(|more| -more), 0.01);
        let unclear = of("b", [chance, meet], &differences, 0.3);
        assert!(
            told(&[clear, unclear.clone()]).contains("`meet` fails from more starts than `chance` in 1 of 2 places.")
        );
        assert!(told(&[unclear]).contains("no search is shown to find more"));
        assert!(told(&[of("a", [chance, meet], &[9.0], 0.01)]).contains("One run"));
        assert_eq!(findings_of_pairs(&[]), None);
    }

    #[test]
    fn a_pair_without_an_interval_shows_its_runs() {
        let pair = SearchComparison::of_failed_starts("a", ["chance", "meet"], &[4.0, 5.0, 6.0], 0.03);
        let tables = search_pairs(&[pair]);
        assert_eq!(tables.len(), 1, "no drivers are compared");
        let text = tables[0].to_markdown();
        assert!(text.contains("+4.00 +5.00 +6.00 (3 runs)<br>p = 0.030"), "{text}");
    }
}
