use std::collections::BTreeMap;

use maud::{Markup, html};

use super::Contents;
use super::identity::{Named, RATES, RunRates, places};
use super::markup::{count, percent};
use crate::record::CellKey;
use crate::report::render::svg::px;
use crate::report::render::table::Value;
use crate::report::{PublishedComparison, Spread};
use base::statistics::wilson;

/// Width and height of the picture of a rate.
const SIZE: (f64, f64) = (96.0, 26.0);
/// The names of the rates.
const NAMES: [&str; 4] = ["any collision", "with a moving car", "preventable", "fault"];
/// Its margin at both ends.
const END: f64 = 6.0;

/// The cells as a figure in the form of a table: for each cell the rates with their intervals, and every run.
pub fn results(contents: &Contents<'_>, cells: &[Named<'_>], rates: &BTreeMap<CellKey, RunRates>) -> Markup {
    let empty = RunRates::default();
    html! {
        section #results {
            h2 { "How often cars are hit" }
            div.wide {
                table.results {
                    thead {
                        tr {
                            th scope="col" { "controller" }
                            th.number scope="col" { "runs × episodes" }
                            @for name in NAMES { th scope="col" { (name) } }
                            @for name in ["impact speed", "length"] { th.number scope="col" { (name) } }
                        }
                        tr.scale {
                            td colspan="2" {}
                            @for _ in RATES { td { (scale()) } }
                            @for unit in ["m/s", "s"] { td.number { (unit) } }
                        }
                    }
                    @for (place, members) in places(cells) {
                        tbody {
                            tr { th colspan="8" scope="rowgroup" { (place) } }
                            @for named in members { (row(contents, named, rates.get(&named.cell.key).unwrap_or(&empty))) }
                        }
                    }
                }
            }
            details {
                summary { "How to read this" }
                p {
                    "Rates are shares of the episodes that count: those in which the driver reached its start and did not leave the road before it could \
                     see a pedestrian. The large dot is the mean over runs, each a training of its own. Small dots are the runs. \
                     The bar is Wilson's 95 % interval over the episodes of all runs. It shows what more episodes of these trainings would show, \
                     not what more trainings would show. “±” is the standard deviation over runs. "
                    em { "Preventable" }
                    ": both careful human drivers would have avoided it. "
                    em { "Fault" }
                    ": preventable, and the pedestrian moved as people do. Controllers of a place meet the same starts. \
                     Untrained controllers do the same for every reward, so they are here once."
                    @if !contents.published.is_empty() { " A hollow diamond is a published figure." }
                }
            }
        }
    }
}

fn row(contents: &Contents<'_>, named: &Named<'_>, rates: &RunRates) -> Markup {
    let cell = named.cell;
    let published = |column: &str| {
        let same = |beside: &&PublishedComparison<'_>| beside.published.column == column && beside.key == cell.key;
        contents.published.iter().find(same)
    };
    html! {
        tr {
            th scope="row" { i class={ "dot f" (named.colour) } {} (named.who) }
            td.number data-label="runs × episodes" {
                (cell.runs) " × " (count((cell.episodes / cell.runs.max(1)).into()))
                @if cell.left_out > 0 { " " em.warn { (percent(f64::from(cell.left_out) / f64::from(cell.all))) " left out" } }
                @if cell.errors > 0 { " " em.warn { (cell.errors) " in error" } }
            }
            @for (number, rate) in [cell.collision, cell.moving, cell.preventable, cell.fault].into_iter().enumerate() {
                td data-label=(NAMES[number]) {
                    div.rate {
                        @let colour = if number >= 2 { "v0".to_string() } else { format!("f{}", named.colour) };
                        @let interval = wilson(rates.failures[number], rates.episodes);
                        (picture(&colour, rate, interval, &rates.rates[number], published(RATES[number].name)))
                        span { (Value::Spread(rate).to_string()) }
                    }
                }
            }
            td.number data-label="impact speed, m/s" { (tenths(cell.impact_speed)) }
            td.number data-label="length, s" { (tenths(cell.length)) }
        }
    }
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
fn scale() -> Markup {
    html! {
        svg.panel width=(SIZE.0) height=(SIZE.1) viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } aria-hidden="true" {
            @for (rate, text) in [(0.0, "0"), (0.5, "½"), (1.0, "1")] {
                text.muted.middle x=(px(at(rate))) y="16" { (text) }
            }
        }
    }
}

/// A rate with its interval and the rates of its runs.
fn picture(
    colour: &str,
    mean: Spread,
    (low, high): (f64, f64),
    runs: &[f64],
    published: Option<&PublishedComparison<'_>>,
) -> Markup {
    let says = mean.mean.map(|mean| format!("{}, interval {} to {}", percent(mean), percent(low), percent(high)));
    let middle = SIZE.1 / 2.0;
    html! {
        svg.panel width=(SIZE.0) height=(SIZE.1) viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } role="img"
            aria-label=(says.as_deref().unwrap_or("no value")) {
            @if let (Some(mean), Some(says)) = (mean.mean, &says) {
                title { (says) }
                @for rate in [0.0, 0.5, 1.0] { path.grid d={ "M" (px(at(rate))) " 0V" (SIZE.1) } {} }
                rect class=(colour) opacity=".32" x=(px(at(low))) y=(px(middle - 4.5)) width=(px(at(high) - at(low))) height="9" rx="2" {}
                @if runs.len() > 1 {
                    @for rate in runs { circle class=(colour) cx=(px(at(*rate))) cy=(px(middle + 9.0)) r="1.6" opacity=".75" {} }
                }
                circle class={ (colour) " knob" } cx=(px(at(mean))) cy=(px(middle)) r="3.4" {}
                @if let Some(beside) = published {
                    path class="axis theirs" d={ "M" (px(at(beside.published.mean))) " " (px(middle - 4.5)) "l4.5 4.5l-4.5 4.5l-4.5 -4.5z" } {
                        title { (beside.source) ": " (Value::Spread(beside.theirs()).to_string()) }
                    }
                }
            }
        }
    }
}
