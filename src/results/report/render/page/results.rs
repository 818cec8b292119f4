use maud::{Markup, html};

use super::identity::{Named, named, places};
use super::markup::{count, percent};
use crate::report::render::svg::{Digits, px};
use crate::report::render::table::Value;
use crate::report::{Findings, PublishedComparison, Rate};
use crate::tables::Metric;
use crate::tables::metrics::{
    ALL_EPISODES, EPISODE_LENGTH, EPISODES, ERRORS, IMPACT_SPEED, LEFT_OUT_EPISODES, compared,
};

/// Width and height of the picture of a rate.
const SIZE: (f64, f64) = (96.0, 26.0);
/// Its margin at both ends.
const END: f64 = 8.0;
/// The ends that an axis may have.
const ENDS: [f64; 9] = [0.004, 0.01, 0.02, 0.04, 0.1, 0.2, 0.4, 0.6, 1.0];

/// The cells as a figure in the form of a table: for each cell the rates with their intervals, and every run.
pub fn results(found: &Findings<'_>) -> Markup {
    let cells = &named(&found.cells);
    let axes: Vec<Axis> = compared().map(|metric| Axis::new(found, cells, metric)).collect();
    html! {
        div.wide {
            table.results {
                thead {
                    tr {
                        th scope="col" { "pedestrian" }
                        th.number scope="col" { "runs × episodes" }
                        @for metric in compared() { th scope="col" { (metric.word()) } }
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
                        tr { th colspan=(axes.len() + 4) scope="rowgroup" { (place) } }
                        @for named in members { (row(found, named, &axes)) }
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
                ": all careful drivers would have avoided it. Pedestrians of a place meet the same starts. \
                 Untrained pedestrians do the same for every reward, so they are here once."
                " Each column has an axis of its own."
                @if !found.published.is_empty() { " A hollow diamond is a published figure." }
            }
        }
    }
}

fn row(found: &Findings<'_>, named: &Named<'_>, axes: &[Axis]) -> Markup {
    let cell = named.cell;
    let published = |column: &str| {
        let same = |beside: &&PublishedComparison<'_>| beside.published.column == column && beside.key == cell.key;
        found.published.iter().find(same)
    };
    html! {
        tr {
            th scope="row" { i class={ "dot f" (named.colour) } {} (named.who) }
            td.number data-label="runs × episodes" {
                (cell.runs()) " × " (count((cell.count(&EPISODES) / cell.runs().max(1)).into()))
                @if cell.count(&LEFT_OUT_EPISODES) > 0 { " " em.warn { (percent(f64::from(cell.count(&LEFT_OUT_EPISODES)) / f64::from(cell.count(&ALL_EPISODES)))) " left out" } }
                @if cell.count(&ERRORS) > 0 { " " em.warn { (cell.count(&ERRORS)) " in error" } }
            }
            @for (number, metric) in compared().enumerate() {
                @let rate = &cell.rate(metric);
                td data-label=(metric.word()) {
                    div.rate {
                        @let colour = if number >= 1 { "v0".to_string() } else { format!("f{}", named.colour) };
                        (axes[number].picture(&colour, rate, published(metric.name)))
                        span { (Value::spread(cell, metric).to_string()) }
                    }
                }
            }
            td.number data-label="impact speed, m/s" { (tenths(&cell.rate(&IMPACT_SPEED))) }
            td.number data-label="length, s" { (tenths(&cell.rate(&EPISODE_LENGTH))) }
        }
    }
}

fn tenths(rate: &Rate) -> String {
    match (rate.value, rate.sd) {
        (None, _) => "–".into(),
        (Some(mean), None) => format!("{mean:.1}"),
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.1}"),
    }
}

/// The axis of a column of rates, from 0 to this rate.
#[derive(Debug, Clone, Copy)]
struct Axis(f64);

impl Axis {
    /// The shortest axis that holds the rates of a column, with their intervals.
    fn new(found: &Findings<'_>, cells: &[Named<'_>], metric: &Metric) -> Self {
        let ours = cells.iter().map(|named| named.cell.rate(metric));
        let ours = ours.flat_map(|rate| rate.by_run.into_iter().chain(rate.interval.map(|(_, high)| high)));
        let theirs = found.published.iter().filter(|beside| beside.published.column == metric.name);
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

    /// A rate with its interval and the rates of its runs.
    fn picture(self, colour: &str, rate: &Rate, published: Option<&PublishedComparison<'_>>) -> Markup {
        let runs = &rate.by_run;
        let within = rate.interval.map_or("without an interval".into(), |(low, high)| {
            format!("interval {} to {}", percent(low), percent(high))
        });
        let says = rate.value.map(|mean| format!("{}, {within}", percent(mean)));
        let (middle, at) = (SIZE.1 / 2.0, |rate| self.at(rate));
        html! {
            svg.panel width=(SIZE.0) height=(SIZE.1) viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } role="img"
                aria-label=(says.as_deref().unwrap_or("no value")) {
                @if let (Some(mean), Some(says)) = (rate.value, &says) {
                    title { (says) }
                    @for rate in [0.0, self.0 / 2.0, self.0] { path.grid d={ "M" (px(at(rate))) " 0V" (SIZE.1) } {} }
                    @if let Some((low, high)) = rate.interval {
                        rect class=(colour) opacity=".32" x=(px(at(low))) y=(px(middle - 4.5)) width=(px(at(high) - at(low))) height="9" rx="2" {}
                    }
                    @if runs.len() > 1 {
                        @for rate in runs { circle class=(colour) cx=(px(at(*rate))) cy=(px(middle + 9.0)) r="1.6" opacity=".75" {} }
                    }
                    circle class={ (colour) " knob" } cx=(px(at(mean))) cy=(px(middle)) r="3.4" {}
                    @if let Some(beside) = published {
                        path class="axis theirs" d={ "M" (px(at(beside.published.mean))) " " (px(middle - 4.5)) "l4.5 4.5l-4.5 4.5l-4.5 -4.5z" } {
                            title { (beside.source) ": " (Value::from(&beside.theirs()).to_string()) }
                        }
                    }
                }
            }
        }
    }
}
