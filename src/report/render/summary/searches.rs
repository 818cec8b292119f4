use std::fmt::Write;

use crate::report::{Average, MedianTime, SearchCell};

/// The part of a summary that compares falsifiers.
pub fn search_summary(cells: &[SearchCell]) -> String {
    let mut page = String::from(
        "\n## Searches\n\n\
         | falsifier | town | policy | runs × ticks | found in | ticks to first failure | failures of episodes | beginnings failed \
         | kinds of failures | tried afterwards |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for cell in cells {
        let key = &cell.key;
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} × {} | {} of {} | {} | {} | {} | {} | {} |",
            who(cell),
            key.town,
            key.policy,
            cell.runs,
            cell.budget,
            cell.runs - cell.censored,
            cell.runs,
            median(cell.first_failure),
            average(cell.failure_rate, 3),
            average(cell.failed_beginnings, 1),
            average(cell.distinct, 1),
            average(cell.tried_rate, 2),
        );
    }
    page.push_str(
        "\nEvery falsifier has the same budget of simulator ticks and meets the same beginnings in the same order; commands that the \
         budget cannot hold are not begun. Ticks to the first failure: the median by Kaplan and Meier, runs that found nothing \
         counted as censored, with the interval of Brookmeyer and Crowley; `..` stands for an end that the runs do not show. The other \
         intervals are Student's over runs (95 %). A falsifier that leaves a beginning when it has failed spends few episodes on \
         failures, so compare *beginnings failed*, not failures of episodes, between methods. Kinds: side of the impact, \
         car moving or standing, what its driver was doing. Tried afterwards: collision rate of the pedestrian that the falsifier ends up \
         with, in fresh episodes; `–` where it leaves none.\n",
    );
    page
}

/// The same for a terminal.
pub fn search_table(cells: &[SearchCell]) -> String {
    let head = ["falsifier", "town", "policy", "found", "first failure", "failed beginnings", "kinds", "tried", "n"];
    let mut rows = vec![head.map(String::from)];
    for cell in cells {
        let key = &cell.key;
        rows.push([
            who(cell),
            key.town.clone(),
            key.policy.clone(),
            format!("{} of {}", cell.runs - cell.censored, cell.runs),
            median(cell.first_failure),
            average(cell.failed_beginnings, 1),
            average(cell.distinct, 1),
            average(cell.tried_rate, 2),
            format!("{} × {}", cell.runs, cell.budget),
        ]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let line: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "  {}", line.join("  ").trim_end());
    }
    text
}

/// The falsifier; with the number of its block when that is not the first.
pub fn who(cell: &SearchCell) -> String {
    let key = &cell.key;
    if key.block == 0 { key.falsifier.clone() } else { format!("{} #{}", key.falsifier, key.block) }
}

pub fn median(time: MedianTime) -> String {
    let end = |end: Option<f64>| end.map_or(String::new(), |ticks| format!("{ticks}"));
    match (time.median, time.low) {
        (None, None) => "–".into(),
        (None, Some(low)) => format!("above {low}"),
        (Some(median), low) => format!("{median} ({}..{})", end(low), end(time.high)),
    }
}

pub fn average((mean, interval): Average, digits: usize) -> String {
    match (mean, interval) {
        (None, _) => "–".into(),
        (Some(mean), None) => format!("{mean:.digits$}"),
        // Runs that are all alike, as those of pedestrians that draw nothing, say nothing about a spread.
        (Some(mean), Some((low, high))) if low == high => format!("{mean:.digits$} (all alike)"),
        (Some(mean), Some((low, high))) => format!("{mean:.digits$} ({low:.digits$}..{high:.digits$})"),
    }
}
