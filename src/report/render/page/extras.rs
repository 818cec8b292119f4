use std::fmt::Write;

use polars::prelude::{AnyValue, PolarsResult};

use super::ComparisonSection;
use super::markup::escape;

/// So many rows of a table at most; its file holds all.
const ROWS: usize = 120;

/// A table as it is, column by column.
///
/// # Errors
/// Those of polars; none for a table in memory.
pub fn extra(extra: &ComparisonSection) -> PolarsResult<String> {
    let table = &extra.table;
    if table.height() == 0 {
        return Ok(String::new());
    }
    let mut html = format!(
        "<section id=\"{}\"><h2>{}</h2><p class=\"lead\">{}</p><div class=\"wide\"><table><thead><tr>",
        escape(extra.id),
        escape(extra.title),
        escape(extra.lead)
    );
    let columns = table.columns();
    let class = |text: bool| if text { "" } else { " class=\"number\"" };
    let is_text = |column: &polars::prelude::Column| column.dtype().is_string();
    for column in columns {
        let _ = write!(html, "<th{}>{}</th>", class(is_text(column)), escape(&column.name().replace('_', " ")));
    }
    html.push_str("</tr></thead><tbody>");
    for row in 0..table.height().min(ROWS) {
        html.push_str("<tr>");
        for column in columns {
            let _ = write!(html, "<td{}>{}</td>", class(is_text(column)), escape(&shown(&column.get(row)?)));
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table></div>");
    let more = table.height().saturating_sub(ROWS);
    if more > 0 {
        let _ = write!(html, "<p>{more} more rows are in <a href=\"{0}.csv\">{0}.csv</a>.</p>", escape(extra.id));
    }
    Ok(html + "</section>")
}

/// A value to three digits.
fn shown(value: &AnyValue<'_>) -> String {
    match value {
        AnyValue::Null => "–".into(),
        AnyValue::String(text) => (*text).to_string(),
        AnyValue::StringOwned(text) => text.to_string(),
        AnyValue::Float64(number) => format!("{number:.3}"),
        other => other.to_string(),
    }
}
