use std::collections::BTreeMap;

use polars::prelude::DataFrame;

use super::searches::Figures;
use crate::campaign::SearchResult;
use crate::compile::SearchKey;
use crate::record::columns::TOWN;
use crate::record::{Column, Interval, Table};
use crate::statistics::{holm, mean_interval, mean_p};

/// Two falsifiers against one driver, or one falsifier against two drivers, compared run by run: equal runs have equal starts.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchComparison {
    town: String,
    /// Falsifier and driver of either side.
    one: (String, String),
    other: (String, String),
    /// The number of the block in the campaign.
    block: u32,
    figure: &'static str,
    /// Runs with the figure on both sides.
    runs: u64,
    /// Means over these.
    values: [f64; 2],
    difference: f64,
    student: Option<(f64, f64)>,
    p: Option<f64>,
    p_holm: Option<f64>,
}

/// The stem of the files of the table.
pub const SEARCH_COMPARISONS: &str = "search_comparisons";

/// All comparisons of the searches of a campaign, in the order of their first side.
///
/// Holm's correction covers the tests of one question: the same figure and the same two falsifiers or the same two drivers, in all places.
pub fn search_comparisons(results: &[SearchResult]) -> Vec<SearchComparison> {
    let mut cells: Vec<Vec<(&SearchResult, Figures)>> = Vec::new();
    for result in results {
        let entry = (result, Figures::new(result));
        match cells.iter_mut().find(|cell| cell[0].0.key.is_of_same_cell(&result.key)) {
            Some(cell) => cell.push(entry),
            None => cells.push(vec![entry]),
        }
    }
    let mut all = Vec::new();
    for (place, one) in cells.iter().enumerate() {
        for other in &cells[place + 1..] {
            let (a, b) = (&one[0].0.key, &other[0].0.key);
            let one_differs = (a.falsifier == b.falsifier) != (a.policy == b.policy);
            if a.town == b.town && a.block == b.block && one_differs {
                all.extend(compare(one, other, (a, b)));
            }
        }
    }
    let mut families: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (place, each) in all.iter().enumerate().filter(|(_, each)| each.p.is_some()) {
        let same_driver = each.one.1 == each.other.1;
        let pair = if same_driver { (&each.one.0, &each.other.0) } else { (&each.one.1, &each.other.1) };
        families.entry((each.figure, same_driver, pair.0.clone(), pair.1.clone())).or_default().push(place);
    }
    for family in families.values() {
        let p: Vec<f64> = family.iter().filter_map(|place| all[*place].p).collect();
        for (place, adjusted) in family.iter().zip(holm(&p)) {
            all[*place].p_holm = Some(adjusted);
        }
    }
    all
}

/// The comparisons of two cells, one for each figure that both have.
fn compare(
    one: &[(&SearchResult, Figures)],
    other: &[(&SearchResult, Figures)],
    (a, b): (&SearchKey, &SearchKey),
) -> Vec<SearchComparison> {
    let count = one.first().map_or(0, |(_, figures)| figures.compared().len());
    let comparison = |figure: usize| {
        let pairs: Vec<(f64, f64)> = one
            .iter()
            .filter_map(|(result, figures)| {
                let same = other.iter().find(|(each, _)| each.key.run == result.key.run)?;
                figures.compared()[figure].1.zip(same.1.compared()[figure].1)
            })
            .collect();
        let n = pairs.len() as f64;
        let differences: Vec<f64> = pairs.iter().map(|(one, other)| one - other).collect();
        (!pairs.is_empty()).then(|| SearchComparison {
            town: a.town.clone(),
            one: (a.falsifier.clone(), a.policy.clone()),
            other: (b.falsifier.clone(), b.policy.clone()),
            block: a.block,
            figure: one[0].1.compared()[figure].0,
            runs: pairs.len() as u64,
            values: [
                pairs.iter().map(|pair| pair.0).sum::<f64>() / n,
                pairs.iter().map(|pair| pair.1).sum::<f64>() / n,
            ],
            difference: differences.iter().sum::<f64>() / n,
            student: mean_interval(&differences).1,
            p: mean_p(&differences),
            p_holm: None,
        })
    };
    (0..count).filter_map(comparison).collect()
}

/// The comparisons as a table, one row each.
pub fn search_comparison_table(all: &[SearchComparison]) -> DataFrame {
    search_comparison_columns().frame(all)
}

/// The columns of [`search_comparison_table`].
pub fn search_comparison_columns() -> Table<'static, SearchComparison> {
    let text = Column::<String>::new;
    let number = Column::<f64>::new;
    Table::new(
        SEARCH_COMPARISONS,
        "One row for each figure, town, and two falsifiers against one driver or one falsifier against two drivers. Equal runs have equal \
         starts, so runs are pairs.",
    )
    .column(TOWN.of(|row: &SearchComparison| row.town.clone()))
    .column(text("falsifier", "", "name of the falsifier").of(|row: &SearchComparison| row.one.0.clone()))
    .column(text("policy", "", "driving policy").of(|row: &SearchComparison| row.one.1.clone()))
    .column(text("other_falsifier", "", "falsifier that is subtracted").of(|row: &SearchComparison| row.other.0.clone()))
    .column(text("other_policy", "", "its driving policy").of(|row: &SearchComparison| row.other.1.clone()))
    .column(
        Column::<u64>::new("block", "", "number of the `search` block in its campaign, from 0")
            .of(|row: &SearchComparison| u64::from(row.block)),
    )
    .column(text("figure", "", "column of `searches` that is compared").of(|row: &SearchComparison| row.figure.to_string()))
    .column(Column::<u64>::new("runs", "", "runs on both sides").of(|row: &SearchComparison| row.runs))
    .column(number("value", "", "mean over these runs").of(|row: &SearchComparison| row.values[0]))
    .column(number("other_value", "", "mean of the other side").of(|row: &SearchComparison| row.values[1]))
    .column(number("difference", "", "`value` less `other_value`").of(|row: &SearchComparison| row.difference))
    .columns(
        Interval::new("difference", "", "Student's 95 % interval over the pairs of runs; missing for a single run")
            .of(|row: &SearchComparison| row.student),
    )
    .column(
        number("p", "", "two-sided p-value of Student's paired test; missing for a single run and where all pairs are equal")
            .of(|row: &SearchComparison| row.p),
    )
    .column(
        number(
            "p_holm",
            "",
            "`p` adjusted by Holm's method for all rows of the same figure and the same two falsifiers, or the same two drivers",
        )
        .of(|row: &SearchComparison| row.p_holm),
    )
}
