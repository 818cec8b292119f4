use maud::{Markup, PreEscaped, html};

use super::frames::frames;
use super::markup::{json, percent};
use super::replay::{Replay, verdict_named};
use crate::report::render::table::{Column, Table, Value};

/// A kind of collision, with an example that can be played.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModeCard {
    /// The place and the driver.
    pub place: String,
    /// The controller.
    pub who: String,
    /// The kind, as a title.
    pub title: String,
    /// More about it, in a sentence or two.
    pub about: String,
    /// Whether the controller was trained; trained ones come first.
    pub trained: bool,
    /// Name of the verdict.
    pub verdict: &'static str,
    /// The number of collisions of this kind.
    pub failures: usize,
    /// Share of the collisions of the cell.
    pub share: f64,
    /// Usual speed of the car (m/s).
    pub impact_speed: f64,
    /// Usual time of the collision (s).
    pub length: f64,
    /// Name of the example, `RUN:EPISODE`.
    pub example: String,
    /// The example; none when it was not repeated.
    pub replay: Option<Replay>,
}

/// Number of cards that are visible at once; the others are folded.
const SHOWN: usize = 6;

/// The kinds of collisions: a card with a player for those that were repeated, a table of all.
pub fn modes(cards: &[ModeCard]) -> Markup {
    let players: Vec<_> =
        cards.iter().enumerate().filter_map(|(number, card)| Some((number, card, card.replay.as_ref()?))).collect();
    let (shown, more) = players.split_at(players.len().min(SHOWN));
    html! {
        section #modes {
            h2 { "Kinds of collisions" }
            p.lead {
                "A kind is where the car was hit, whether it moved, which reference drivers would have avoided it, and what its driver was doing. Within a kind, \
                 collisions are grouped by the last seconds before the touch. The most typical example of each group is shown. "
                span.keys { "Space plays, arrows step by a tick, with shift by a second." }
            }
            div.cards { @for (number, each, replay) in shown { (card(*number, each, replay)) } }
            @if !more.is_empty() {
                details.more {
                    summary { "More kinds to play" }
                    div.cards { @for (number, each, replay) in more { (card(*number, each, replay)) } }
                }
            }
            details.all { summary { "All kinds" } (table(cards).to_html()) }
        }
    }
}

fn table(cards: &[ModeCard]) -> Table {
    let mut head: Vec<Column> = ["place", "controller", "kind", "verdict"].map(Column::text).into();
    head.extend(["collisions", "share", "impact (m/s)", "after (s)"].map(Column::number));
    head.push(Column::text("example"));
    let row = |card: &ModeCard| {
        vec![
            Value::from(&card.place),
            Value::from(&card.who),
            Value::from(&card.title),
            verdict_named(card.verdict).into(),
            Value::Count(card.failures as u64),
            Value::Percent(card.share),
            Value::Number(Some(card.impact_speed), 1),
            Value::Number(Some(card.length), 1),
            Value::Code(card.example.clone()),
        ]
    };
    Table { head, rows: cards.iter().map(row).collect(), ..Table::default() }
}

fn card(number: usize, card: &ModeCard, replay: &Replay) -> Markup {
    html! {
        article.card id={ "mode-" (number) } aria-labelledby={ "mode-" (number) "-title" } {
            header {
                h3 id={ "mode-" (number) "-title" } { (card.title) }
                span class={ "verdict " (card.verdict) } { (verdict_named(card.verdict)) }
            }
            p.where { (card.who) " · " (card.place) }
            p { (card.failures) " of its collisions there, " (percent(card.share)) ". " (card.about) }
            div.player data-replay={ "replay-" (number) } {}
            (frames(replay, &format!("ground-{number}")))
            (reference_drivers(replay))
            p.replay { code { "falsify replay " (card.example) } }
            script type="application/json" id={ "replay-" (number) } { (PreEscaped(json(replay))) }
        }
    }
}

/// The reference drivers that would have avoided it, in a line.
fn reference_drivers(replay: &Replay) -> Markup {
    html! {
        @if !replay.drivers.is_empty() {
            ul.drivers aria-label="Reference drivers" {
                @for (name, hit) in &replay.drivers {
                    @match hit {
                        None => li.avoids { b { (driver(name)) } " avoids it" },
                        Some(speed) => li.hits { b { (driver(name)) } (format!(" hits at {speed:.1} m/s")) },
                    }
                }
            }
        }
    }
}

/// A reference driver, for people.
fn driver(name: &str) -> &str {
    match name {
        "cc" => "careful human",
        "cc_attentive" => "attentive human",
        "fsm" => "fuzzy safety",
        "rss" => "RSS",
        "ideal" => "ideal brake",
        "bound" => "0.85 g at once",
        other => other,
    }
}
