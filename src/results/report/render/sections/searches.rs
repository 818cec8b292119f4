use super::search_pairs::search_pairs;
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Average, MedianTime, SearchCell, SearchComparison};
use compile::SearchKey;

/// The falsifiers, and which of them find more than another one.
pub fn search_section(cells: &[SearchCell], compared: &[SearchComparison]) -> Section {
    let reading = [
        "Every falsifier has the same budget of simulator ticks and meets the same starts in the same order. A command that the \
         rest of the budget cannot hold is not started.",
        "*Ticks to first failure* is the median of Kaplan and Meier. Runs without a failure count as censored. The interval is \
         Brookmeyer and Crowley's; `≥` and `≤` stand where the runs show one end alone. The other intervals are Student's 95 % over runs. They are \
         about further runs in *this* town; other towns may give other figures, and no interval here covers that. Fewer than four runs have no \
         interval; their single values stand there.",
        "*Failed starts* are those from which a failure was found, of the number of starts from which it searched; *starts with a fault* those from which a \
         fault was. With the same budget one falsifier may spend all ticks on few starts, and another visit many.",
        "Compare these two between methods. *Faults found* may be many variations of one start, and a falsifier that leaves a start when it has failed \
         spends few episodes on failures. Kinds of failures are the different cells that were filled: place on the car, direction of the walk, both speeds, what the driver did at the touch. \
         A *fault* is a failure that counts against the driver. \
         Where a search has a goal, failures are its violations, and faults those of them that count against the driver; a goal without a verdict has none. \
         *Simulations to it* are finished episodes, over the runs with a failure, as ARCH-COMP counts them. \
         *Evaluated afterwards* are the failure rate and the rate of faults of the controller with which the falsifier \
         ends, in fresh episodes; `–` if there is none.",
        "*Pairs:* one falsifier less another one against the same driver, and one driver less another one with the same falsifier, run by run: \
         equal runs have the same starts. p is Student's, after Holm's correction for all pairs of falsifiers, or of drivers, in all towns: in 95 % of \
         campaigns no p below 0.05 of a column is a false finding. Call it a tie above 0.05. `search_comparisons` has further figures.",
    ];
    Section {
        id: "searches",
        name: "Falsifiers",
        title: "Falsifiers compared",
        tables: [falsifiers(cells)].into_iter().chain(search_pairs(compared)).collect(),
        notes: outdone_by_chance(cells).into_iter().chain(reading.map(String::from)).collect(),
    }
}

/// A row for each falsifier, town and driver.
pub fn falsifiers(cells: &[SearchCell]) -> Table {
    let mut head: Vec<Column> = ["falsifier", "town", "policy"].map(Column::text).into();
    // Estimates are left-aligned, so that their numbers are below each other.
    head.extend([
        Column::number("runs × ticks").detail(),
        Column::number("runs with a failure"),
        Column::text("ticks to first failure"),
        Column::text("simulations to it, mean and median").page_only(),
        Column::text("failures of episodes").detail(),
        Column::text("failed starts"),
        Column::text("kinds of failures").page_only(),
        Column::text("starts with a fault"),
        Column::text("faults found").page_only(),
        Column::text("kinds of these per million ticks").detail(),
        Column::text("evaluated afterwards").page_only(),
        Column::text("fault").detail(),
    ]);
    let row = |cell: &SearchCell| {
        vec![
            who(cell).into(),
            Value::from(&cell.key.town),
            Value::from(&cell.key.policy),
            Value::Times(cell.runs as u64, cell.budget),
            Value::Of((cell.runs - cell.censored) as u64, cell.runs as u64),
            median(cell.first_failure).into(),
            cell.simulations_to_first()
                .map_or_else(|| "–".into(), |(mean, median)| format!("{mean:.0}, {median:.0}"))
                .into(),
            average(&cell.failure_rate, 3),
            failed_starts(cell),
            average(&cell.distinct, 1),
            of_starts(&cell.fault_starts, &cell.starts),
            average(&cell.fault, 1),
            average(&cell.distinct_faults_per_million, 1),
            average(&cell.evaluated_rate, 2),
            average(&cell.evaluated_faults_rate, 3),
        ]
    };
    Table { head, rows: cells.iter().map(row).collect(), ..Table::default() }
}

/// A note on the falsifiers that found failures from fewer starts than random walking did with the same budget; none without any.
fn outdone_by_chance(cells: &[SearchCell]) -> Option<String> {
    let outdone = |cell: &&SearchCell| {
        let chance = cells.iter().filter(|other| {
            let same = |key: &SearchKey| (key.block, key.town.clone(), key.policy.clone());
            other.key.method == "random" && cell.key.method != "random" && same(&other.key) == same(&cell.key)
        });
        chance.map(|chance| chance.failed_starts.mean).any(|found| found > cell.failed_starts.mean)
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
    let SearchCell { key, goal, .. } = cell;
    let block = if key.block == 0 { String::new() } else { format!(" #{}", key.block) };
    let goal = goal.as_ref().map_or_else(String::new, |goal| format!(", goal {goal}"));
    format!("{}{block}{goal}", key.falsifier)
}

fn median(time: MedianTime) -> String {
    match (time.median, time.low, time.high) {
        (None, None, _) => "–".into(),
        (None, Some(low), _) => format!("above {low}"),
        (Some(median), Some(low), Some(high)) => format!("{median} ({low}..{high})"),
        (Some(median), Some(low), None) => format!("{median} (≥ {low})"),
        (Some(median), None, Some(high)) => format!("{median} (≤ {high})"),
        (Some(median), None, None) => format!("{median}"),
    }
}

/// The starts from which a failure was found, of those from which the falsifier searched.
pub fn failed_starts(cell: &SearchCell) -> Value {
    of_starts(&cell.failed_starts, &cell.starts)
}

/// A number of starts of all starts from which a falsifier searched: the means over runs, or each of few runs.
fn of_starts(found: &Average, starts: &Average) -> Value {
    if found.interval.is_some() || found.by_run.len() != starts.by_run.len() || found.by_run.is_empty() {
        return format!("{} of {:.0}", average(found, 1), starts.mean.unwrap_or(0.0)).into();
    }
    let runs = found.by_run.iter().zip(&starts.by_run);
    let each: Vec<String> = runs.map(|(found, all)| format!("{found:.0} of {all:.0}")).collect();
    each.join(", ").into()
}

/// The mean with its interval; of two or three runs the single values.
pub fn average(average: &Average, digits: usize) -> Value {
    match (average.interval, average.by_run.len()) {
        (None, 2..) => Value::Runs(average.by_run.clone(), digits, false),
        (interval, _) => Value::Estimate(average.mean, interval, digits),
    }
}
