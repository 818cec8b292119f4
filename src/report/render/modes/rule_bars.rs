use std::fmt::Write;

use super::words::percent;
use crate::analysis::Explanation;
use crate::report::failure_modes::{CellModes, Target};
use crate::report::render::svg::escape;
use crate::statistics::wilson;

/// Width of the whole, and of a bar of 100 % (px).
const WIDTH: f64 = 760.0;
const FULL: f64 = 560.0;
/// Left edge (px).
const LEFT: f64 = 14.0;
/// Height of a rule, and of a heading (px).
const RULE: f64 = 40.0;
const HEADING: f64 = 76.0;

/// Draws what explains the failures of a cell: for each rule the rate among the episodes that it was not learnt from.
pub fn rule_bars(cell: &CellModes<'_>) -> String {
    let heights = cell.explanations.iter().map(|(_, found)| HEADING + RULE * found.rules.len() as f64);
    let height = 30.0 + heights.sum::<f64>();
    let mut page = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH:.0} {height:.0}\" width=\"{WIDTH:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\" fill=\"#222\">\n<title>What explains failure</title>\n\
         <style>.full{{fill:#ecece8}}.rate{{fill:#D55E00}}.whisker{{stroke:#222;stroke-width:1.4}}.learnt{{fill:#222}}\
         .overall{{stroke:#0072B2;stroke-width:2.4}}.note{{fill:#666;font-size:11px}}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{LEFT}\" y=\"22\" font-size=\"15\" font-weight=\"bold\">{}</text>\n",
        escape(&cell.key.to_string()),
    );
    let mut y = 30.0;
    for (target, found) in &cell.explanations {
        explanation(&mut page, *target, found, y);
        y += HEADING + RULE * found.rules.len() as f64;
    }
    page.push_str("</svg>\n");
    page
}

fn explanation(page: &mut String, target: Target, found: &Explanation, top: f64) {
    let overall = found.overall.0 as f64 / found.overall.1 as f64;
    let what = match target {
        Target::Collision => "Episodes that end in a collision",
        Target::Preventable => "Episodes that end in a preventable collision",
    };
    let _ = writeln!(
        page,
        "<text x=\"{LEFT}\" y=\"{:.0}\" font-weight=\"bold\">{what}: {} of {}</text>\n<text class=\"note\" x=\"{LEFT}\" y=\"{:.0}\">Bar: rate among episodes \
         that the rule was not learnt from, with 95 %; triangle: among those that it was; blue: all.</text>\n<text class=\"note\" \
         x=\"{LEFT}\" y=\"{:.0}\">Skill {:.2}; accuracy {:.2}, that of always naming the commoner outcome {:.2}.</text>",
        top + 22.0,
        percent(overall),
        found.overall.1,
        top + 39.0,
        top + 54.0,
        found.skill,
        found.accuracy,
        found.majority,
    );
    let x = |share: f64| LEFT + share * FULL;
    let first = top + HEADING;
    for (index, rule) in found.rules.iter().enumerate() {
        let y = first + RULE * index as f64;
        let (hits, all) = rule.held_out;
        let rate = hits as f64 / all.max(1) as f64;
        let learnt = rule.learnt.0 as f64 / rule.learnt.1.max(1) as f64;
        let (low, high) = wilson(hits, all);
        let _ = writeln!(
            page,
            "<text x=\"{LEFT}\" y=\"{:.1}\">{}</text>\n<rect class=\"full\" x=\"{LEFT}\" y=\"{:.1}\" width=\"{FULL}\" height=\"12\"/>\
             <rect class=\"rate\" x=\"{LEFT}\" y=\"{:.1}\" width=\"{:.1}\" height=\"12\"/><path class=\"whisker\" d=\"M{:.1} {:.1}H{:.1}\"/>\
             <path class=\"learnt\" d=\"M{:.1} {:.1}l-4 6h8z\"/><path class=\"overall\" d=\"M{:.1} {:.1}v16\"/><text x=\"{:.1}\" y=\"{:.1}\">{} of {all}</text>",
            y + 10.0,
            escape(&rule.to_string()),
            y + 15.0,
            y + 15.0,
            rate * FULL,
            x(low),
            y + 21.0,
            x(high),
            x(learnt),
            y + 27.0,
            x(overall),
            y + 13.0,
            x(1.0) + 8.0,
            y + 26.0,
            percent(rate),
        );
    }
}
