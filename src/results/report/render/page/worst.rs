use std::cmp::Ordering;

use maud::{Markup, html};

use super::Players;
use super::player_card::PlayerCard;
use crate::failure::Failure;
use crate::report::{DriverResult, Failures, worst_failure};

/// Maximum number of failures in the list of the drivers under test, and in that of drivers that see no pedestrians.
const MAX_LISTED: (usize, usize) = (150, 20);
/// Maximum number of violations of evaluations in the list.
const MAX_VIOLATIONS: usize = 30;
/// Maximum number of drivers whose worst failure has a card.
const MAX_DRIVERS: usize = 8;

/// The failures of a page in their order: one of each driver, then all others, the worst first; drivers that see no pedestrians follow, and
/// the worst violation of each requirement in each cell.
pub fn listed<'a>(drivers: &[DriverResult], failures: &'a Failures) -> Vec<&'a Failure> {
    let of = |blind: bool, most: usize| {
        let drivers = drivers.iter().filter(move |result| result.driver.sees_no_pedestrians() == blind);
        let ranked = drivers.flat_map(|result| failures.of(&result.driver.name).iter().enumerate());
        let mut ranked: Vec<(usize, &Failure)> = ranked.collect();
        ranked.sort_by(|a, b| one_of_each_first(*a, *b));
        ranked.into_iter().map(|(_, found)| found).take(most)
    };
    let violations = failures.violations().take(MAX_VIOLATIONS);
    of(false, MAX_LISTED.0).chain(of(true, MAX_LISTED.1)).chain(violations).collect()
}

fn one_of_each_first((rank, found): (usize, &Failure), (other_rank, other): (usize, &Failure)) -> Ordering {
    (rank > 0).cmp(&(other_rank > 0)).then_with(|| found.worse_first(other))
}

/// The worst failure of each driver that has a player, those under test first.
pub fn worst(drivers: &[DriverResult]) -> impl Iterator<Item = &Failure> {
    drivers.iter().filter_map(|result| result.worst.as_ref()).take(MAX_DRIVERS)
}

/// The players of the worst failures but the very worst, which is shown first, and the list of failures.
///
/// `cards` are the names of the failures that have cards anywhere on the page.
pub fn failures(drivers: &[DriverResult], failures: &Failures, cards: &[String], players: &Players) -> Markup {
    let listed = listed(drivers, failures);
    let is_listed =
        |name: &str| cards.iter().any(|card| card == name) || listed.iter().any(|found| found.name() == name);
    let others: Vec<_> = players.iter().filter(|(name, _)| !is_listed(name)).collect();
    let first = worst_failure(drivers);
    html! {
        p.lead {
            @if drivers.len() > 1 { "The worst failure of each other driver. " }
            span.keys { "Space plays, arrows step by a tick, with shift by a second. “Follow” keeps the car in the middle of the picture, “Whole” shows the whole way." }
        }
        div.cards {
            @for found in worst(drivers).filter(|found| Some(*found) != first) {
                @if let Some(replay) = players.get(&found.name()) { (card(found).to_html(replay, players.options())) }
            }
        }
        (list(&listed, cards, players))
        @if !others.is_empty() {
            details.more {
                summary { "More failures to play" }
                div.cards { @for (name, replay) in others { (PlayerCard::plain(name, replay).to_html(replay, players.options())) } }
            }
        }
    }
}

pub fn card(found: &Failure) -> PlayerCard {
    PlayerCard {
        title: match &found.violation {
            Some(violation) => format!("{}, violates {}", found.key.cell.policy, violation.requirement),
            None => format!("{}, collision at {:.1} m/s", found.key.cell.policy, found.impact_speed),
        },
        verdict: (found.class(), found.word()),
        place: format!(
            "{} · {} · {} {:.1} s after the start",
            found.finder(),
            found.key.cell.place(),
            if found.violation.is_some() { "violation" } else { "collision" },
            found.length
        ),
        name: found.name(),
    }
}

/// The failures as a table that can be sorted where scripts run. Those that can be played and have no card bring what their player needs.
fn list(listed: &[&Failure], cards: &[String], players: &Players) -> Markup {
    let heads = ["driver", "verdict", "impact, m/s", "after, s", "town", "found by"];
    html! {
        h3 { "List of failures" }
        div.wide.list tabindex="0" role="region" aria-label="List of failures" {
            table.stack.sortable {
                thead {
                    tr {
                        @for (place, head) in heads.into_iter().enumerate() {
                            th scope="col" class=[(place == 2 || place == 3).then_some("number")] { (head) }
                        }
                        th scope="col" { "name" }
                    }
                }
                tbody {
                    @for found in listed {
                        @let name = found.name();
                        // A player has one place on the page: that of the first failure of its episode.
                        @let is_first = listed.iter().find(|other| other.name() == name).is_some_and(|first| std::ptr::eq(*first, *found));
                        @let own = players.get(&name).filter(|_| is_first && !cards.contains(&name));
                        tr id=[own.map(|_| Players::id(&name))] {
                            th scope="row" { (found.key.cell.policy) }
                            td data-label=(heads[1]) data-value=(found.class() as usize) {
                                (found.word())
                                @if let Some(violation) = &found.violation { ", " code { (violation.requirement) } }
                            }
                            td.number data-label=(heads[2]) {
                                @if found.violation.is_some() { "–" } @else { (format!("{:.1}", found.impact_speed)) }
                            }
                            td.number data-label=(heads[3]) { (format!("{:.1}", found.length)) }
                            td data-label=(heads[4]) { (found.key.cell.place()) }
                            td data-label=(heads[5]) { (found.finder()) }
                            td data-label="name" {
                                @if let Some(link) = players.link(&name) { a.play href=(link) { "play" } " " }
                                code { (name) }
                                @if let Some(replay) = own { (card(found).data(replay)) }
                            }
                        }
                    }
                }
            }
        }
        p.lead {
            "One failure of each driver, then the others: faults first, then preventable ones; in each class the fastest car first; then violations of requirements. "
            @if players.options().is_some() {
                code { "falsify replay NAME" } " describes a failure, " code { "falsify export NAME --as animation" } " draws it. "
            }
            "The table " code { "failures" } " has all of them."
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::tests::failure;
    use base::signature::Arguments;
    use compile::Driver;
    use verdict::Label;

    #[test]
    fn the_list_has_one_of_each_driver_first() {
        let found = |driver: &str, number, label| {
            let mut found = Failure { number, ..failure(Some(label), false, 1.0) };
            found.key.cell.policy = driver.into();
            found
        };
        let a = found("a", 1, Label::Preventable);
        let b = found("a", 2, Label::Contested);
        let c = found("b", 3, Label::Bump);
        let mut ranked = [(1, &b), (0, &c), (0, &a)];
        ranked.sort_by(|a, b| one_of_each_first(*a, *b));
        assert_eq!(ranked.map(|(_, found)| found.number), [1, 3, 2]);
        let driver = Driver {
            name: "a".into(),
            kind: "idm",
            settings: Arguments::default(),
            changed: Vec::new(),
            sensors: None,
            sensor_model: None,
            surrogate: "",
        };
        let result =
            DriverResult { driver, worst: Some(a.clone()), cell: None, searched: None, price: None, episodes: 1 };
        let page = failures(&[result], &Failures::default(), &[], &Players::default()).into_string();
        assert!(page.contains("List of failures"), "{page}");
    }
}
