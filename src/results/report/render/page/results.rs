use std::collections::BTreeMap;

use maud::{Markup, html};

use super::Contents;
use super::identity::{Named, RATES, RunRates, places};
use super::markup::{count, percent};
use crate::record::CellKey;
use crate::report::render::sections::{RateOf, Scale};
use crate::report::render::svg::{Digits, px};
use crate::report::render::table::Value;
use crate::report::{Cell, PublishedComparison, Spread};
use base::statistics::wilson;

/// Width and height of the picture of a rate.
const SIZE: (f64, f64) = (96.0, 26.0);
/// The names of the rates.
const NAMES: [&str; 3] = ["collision", "preventable", "fault"];
/// Its margin at both ends.
const END: f64 = 8.0;
/// The ends that an axis may have.
const ENDS: [f64; 9] = [0.004, 0.01, 0.02, 0.04, 0.1, 0.2, 0.4, 0.6, 1.0];
/// The rates of a cell, in the order of [`RATES`].
const OF: [RateOf; 3] = [|cell| cell.collision, |cell| cell.preventable, |cell| cell.fault];

/// The cells as a figure in the form of a table: for each cell the rates with their intervals, and every run.
pub fn results(contents: &Contents<'_>, cells: &[Named<'_>], rates: &BTreeMap<CellKey, RunRates>) -> Markup {
    let empty = RunRates::default();
    let scale = Scale::new(contents.drivers, contents.cells);
    let axes = [0, 1, 2].map(|number| Axis::new(contents, cells, rates, number));
    html! {
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
                        @for axis in &axes { td { (axis.draw()) } }
                        @for unit in ["m/s", "s"] { td.number { (unit) } }
                    }
                }
                @for (place, members) in places(cells) {
                    tbody {
                        tr { th colspan="7" scope="rowgroup" { (place) } }
                        @for named in members { (row(contents, named, rates.get(&named.cell.key).unwrap_or(&empty), (&axes, scale))) }
                    }
                }
            }
        }
        details {
            summary { "How to read this" }
            p {
                "Rates are shares of the episodes that count: those in which the driver reached its start and did not leave the road before it could see a \
                 pedestrian. The large dot is the mean over runs, each a training of its own. Small dots are the runs. \
                 The bar is Wilson's 95 % interval over the starts, which the runs share. It shows what more starts of these trainings would show, \
                 not what more trainings would show. “±” is the standard deviation over runs. "
                em { "Preventable" }
                ": both careful human drivers would have avoided it. "
                em { "Fault" }
                ": preventable, and the pedestrian moved as people do. Controllers of a place meet the same starts. \
                 Untrained controllers do the same for every reward, so they are here once."
                @if scale.name().is_some() {
                    " The thin line above a bar is the scale: from the best driver with this controller in this town to "
                    @match scale.blind() {
                        Some(name) => { code { (name) } ", which sees no pedestrian." },
                        None => "the worst.",
                    }
                    " Each column has an axis of its own."
                }
                @if !contents.published.is_empty() { " A hollow diamond is a published figure." }
            }
        }
    }
}

fn row(contents: &Contents<'_>, named: &Named<'_>, rates: &RunRates, (axes, scale): (&[Axis; 3], Scale<'_>)) -> Markup {
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
            @for (number, of) in OF.into_iter().enumerate() {
                @let rate = of(cell);
                td data-label=(NAMES[number]) {
                    div.rate {
                        @let colour = if number >= 1 { "v0".to_string() } else { format!("f{}", named.colour) };
                        @let interval = wilson(rates.failures[number], rates.episodes);
                        (axes[number].picture(&colour, rate, interval, &rates.rates[number], (scale.ends(cell, of), published(RATES[number].name))))
                        span {
                            (Value::or_count(rate.into(), rate.mean, failures(cell)[number], cell.episodes).to_string())
                            @if let (Some(share), Some(blind)) = (scale.share(cell, of), scale.blind()) {
                                @if blind != cell.key.policy && share >= 0.005 { small { (format!("{share:.2}")) " of " (blind) "’s" } }
                            }
                        }
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

/// The numbers of a cell's failures, in the order of [`RATES`].
fn failures(cell: &Cell) -> [u32; 3] {
    [cell.collisions, cell.preventable_collisions(), cell.faults]
}

/// The axis of a column of rates, from 0 to this rate.
#[derive(Debug, Clone, Copy)]
struct Axis(f64);

impl Axis {
    /// The shortest axis that holds the rates of a column, with their intervals.
    fn new(contents: &Contents<'_>, cells: &[Named<'_>], rates: &BTreeMap<CellKey, RunRates>, number: usize) -> Self {
        let of_cells = cells.iter().filter_map(|named| rates.get(&named.cell.key));
        let ours = of_cells.flat_map(|found| {
            let high = wilson(found.failures[number], found.episodes).1;
            found.rates[number].iter().copied().chain([high])
        });
        let theirs = contents.published.iter().filter(|beside| beside.published.column == RATES[number].name);
        let most = ours.chain(theirs.map(|beside| beside.published.mean)).fold(0.0, f64::max);
        Self(ENDS.into_iter().find(|end| most <= *end).unwrap_or(1.0))
    }

    fn at(self, rate: f64) -> f64 {
        END + (rate / self.0).clamp(0.0, 1.0) * (SIZE.0 - 2.0 * END)
    }

    /// Its numbers, above the column.
    fn draw(self) -> Markup {
        html! {
            svg.panel width=(SIZE.0) height=(SIZE.1) viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } aria-hidden="true" {
                @for rate in [0.0, self.0 / 2.0, self.0] {
                    text.muted.middle x=(px(self.at(rate))) y="16" { (Digits(rate, 3)) }
                }
            }
        }
    }

    /// A rate with its interval and the rates of its runs, above it the scale: from the best driver to the one that sees no pedestrians, or to the worst.
    fn picture(
        self,
        colour: &str,
        mean: Spread,
        (low, high): (f64, f64),
        runs: &[f64],
        (ends, published): (Option<(f64, f64)>, Option<&PublishedComparison<'_>>),
    ) -> Markup {
        let says = mean.mean.map(|mean| format!("{}, interval {} to {}", percent(mean), percent(low), percent(high)));
        let (middle, at) = (SIZE.1 / 2.0, |rate| self.at(rate));
        html! {
            svg.panel width=(SIZE.0) height=(SIZE.1) viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } role="img"
                aria-label=(says.as_deref().unwrap_or("no value")) {
                @if let (Some(mean), Some(says)) = (mean.mean, &says) {
                    title { (says) }
                    @for rate in [0.0, self.0 / 2.0, self.0] { path.grid d={ "M" (px(at(rate))) " 0V" (SIZE.1) } {} }
                    @if let Some((best, top)) = ends {
                        path.axis d={ "M" (px(at(best))) " 2.5H" (px(at(top))) "M" (px(at(top))) " 0v5" } {}
                    }
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
}
