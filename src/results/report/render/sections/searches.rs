use super::search_pairs::{findings_of_pairs, search_pairs};
use crate::record::in_block;
use crate::report::render::table::{Column, Depth, Place, Section, Selection, Table, Value};
use crate::report::{Findings, Rate, SearchCell};
use crate::tables::{
    FAILED_STARTS, FAULT_COUNT, FAULT_STARTS, FIRST_FAILURE, GOAL, SIMULATIONS_MEAN, SIMULATIONS_MEDIAN, STARTS,
    median_column,
};
use compile::SearchKey;

/// How to read the tables.
const READING: [&str; 4] = [
    "Every search has the same budget of simulator ticks and meets the same starts in the same order. A command that the \
     rest of the budget cannot hold is not started.",
    "*Ticks to first failure* is the median of Kaplan and Meier; runs without a failure count as censored. *Simulations to it* are finished episodes, over the runs \
     with a failure, as ARCH-COMP counts them. Intervals are Student's 95 % over runs. They are about further runs in *this* town; other towns may give \
     other figures, and no interval here covers that. Fewer than four runs have no interval; their single values stand there.",
    "*Failed starts* are those from which a failure was found, of the number of starts from which it searched; *starts with a fault* those from which a \
     fault was. Compare these two between searches. *Faults found* may be many variations of one start. Where a search has a goal, failures are its violations, and \
     faults those of them that count against the driver; a goal without a verdict has none.",
    "*Pairs:* one search less another one against the same driver, and one driver less another one with the same search, run by run: \
     equal runs have the same starts. p is Student's, after Holm's correction for all pairs of searches, or of drivers, in all towns: in 95 % of \
     campaigns no p below 0.05 of a column is a false finding. Above 0.05 no difference is shown; the interval says how large it may be.",
];

/// The falsifiers, and which of them find more than another one; `None` without a search.
pub fn searches(found: &Findings<'_>) -> Option<Section> {
    let (cells, compared) = (&found.searches, &found.search_pairs);
    // Nothing is known of a search that tried no start.
    let is_known = !cells.iter().any(SearchCell::is_empty);
    (!cells.is_empty()).then(|| Section {
        id: "searches",
        name: "Searches",
        title: "Searches compared",
        depth: Depth::Page,
        lead: outdone_by_chance(cells).into_iter().collect(),
        tables: [falsifiers(cells)].into_iter().chain(search_pairs(compared)).collect(),
        notes: READING.map(String::from).into(),
        lines: findings_of_pairs(compared).filter(|_| is_known).into_iter().collect(),
        ..Section::default()
    })
}

/// A row for each falsifier, town and driver.
fn falsifiers(cells: &[SearchCell]) -> Table {
    // Estimates are left-aligned, so that their numbers are below each other.
    let shown = Selection::new()
        .text("search", who)
        .text("town", |cell: &SearchCell| cell.key.town.clone())
        .text("driver", |cell| cell.key.policy.clone())
        .column(Column::number("runs × ticks").detail(), |cell| Value::Times(cell.runs()[0], cell.budget()))
        .number("runs with a failure", |cell| {
            let [runs, falsified] = cell.runs();
            Value::Of(falsified, runs)
        })
        .number("ticks to first failure", |cell| Value::number(cell.number(&median_column(FIRST_FAILURE)), 0))
        .column(Column::text("simulations to it, mean and median").page_only(), |cell| {
            let simulations = cell.number(SIMULATIONS_MEAN.name).zip(cell.number(SIMULATIONS_MEDIAN.name));
            simulations.map(|(mean, median)| format!("{mean:.0}, {median:.0}"))
        })
        .text("failed starts", failed_starts)
        .text("starts with a fault", |cell| of_starts(&cell.rate(FAULT_STARTS), &cell.rate(STARTS.name)))
        .column(Column::text("faults found").page_only(), |cell| Value::average(&cell.rate(FAULT_COUNT), 1));
    Table { place: Place::Everywhere, ..shown.table(cells) }
}

/// A note on the falsifiers that found failures from fewer starts than random walking did with the same budget; `None` without any.
fn outdone_by_chance(cells: &[SearchCell]) -> Option<String> {
    let outdone = |cell: &&SearchCell| {
        let chance = cells.iter().filter(|other| {
            let same = |key: &SearchKey| (key.block, key.town.clone(), key.policy.clone());
            other.key.method == "random" && cell.key.method != "random" && same(&other.key) == same(&cell.key)
        });
        let found = |cell: &SearchCell| cell.rate(FAILED_STARTS).value;
        chance.map(found).any(|chance| chance > found(cell))
    };
    let names: Vec<String> = cells.iter().filter(outdone).map(SearchCell::in_full).collect();
    (!names.is_empty()).then(|| {
        format!(
            "**Random walking failed from more starts** than {}, with the same budget. Where collisions are common, a directed search has little to \
             improve; compare faults, or choose rarer ones.",
            names.join("; than ")
        )
    })
}

/// The falsifier, with the requirement that it tried to violate; with the number of its block when that is not the first.
pub fn who(cell: &SearchCell) -> String {
    let (key, goal) = (&cell.key, cell.text(&GOAL));
    let goal = if goal.is_empty() { goal } else { format!(", goal {goal}") };
    format!("{}{}{goal}", key.falsifier, in_block("search", key.block))
}

/// The starts from which a failure was found, of those from which the falsifier searched.
pub fn failed_starts(cell: &SearchCell) -> Value {
    of_starts(&cell.rate(FAILED_STARTS), &cell.rate(STARTS.name))
}

/// A number of starts of all starts from which a falsifier searched: the means over runs, or each of few runs.
fn of_starts(found: &Rate, starts: &Rate) -> Value {
    if found.interval.is_some() || found.by_run.len() != starts.by_run.len() || found.by_run.is_empty() {
        return format!("{} of {:.0}", Value::average(found, 1), starts.value.unwrap_or(0.0)).into();
    }
    let runs = found.by_run.iter().zip(&starts.by_run);
    let each: Vec<String> = runs.map(|(found, all)| format!("{found:.0} of {all:.0}")).collect();
    each.join(", ").into()
}
