use std::collections::BTreeMap;

use crate::record::columns::{DRIVER, TOWN};
use crate::report::SearchPair;
use crate::report::render::table::{Column, Selection, Table, Value};
use crate::tables::metrics::RUNS;
use crate::tables::{DIFFERENCE, DIFFERENCES, FIGURE, IS_OF_METHODS, METHOD, OTHER, P_HOLM};

/// Maximum number of rows of a kind on a page; the file of the table has all.
const MAX_PAIRS: usize = 60;

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
pub fn search_pairs(compared: &[SearchPair]) -> Vec<Table> {
    let kinds = [("Searches in pairs", true), ("Drivers in pairs", false)];
    let of = |(title, of_falsifiers)| {
        let found: Vec<_> = compared.iter().filter(|found| found.holds(&IS_OF_METHODS) == of_falsifiers).collect();
        (!found.is_empty()).then(|| table(title, &found))
    };
    kinds.into_iter().filter_map(of).collect()
}

fn table(title: &str, found: &[&SearchPair]) -> Table {
    // The figures of a pair are consecutive.
    let pairs: Vec<&[&SearchPair]> = found.chunk_by(|one, next| one.key == next.key).collect();
    let shown = Selection::new()
        .text("search", |pair: &&[&SearchPair]| pair[0].text(&METHOD))
        .text("place", |pair| format!("{} · {}", pair[0].text(&TOWN), pair[0].text(&DRIVER)))
        .text("less", |pair| other(pair[0], if pair[0].holds(&IS_OF_METHODS) { METHOD.name } else { DRIVER.name }))
        .each(
            SHOWN,
            |(_, head)| Column::number(*head),
            |(figure, _), pair| {
                let found = pair.iter().find(|each| each.text(&FIGURE) == *figure)?;
                // With too few runs for an interval, the values of the single runs.
                let difference = match found.ends(DIFFERENCE) {
                    None => Value::runs(found.list(DIFFERENCES), 2, true),
                    interval => Value::difference(found.number(DIFFERENCE), interval),
                };
                Some(Value::Lines(vec![difference, probability(found.number(P_HOLM)).into()]))
            },
        );
    first_pairs(Table { title: title.into(), ..shown.table(&pairs) })
}

/// The first pairs of a table that is too long for a page; its file has all.
pub fn first_pairs(mut table: Table) -> Table {
    let all = table.rows.len();
    if all > MAX_PAIRS {
        table.rows.truncate(MAX_PAIRS);
        table.notes.push(format!("The first {MAX_PAIRS} of {all} pairs; `comparisons.csv` has all."));
    }
    table
}

/// A name of the other side.
fn other(pair: &SearchPair, column: &str) -> String {
    pair.text_of(&format!("{column}{OTHER}"))
}

/// A probability after Holm's correction.
pub fn probability(p: Option<f64>) -> String {
    match p {
        None => "no test".into(),
        Some(p) if p < 0.001 => "p < 0.001".into(),
        Some(p) => format!("p = {p:.3}"),
    }
}

/// What a terminal says below the table of methods: which of them find more than by chance. `None` without any pair of falsifiers.
pub fn findings_of_pairs(compared: &[SearchPair]) -> Option<String> {
    let pairs: Vec<&SearchPair> = compared.iter().filter(|found| found.holds(&IS_OF_METHODS)).collect();
    let runs = pairs.iter().map(|found| found.whole_number(RUNS.name)).max()?;
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
fn winners(pairs: &[&SearchPair], figure: &str, does: &str) -> Vec<String> {
    let mut places: BTreeMap<(String, String), [usize; 2]> = BTreeMap::new();
    for found in pairs.iter().filter(|found| found.text(&FIGURE) == figure) {
        let (one, other) = (found.text(&METHOD), other(found, METHOD.name));
        let is_told = found.number(P_HOLM).is_some_and(|p| p < ALPHA);
        let difference = found.number(DIFFERENCE).unwrap_or_default();
        let sides = [((one.clone(), other.clone()), difference > 0.0), ((other, one), difference < 0.0)];
        for (sides, more) in sides {
            let [told, all] = places.entry(sides).or_default();
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
    use polars::prelude::{Column as Values, DataFrame, NamedFrom, PlSmallStr, Scalar, Series};

    use super::*;
    use crate::tables::Rows;

    /// Two falsifiers against one driver in a town, by their failed starts.
    fn pair(town: &str, sides: [&str; 2], differences: &[f64], p_holm: f64) -> SearchPair {
        let text = |name: &str, text: &str| Values::new_scalar(name.into(), Scalar::from(PlSmallStr::from(text)), 1);
        let number = |name: &str, number: f64| Values::new_scalar(name.into(), Scalar::from(number), 1);
        let columns = vec![
            text(TOWN.name, town),
            text(DRIVER.name, "driver"),
            text(METHOD.name, sides[0]),
            text(&format!("{}{OTHER}", METHOD.name), sides[1]),
            text(FIGURE.name, "failed_starts"),
            Values::new_scalar(IS_OF_METHODS.name.into(), Scalar::from(true), 1),
            number(RUNS.name, differences.len() as f64),
            number(DIFFERENCE, differences.iter().sum::<f64>() / differences.len() as f64),
            number(P_HOLM, p_holm),
            Series::new(DIFFERENCES.into(), [Series::new("".into(), differences)]).into(),
        ];
        Rows::new(DataFrame::new(1, columns).unwrap(), |_, _| Ok(0)).unwrap()[0].clone()
    }

    #[test]
    fn a_falsifier_finds_more_only_where_the_difference_is_beyond_chance() {
        let differences = [4.0, 5.0, 6.0];
        let told = |compared: &[SearchPair]| findings_of_pairs(compared).unwrap();
        let (chance, meet) = ("chance", "meet");
        let clear = pair("a", [chance, meet], &differences.map(|more| -more), 0.01);
        let unclear = pair("b", [chance, meet], &differences, 0.3);
        assert!(
            told(&[clear, unclear.clone()]).contains("`meet` fails from more starts than `chance` in 1 of 2 places.")
        );
        assert!(told(&[unclear]).contains("no search is shown to find more"));
        assert!(told(&[pair("a", [chance, meet], &[9.0], 0.01)]).contains("One run"));
        assert_eq!(findings_of_pairs(&[]), None);
    }

    #[test]
    fn a_pair_without_an_interval_shows_its_runs() {
        let shown = pair("a", ["chance", "meet"], &[4.0, 5.0, 6.0], 0.03);
        let tables = search_pairs(&[shown]);
        assert_eq!(tables.len(), 1, "no drivers are compared");
        let text = tables[0].to_markdown();
        assert!(text.contains("+4.00 +5.00 +6.00 (3 runs)<br>p = 0.030"), "{text}");
    }
}
