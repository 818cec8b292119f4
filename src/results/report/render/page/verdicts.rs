use maud::html;

use super::identity::{Named, places};
use super::markup::percent;
use crate::report::render::svg::{Figure, Panel, px};
use crate::tables::metrics::{COLLISIONS, LABELLED};
use verdict::Label;

/// Width of a panel, and the start and the end of its bars.
const WIDTH: f64 = 286.0;
const BAR: (f64, f64) = (98.0, 236.0);
/// Height of a row.
const ROW: f64 = 22.0;

/// The collisions by verdict of the reference drivers, as bars; `None` without any collision.
pub fn verdicts(cells: &[Named<'_>]) -> Option<Figure> {
    let hit: Vec<Named<'_>> = cells.iter().filter(|named| named.cell.count(&COLLISIONS) > 0).cloned().collect();
    if hit.is_empty() {
        return None;
    }
    let legend = labels().map(|(number, label)| (format!("v{number}"), label.word(false).into()));
    let panels = places(&hit).into_iter().map(|(place, members)| panel(place, &members));
    Some(Figure {
        name: "verdicts".into(),
        title: "Collisions by what reference drivers would have made of them, as shares of all collisions.".into(),
        legend: legend.collect(),
        panels: panels.collect(),
        ..Figure::default()
    })
}

/// The labels of collisions with their places; a bump is none.
fn labels() -> impl Iterator<Item = (usize, Label)> {
    Label::ALL.into_iter().enumerate().filter(|(_, label)| *label != Label::Bump)
}

/// A segment of a bar.
struct Piece {
    class: usize,
    left: f64,
    width: f64,
    text: String,
}

fn pieces(named: &Named<'_>) -> Vec<Piece> {
    let all = f64::from(named.cell.count(&COLLISIONS).max(1));
    let mut left = BAR.0;
    let counted = labels().zip(LABELLED.map(|metric| named.cell.count(metric))).filter(|(_, count)| *count > 0);
    let piece = |((class, label), count): ((usize, Label), u32)| {
        let share = f64::from(count) / all;
        let width = share * (BAR.1 - BAR.0);
        left += width;
        let text = format!("{} {} ({count})", label.word(false), percent(share));
        Piece { class, left: left - width, width: (width - 0.7).max(0.4), text }
    };
    counted.map(piece).collect()
}

fn panel(place: &str, members: &[&Named<'_>]) -> Panel {
    let rows: Vec<_> = members.iter().map(|named| (*named, pieces(named))).collect();
    let says = rows.iter().map(|(named, pieces)| {
        let texts: Vec<&str> = pieces.iter().map(|piece| piece.text.as_str()).collect();
        format!(" {}, {} collisions: {}.", named.who, named.cell.count(&COLLISIONS), texts.join(", "))
    });
    let says = format!("Shares of collisions.{}", says.collect::<String>());
    let body = html! {
        @for (row, (named, pieces)) in rows.iter().enumerate() {
            @let top = row as f64 * ROW;
            text.ink x="0" y=(px(top + 14.5)) { (named.who) }
            @for piece in pieces {
                rect class={ "v" (piece.class) } x=(px(piece.left)) y=(px(top + 4.0)) width=(px(piece.width)) height="14" {
                    title { (piece.text) }
                }
            }
            text.muted.end x=(px(WIDTH)) y=(px(top + 14.5)) { (named.cell.count(&COLLISIONS)) }
        }
    };
    Panel { title: place.into(), says, size: (WIDTH, ROW * members.len() as f64 + 2.0), body }
}
