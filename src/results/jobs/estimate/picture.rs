use maud::html;

use crate::report::svg::{Figure, Panel, px, thousands};
use compile::Estimation;
use search::likelihood::{Estimate, Likelihood};
use verdict::Blame;

type Ended<'a> = (&'a Estimation, &'a Estimate);

/// Width of a panel, and the start and the end of its axis.
const WIDTH: f64 = 360.0;
const AXIS: (f64, f64) = (140.0, 345.0);
/// Height of a row, and of the axis below.
const ROW: f64 = 24.0;
const FOOT: f64 = 34.0;

/// How likely a fault is, a line for each estimate, on an axis in orders of magnitude.
pub fn likelihoods(ended: &[Ended<'_>]) -> Figure {
    let mut towns: Vec<&str> = Vec::new();
    for (job, _) in ended {
        if !towns.contains(&job.town.as_str()) {
            towns.push(&job.town);
        }
    }
    let panels = towns.into_iter().map(|town| panel(town, ended));
    Figure {
        name: "likelihood".into(),
        title: "How likely a fault is in an encounter, with the 95 % interval.".into(),
        notes: vec![
            "The axis says 1 in how many. An arrow to the left is the 95 % bound where no fault was seen. The hollow mark is any failure.".into(),
        ],
        columns: 1,
        panels: panels.collect(),
        ..Figure::default()
    }
}

fn panel(town: &str, ended: &[Ended<'_>]) -> Panel {
    let rows: Vec<&Ended<'_>> = ended.iter().filter(|(job, _)| job.town == town).collect();
    let walkers = rows.iter().any(|(job, _)| job.pedestrian != rows[0].0.pedestrian);
    let name = |job: &Estimation| match walkers {
        true => format!("{}, {}", job.policy, job.pedestrian),
        false => job.policy.clone(),
    };
    let least = |likelihood: &Likelihood| if likelihood.seen > 0 { likelihood.low.max(1e-9) } else { likelihood.high };
    let lowest = rows.iter().map(|(_, estimate)| least(estimate.of(Blame::Fault))).fold(0.1, f64::min);
    let decades = (-libm::log10(lowest)).ceil().max(1.0);
    let at = |probability: f64| {
        let share = 1.0 + libm::log10(probability.clamp(lowest / 3.0, 1.0)) / decades;
        AXIS.0 + share.max(0.0) * (AXIS.1 - AXIS.0)
    };
    let floor = ROW * rows.len() as f64;
    let says = rows.iter().map(|(job, estimate)| {
        let fault = estimate.of(Blame::Fault);
        format!(" {}: {:.1e}, {:.1e} to {:.1e}.", name(job), fault.probability, fault.low, fault.high)
    });
    let says = format!("Probability of a fault in an encounter.{}", says.collect::<String>());
    let body = html! {
            @for decade in 0..=decades as i32 {
                @let x = at(libm::pow(10.0, f64::from(-decade)));
                path.grid d={ "M" (px(x)) " 0V" (px(floor)) } {}
                text.muted.middle x=(px(x)) y=(px(floor + 16.0)) {
    (thousands(libm::pow(10.0, f64::from(decade))))
                }
            }
            @for (row, (job, estimate)) in rows.iter().enumerate() {
                @let middle = ROW * row as f64 + 12.0;
                @let (fault, any) = (estimate.of(Blame::Fault), estimate.of(Blame::Any));
                text.ink x="0" y=(px(middle + 4.0)) { (name(job)) }
                @if any.seen > 0 {
                    circle.line.s1 cx=(px(at(any.probability))) cy=(px(middle)) r="4" fill="none" {}
                }
                @if fault.seen > 0 {
                    path.line.s0 d={ "M" (px(at(fault.low))) " " (px(middle)) "H" (px(at(fault.high))) } {}
                    circle.f0 cx=(px(at(fault.probability))) cy=(px(middle)) r="4" {}
                } @else {
                    @let x = at(fault.high);
                    path.line.s0 d={ "M" (px(x)) " " (px(middle - 5.0)) "v10M" (px(x)) " " (px(middle)) "h-22m6 -4l-6 4 6 4" } fill="none" {}
                }
            }
        };
    Panel { title: town.into(), says, size: (WIDTH, floor + FOOT), body }
}
