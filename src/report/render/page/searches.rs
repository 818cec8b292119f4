use std::fmt::Write;

use super::super::summary::{average, median, who};
use super::markup::{count, escape};
use crate::report::SearchCell;

/// The falsifiers, compared; nothing without any.
pub fn searches(cells: &[SearchCell]) -> String {
    if cells.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<section id=\"searches\"><h2>Falsifiers compared</h2><div class=\"wide\"><table><thead><tr><th>falsifier</th><th>town</th>\
         <th>policy</th><th class=\"number\">runs × ticks</th><th class=\"number\">found in</th><th class=\"number\">ticks to first failure</th>\
         <th class=\"number\">beginnings failed</th><th class=\"number\">kinds</th><th class=\"number\">tried afterwards</th></tr></thead><tbody>",
    );
    for cell in cells {
        let _ = write!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td class=\"number\">{} × {}</td><td class=\"number\">{} of {}</td>\
             <td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td></tr>",
            escape(&who(cell)),
            escape(&cell.key.town),
            escape(&cell.key.policy),
            cell.runs,
            count(cell.budget),
            cell.runs - cell.censored,
            cell.runs,
            median(cell.first_failure),
            average(cell.failed_beginnings, 1),
            average(cell.distinct, 1),
            average(cell.tried_rate, 2),
        );
    }
    html.push_str(
        "</tbody></table></div><details><summary>How to read this</summary><p>Every falsifier has the same budget of simulator ticks and meets \
         the same beginnings in the same order. Ticks to the first failure: the median by Kaplan and Meier, runs that found nothing \
         counted as censored. Other intervals are Student’s over runs (95 %).</p></details></section>",
    );
    html
}
