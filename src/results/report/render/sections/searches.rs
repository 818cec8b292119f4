use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Average, MedianTime, SearchCell};
use compile::SearchKey;

/// The comparison of falsifiers.
pub fn search_section(cells: &[SearchCell]) -> Section {
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
        Column::text("faults found"),
        Column::text("starts with one").page_only(),
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
            average(&cell.fault, 1),
            average(&cell.fault_start_rate, 3),
            average(&cell.distinct_faults_per_million, 1),
            average(&cell.evaluated_rate, 2),
            average(&cell.evaluated_faults_rate, 3),
        ]
    };
    let reading = [
        "Every falsifier has the same budget of simulator ticks and meets the same starts in the same order. A command that the \
         rest of the budget cannot hold is not started.",
        "*Ticks to first failure* is the median of Kaplan and Meier. Runs without a failure count as censored. The interval is \
         Brookmeyer and Crowley's; `≥` and `≤` stand where the runs show one end alone. The other intervals are Student's 95 % over runs. They are \
         about further runs in *this* town; other towns may give other figures, and no interval here covers that. Fewer than four runs have no \
         interval; their single values stand there.",
        "*Failed starts* are those from which a failure was found, of the number of starts from which it searched (means over runs). With the same budget \
         one falsifier may spend all ticks on few starts, and another visit many.",
        "A falsifier that leaves a start when it has failed spends few episodes on failures. So compare *failed starts* between \
         methods, not failures of episodes. Kinds of failures are the different cells that were filled: place on the car, direction of the walk, both speeds, what the driver did at the touch. \
         A *fault* is a failure that counts against the driver. \
         Where a search has a goal, failures are its violations, and faults those of them that count against the driver; a goal without a verdict has none. \
         *Simulations to it* are finished episodes, over the runs with a failure, as ARCH-COMP counts them. \
         *Evaluated afterwards* are the failure rate and the rate of faults of the controller with which the falsifier \
         ends, in fresh episodes; `–` if there is none. Pairs of falsifiers and of drivers are compared in `search_comparisons`; \
         its `p_holm` is adjusted for all pairs of falsifiers, or of drivers, in all towns.",
    ];
    Section {
        id: "searches",
        name: "Falsifiers",
        title: "Falsifiers compared",
        tables: vec![Table { head, rows: cells.iter().map(row).collect(), ..Table::default() }],
        notes: outdone_by_chance(cells).into_iter().chain(reading.map(String::from)).collect(),
    }
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

/// The falsifier; with the number of its block when that is not the first.
fn who(cell: &SearchCell) -> String {
    let key = &cell.key;
    if key.block == 0 { key.falsifier.clone() } else { format!("{} #{}", key.falsifier, key.block) }
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
    let found = &cell.failed_starts;
    let each = || found.by_run.iter().map(|run| format!("{run:.0}")).collect::<Vec<_>>().join(" ");
    let found = if found.interval.is_none() { each() } else { average(found, 1).to_string() };
    format!("{found} of {:.0}", cell.starts.mean.unwrap_or(0.0)).into()
}

/// The mean with its interval; of two or three runs the single values.
pub fn average(average: &Average, digits: usize) -> Value {
    match (average.interval, average.by_run.len()) {
        (None, 2..) => Value::Runs(average.by_run.clone(), digits, false),
        (interval, _) => Value::Estimate(average.mean, interval, digits),
    }
}
