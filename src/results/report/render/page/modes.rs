use maud::{Markup, html};

use super::Players;
use super::markup::percent;
use super::player_card::PlayerCard;
use crate::report::FailureClass;
use crate::report::render::table::{Column, Table, Value};
use world::judge::Label;

/// A kind of collision, with an example.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeCard {
    /// The place and the driver.
    pub place: String,
    pub driver: String,
    /// The controller.
    pub who: String,
    /// The kind, as a title.
    pub title: String,
    /// More about it, in a sentence or two.
    pub about: String,
    pub verdict: Label,
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
}

/// Number of cards that are visible at once; the others are folded.
const SHOWN: usize = 6;

/// Puts kinds in the order of the page: by verdict, and the more frequent kind first; but one of each driver comes before all others.
/// Drivers that see no pedestrians follow.
pub fn order(cards: &mut [ModeCard], is_blind: impl Fn(&str) -> bool) {
    cards.sort_by_key(|card| (card.verdict, std::cmp::Reverse(card.failures)));
    let mut seen: Vec<String> = Vec::new();
    cards.sort_by_cached_key(|card| {
        let is_first = !seen.contains(&card.driver);
        if is_first {
            seen.push(card.driver.clone());
        }
        (is_blind(&card.driver), !is_first, card.verdict)
    });
}

/// The kinds of collisions: a card with a player for those that were repeated, a table of all.
pub fn modes(cards: &[ModeCard], players: &Players, played: &[&str]) -> Markup {
    let options = players.options();
    let players: Vec<_> = cards
        .iter()
        .filter(|card| !played.contains(&card.example.as_str()))
        .filter_map(|card| Some((card, players.get(&card.example)?)))
        .collect();
    let (shown, more) = players.split_at(players.len().min(SHOWN));
    html! {
        p.lead {
            "A kind is where the car was hit, whether it moved, which reference drivers would have avoided it, and what its driver did at the touch. Within a kind, \
             collisions are grouped by the last seconds before the touch. The most typical example of each group is shown; the preventable kinds are first. "
        }
        div.cards { @for (each, replay) in shown { (card(each).to_html(replay, options)) } }
        @if !more.is_empty() {
            details.more {
                summary { "More kinds to play" }
                div.cards { @for (each, replay) in more { (card(each).to_html(replay, options)) } }
            }
        }
        details.all { summary { "All kinds" } (table(cards).to_html()) }
    }
}

fn table(cards: &[ModeCard]) -> Table {
    let mut head: Vec<Column> = ["kind", "place", "controller", "verdict"].map(Column::text).into();
    head.extend(["collisions", "share", "impact (m/s)", "after (s)"].map(Column::number));
    head.push(Column::text("example"));
    let row = |card: &ModeCard| {
        vec![
            Value::from(&card.title),
            Value::from(&card.place),
            Value::from(&card.who),
            card.verdict.word(false).into(),
            Value::Count(card.failures as u64),
            Value::Percent(card.share),
            Value::Number(Some(card.impact_speed), 1),
            Value::Number(Some(card.length), 1),
            Value::Code(card.example.clone()),
        ]
    };
    Table { head, rows: cards.iter().map(row).collect(), ..Table::default() }
}

fn card(card: &ModeCard) -> PlayerCard {
    PlayerCard {
        title: card.title.clone(),
        verdict: (FailureClass::new(Some(card.verdict), false), card.verdict.word(false)),
        place: format!("{} · {}", card.who, card.place),
        about: format!("{} of its collisions there, {}. {}", card.failures, percent(card.share), card.about),
        name: card.example.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_kind_of_each_driver_comes_first_and_blind_drivers_are_last() {
        let card = |driver: &str, verdict, failures| ModeCard {
            place: String::new(),
            driver: driver.into(),
            who: String::new(),
            title: String::new(),
            about: String::new(),
            verdict,
            failures,
            share: 0.0,
            impact_speed: 0.0,
            length: 0.0,
            example: String::new(),
        };
        let mut cards = [
            card("blind", Label::Preventable, 90),
            card("a", Label::Bump, 80),
            card("a", Label::Preventable, 7),
            card("a", Label::Preventable, 9),
            card("b", Label::Contested, 1),
        ];
        order(&mut cards, |driver| driver == "blind");
        let found: Vec<_> = cards.iter().map(|card| (card.driver.as_str(), card.failures)).collect();
        assert_eq!(found, [("a", 9), ("b", 1), ("a", 7), ("a", 80), ("blind", 90)]);
    }
}
