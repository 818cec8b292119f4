use std::fmt::Write;

use super::figure::{Figure, Panel};
use super::identity::{Named, places};
use super::markup::{escape, percent};
use super::replay::verdict_text;
use crate::judge::Label;

/// Width of a panel; where bars begin and end in it.
const WIDTH: f64 = 286.0;
const BAR: (f64, f64) = (98.0, 236.0);
/// Height of a row.
const ROW: f64 = 22.0;

/// What reference drivers make of the collisions, as bars; none without any collision.
pub fn verdicts(cells: &[Named<'_>]) -> Option<Figure> {
    let hit: Vec<Named<'_>> = cells.iter().filter(|named| named.cell.collisions > 0).cloned().collect();
    if hit.is_empty() {
        return None;
    }
    let legend =
        Label::ALL.iter().enumerate().map(|(number, label)| (format!("v{number}"), verdict_text(*label).into()));
    let panels = places(&hit).into_iter().map(|(place, members)| panel(place, &members));
    Some(Figure {
        name: "figure-verdicts".into(),
        title: "Collisions by what reference drivers would have made of them; shares of all collisions.".into(),
        legend: legend.collect(),
        defs: String::new(),
        panels: panels.collect(),
    })
}

fn panel(place: &str, members: &[&Named<'_>]) -> Panel {
    let mut body = String::new();
    let mut says = String::from("Shares of collisions.");
    for (row, named) in members.iter().enumerate() {
        let top = row as f64 * ROW;
        let all = f64::from(named.cell.collisions.max(1));
        let _ = write!(body, "<text class=\"ink\" x=\"0\" y=\"{:.0}\">{}</text>", top + 14.5, escape(&named.who));
        let mut x = BAR.0;
        let _ = write!(says, " {}, {} collisions:", named.who, named.cell.collisions);
        for ((number, label), count) in Label::ALL.iter().enumerate().zip(named.cell.labels) {
            let share = f64::from(count) / all;
            let width = share * (BAR.1 - BAR.0);
            if count == 0 {
                continue;
            }
            let text = format!("{} {}", verdict_text(*label), percent(share));
            let _ = write!(says, " {text},");
            let _ = write!(
                body,
                "<rect class=\"v{number}\" x=\"{x:.1}\" y=\"{:.0}\" width=\"{:.1}\" height=\"14\"><title>{text} ({count})</title></rect>",
                top + 4.0,
                (width - 0.7).max(0.4)
            );
            x += width;
        }
        let _ = write!(
            body,
            "<text class=\"muted end\" x=\"{WIDTH:.0}\" y=\"{:.0}\">{}</text>",
            top + 14.5,
            named.cell.collisions
        );
    }
    let says = says.trim_end_matches(',').to_string() + ".";
    Panel { title: place.into(), says, size: (WIDTH, ROW * members.len() as f64 + 2.0), body }
}
