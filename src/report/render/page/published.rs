use std::fmt::Write;

use super::Contents;
use super::identity::Named;
use super::markup::escape;
use crate::report::render::summary::spread;
use crate::report::{Agreement, Beside};

/// What others have published beside ours, cell by cell; empty without any.
pub fn published(contents: &Contents<'_>, cells: &[Named<'_>]) -> String {
    if contents.published.is_empty() {
        return String::new();
    }
    let mut html = String::from("<section id=\"published\"><h2>Beside published figures</h2>");
    for table in contents.published.chunk_by(|a, b| a.source == b.source) {
        let first = &table[0];
        let _ = write!(
            html,
            "<h3>{} <small>({} trainings)</small></h3><div class=\"wide\"><table><thead><tr><th>pedestrian</th><th>town</th><th>driver</th>\
             <th>figure</th><th class=\"number\">published</th><th class=\"number\">here</th><th class=\"number\">difference, 95 %</th>\
             <th></th></tr></thead><tbody>",
            escape(first.source),
            first.published_runs
        );
        for beside in table {
            row(&mut html, beside, cells);
        }
        html.push_str("</tbody></table></div>");
        if !first.docs.is_empty() {
            let _ = write!(html, "<p>{}</p>", escape(first.docs));
        }
    }
    html.push_str(
        "<details><summary>How to read this</summary><p>Within its spread: no farther from the published mean than its standard deviation. \
         Indistinct: farther, but Welch’s 95 % interval of the difference, from the spreads between trainings here and there, holds 0. So \
         few trainings tell little apart.</p></details></section>",
    );
    html
}

fn row(html: &mut String, beside: &Beside<'_>, cells: &[Named<'_>]) {
    let who = cells.iter().find(|named| std::ptr::eq(named.cell, beside.cell)).map_or("", |named| &named.who);
    let interval = beside.interval.map_or(String::new(), |(low, high)| format!(" ({low:+.2} to {high:+.2})"));
    let difference = beside.difference.map_or("–".into(), |difference| format!("{difference:+.2}"));
    let agreement = beside.agreement();
    let class = if agreement == Agreement::Differs { " class=\"warn\"" } else { "" };
    let _ = write!(
        html,
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>\
         <td class=\"number\">{difference}{interval}</td><td{class}>{}</td></tr>",
        escape(who),
        escape(&beside.cell.key.town),
        escape(&beside.cell.key.policy),
        escape(&beside.published.column.replace('_', " ")),
        spread(beside.theirs()),
        spread(beside.ours),
        agreement.name(),
    );
}
