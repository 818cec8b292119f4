use maud::html;

use super::names::percent;
use crate::analysis::Explanation;
use crate::report::failure_modes::{CellModes, Target};
use crate::report::render::svg::{Figure, Panel, px};
use base::statistics::wilson;

/// Width of a panel, and of a bar of 100 % (px).
const WIDTH: f64 = 724.0;
const FULL: f64 = 560.0;
/// Height of a rule, and of the line above the rules (px).
const RULE: f64 = 40.0;
const HEADING: f64 = 24.0;

/// Draws the explanation of a cell's failures: for each rule the rate among the held-out episodes.
pub fn rule_bars(cell: &CellModes<'_>) -> Figure {
    Figure {
        title: cell.key.to_string(),
        notes: vec![
            "Bar: rate among the episodes that the rule was not learnt from, with its 95 % interval.".into(),
            "Triangle: rate among the episodes that it was learnt from. Line: rate of all episodes.".into(),
        ],
        columns: 1,
        panels: cell.explanations.iter().map(|(target, found)| panel(*target, found)).collect(),
        ..Figure::default()
    }
}

fn panel(target: Target, found: &Explanation) -> Panel {
    let overall = found.overall.0 as f64 / found.overall.1 as f64;
    let what = match target {
        Target::Collision => "Episodes that end in a collision",
        Target::Preventable => "Episodes that end in a preventable collision",
    };
    let x = |share: f64| px(share * FULL);
    let body = html! {
        text.muted y="12" {
            (format!(
                "Skill {:.2}; accuracy {:.2}; accuracy of always naming the commoner outcome {:.2}.",
                found.skill, found.accuracy, found.majority
            ))
        }
        @for (index, rule) in found.rules.iter().enumerate() {
            @let top = HEADING + RULE * index as f64;
            @let (hits, all) = rule.held_out;
            @let rate = hits as f64 / all.max(1) as f64;
            @let learnt = rule.learnt.0 as f64 / rule.learnt.1.max(1) as f64;
            @let (low, high) = wilson(hits, all);
            text.ink y=(px(top + 10.0)) { (rule.to_string()) }
            rect.h0 y=(px(top + 15.0)) width=(FULL) height="12" {}
            rect.f1 y=(px(top + 15.0)) width=(x(rate)) height="12" {}
            path.whisker d={ "M" (x(low)) " " (px(top + 21.0)) "H" (x(high)) } {}
            path.ink d={ "M" (x(learnt)) " " (px(top + 27.0)) "l-4 6h8z" } {}
            path class="line s0" d={ "M" (x(overall)) " " (px(top + 13.0)) "v16" } {}
            text.ink x=(px(FULL + 8.0)) y=(px(top + 26.0)) { (percent(rate)) " of " (all) }
        }
    };
    Panel {
        title: format!("{what}: {} of {}", percent(overall), found.overall.1),
        says: found.rules.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
        size: (WIDTH, HEADING + RULE * found.rules.len() as f64),
        body,
    }
}
