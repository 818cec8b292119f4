use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::summary::spread;
use super::Contents;
use super::identity::{Named, RATES, RunRates, places};
use super::markup::{escape, percent};
use crate::record::CellKey;
use crate::report::{Beside, Spread};
use crate::statistics::wilson;

/// Width and height of the picture of a rate.
const SIZE: (f64, f64) = (136.0, 26.0);
/// Its margin at both ends.
const END: f64 = 6.0;

/// The table of cells: for each the rates with their intervals, and every run.
pub fn results(contents: &Contents<'_>, cells: &[Named<'_>], rates: &BTreeMap<CellKey, RunRates>) -> String {
    let mut html = String::from(
        "<section id=\"results\"><h2>How often cars are hit</h2><div class=\"wide\"><table class=\"results\"><thead><tr>\
         <th scope=\"col\">pedestrian</th><th scope=\"col\" class=\"number\">runs × episodes</th>\
         <th scope=\"col\">any collision</th><th scope=\"col\">with a moving car</th><th scope=\"col\">preventable</th>\
         <th scope=\"col\" class=\"number\">impact speed</th><th scope=\"col\" class=\"number\">length</th></tr>",
    );
    html.push_str("<tr class=\"scale\"><td colspan=\"2\"></td>");
    for _ in RATES {
        let _ = write!(html, "<td>{}</td>", scale());
    }
    html.push_str("<td class=\"number\">m/s</td><td class=\"number\">s</td></tr></thead>");
    for (place, members) in places(cells) {
        let _ = write!(html, "<tbody><tr><th colspan=\"7\" scope=\"rowgroup\">{}</th></tr>", escape(place));
        for named in members {
            row(&mut html, contents, named, rates.get(&named.cell.key));
        }
        html.push_str("</tbody>");
    }
    html.push_str("</table></div>");
    html.push_str(
        "<details><summary>How to read this</summary><p>Rates are shares of all episodes. The large dot is the mean over runs, each a \
         training of its own; small dots are the runs. The bar is Wilson's 95 % interval over the episodes of all runs: what \
         more episodes of these trainings would show, not what more trainings would. “±” is the standard deviation over runs. \
         <em>Preventable</em>: both careful human drivers would have avoided it. Pedestrians of a place meet the same beginnings. \
         Untrained pedestrians do the same for every reward and stand here once.",
    );
    if !contents.published.is_empty() {
        html.push_str(" A hollow diamond is what others have published.");
    }
    html.push_str("</p></details></section>");
    html
}

fn row(html: &mut String, contents: &Contents<'_>, named: &Named<'_>, rates: Option<&RunRates>) {
    let cell = named.cell;
    let errors =
        if cell.errors > 0 { format!(" <em class=\"warn\">{} in error</em>", cell.errors) } else { String::new() };
    let _ = write!(
        html,
        "<tr><th scope=\"row\"><i class=\"dot f{}\"></i>{}</th><td class=\"number\">{} × {}{errors}</td>",
        named.colour,
        escape(&named.who),
        cell.runs,
        cell.episodes / cell.runs.max(1),
    );
    let empty = RunRates::default();
    let rates = rates.unwrap_or(&empty);
    for (number, spread_over_runs) in [cell.collision, cell.moving, cell.preventable].into_iter().enumerate() {
        let same =
            |beside: &&Beside<'_>| beside.published.column == RATES[number].name && std::ptr::eq(beside.cell, cell);
        let published = contents.published.iter().find(same);
        let interval = wilson(rates.failures[number], rates.episodes);
        let colour = if number == 2 { "v0".into() } else { format!("f{}", named.colour) };
        let _ = write!(
            html,
            "<td><div class=\"rate\">{}",
            picture(&colour, spread_over_runs, interval, &rates.rates[number], published)
        );
        let _ = write!(html, "<span>{}</span></div></td>", spread(spread_over_runs));
    }
    let _ = write!(
        html,
        "<td class=\"number\">{}</td><td class=\"number\">{}</td></tr>",
        tenths(cell.impact_speed),
        tenths(cell.length)
    );
}

fn tenths(value: Spread) -> String {
    match (value.mean, value.sd) {
        (None, _) => "–".into(),
        (Some(mean), None) => format!("{mean:.1}"),
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.1}"),
    }
}

fn at(rate: f64) -> f64 {
    END + rate.clamp(0.0, 1.0) * (SIZE.0 - 2.0 * END)
}

/// The axis above a column of rates.
fn scale() -> String {
    let mut svg = svg("aria-hidden=\"true\"");
    for (rate, text) in [(0.0, "0"), (0.5, "½"), (1.0, "1")] {
        let _ = write!(svg, "<text class=\"muted middle\" x=\"{:.1}\" y=\"16\">{text}</text>", at(rate));
    }
    svg + "</svg>"
}

fn svg(attributes: &str) -> String {
    format!(
        "<svg class=\"panel\" width=\"{w:.0}\" height=\"{h:.0}\" viewBox=\"0 0 {w:.0} {h:.0}\" {attributes}>",
        w = SIZE.0,
        h = SIZE.1
    )
}

/// A rate with its interval and the rates of its runs.
fn picture(
    colour: &str,
    mean: Spread,
    (low, high): (f64, f64),
    runs: &[f64],
    published: Option<&Beside<'_>>,
) -> String {
    let Some(mean) = mean.mean else { return svg("aria-hidden=\"true\"") + "</svg>" };
    let says = format!("{}, interval {} to {}", percent(mean), percent(low), percent(high));
    let mut text = svg(&format!("role=\"img\" aria-label=\"{says}\""));
    let middle = SIZE.1 / 2.0;
    let _ = write!(text, "<title>{says}</title>");
    for rate in [0.0, 0.5, 1.0] {
        let _ = write!(text, "<path class=\"grid\" d=\"M{:.1} 0V{:.0}\"/>", at(rate), SIZE.1);
    }
    let _ = write!(
        text,
        "<rect class=\"{colour}\" opacity=\".32\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"9\" rx=\"2\"/>",
        at(low),
        middle - 4.5,
        at(high) - at(low)
    );
    if runs.len() > 1 {
        for rate in runs {
            let _ = write!(
                text,
                "<circle class=\"{colour}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"1.6\" opacity=\".75\"/>",
                at(*rate),
                middle + 9.0
            );
        }
    }
    let _ = write!(text, "<circle class=\"{colour} knob\" cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3.4\"/>", at(mean));
    if let Some(beside) = published {
        let theirs = beside.published;
        let _ = write!(
            text,
            "<path class=\"axis theirs\" d=\"M{:.1} {:.1}l4.5 4.5l-4.5 4.5l-4.5 -4.5z\"><title>{}: {}</title></path>",
            at(theirs.mean),
            middle - 4.5,
            escape(beside.source),
            spread(Spread { mean: Some(theirs.mean), sd: theirs.sd })
        );
    }
    text + "</svg>"
}
