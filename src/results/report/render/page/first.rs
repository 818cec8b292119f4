//! What is seen first: who was tested, what is wrong, how often and how bad.

use maud::{Markup, html};

use super::Players;
use super::markup::{count, percent, prose};
use super::player_card::{PlayerCard, badge};
use super::worst::card;
use crate::failure::Failure;
use crate::report::render::sections::{FAULT, injury, place, who};
use crate::report::render::svg::px;
use crate::report::render::table::Section;
use crate::report::{DriverResult, Findings, worst_failure};
use crate::tables::Cell;
use crate::tables::metrics::{EPISODES, FAULT_COLLISIONS, FAULT_RATE};

/// Below this a share of episodes is given as their number.
const RARE: f64 = 0.005;

/// A block for each driver, the worst failure with its player, and the table of all numbers.
pub fn first(all: &Findings<'_>, numbers: &Section, players: &Players) -> Markup {
    let played = worst_failure(&all.drivers).and_then(|found| Some((found, players.get(&found.name())?)));
    html! {
        section #drivers {
            h2.hidden { "What was found" }
            div.first {
                div.found { (blocks(all, players)) }
                @if let Some((found, replay)) = played {
                    @let card = card(found);
                    (PlayerCard { title: format!("The worst: {}", card.title), ..card }.to_html(replay, players.options()))
                }
            }
            @for figure in &numbers.figures { (figure.to_html()) }
            // What a fault is stands above.
            @let notes = numbers.notes.iter().filter(|note| **note != FAULT).cloned().collect();
            @let tables = Section { figures: Vec::new(), notes, ..numbers.clone() };
            details { summary { "All numbers of the drivers" } (tables.to_html(&|name| players.link(name))) }
        }
    }
}

/// A block for each driver, on common scales.
fn blocks(all: &Findings<'_>, players: &Players) -> Markup {
    let Findings { drivers, cells, .. } = all;
    let cell = |result: &DriverResult| result.cell.map(|cell| &cells[cell]);
    let often = |result: &DriverResult| match cell(result) {
        Some(cell) => cell.value(&FAULT_RATE),
        None => result.searched.and_then(|found| found.fault_start_rate),
    };
    html! {
        p.note {
            (prose(FAULT)) " "
            @if cells.is_empty() { "Rates are means over each driver’s searches." }
            @else { "Rates are of the pedestrian and town with each driver’s highest fault rate." }
        }
        @for result in drivers.iter() {
            @let blind = result.driver.sees_no_pedestrians();
            article.driver {
                h3 { (result.driver.name) @if blind { " " span.note { "baseline: sees no pedestrian" } } }
                @if !blind { p.note { (documentation(all, &result.driver.name)) } }
                @match &result.worst {
                    Some(found) => (worst(found, players)),
                    None => p { "No collision was found in " (count(tried(result, cells))) " episodes." },
                }
                @if result.worst.is_some() { dl.measures {
                    @if let Some(rate) = often(result) {
                        div {
                            dt { "how often" }
                            dd {
                                (bar(rate, blind))
                                (faults(result, cell(result), rate))
                            }
                        }
                    }
                    @if let Some(injury) = injury(result, cells).filter(|injury| *injury > 0.0) {
                        div {
                            dt { "how bad" }
                            dd {
                                (format!("{injury:.2}")) " avoidable severe injuries in 1,000 episodes"
                            }
                        }
                    }
                } }
                @if let Some(cell) = cell(result).filter(|_| result.worst.is_some() && cells.len() > drivers.len()) {
                    p.note { "where that is: " (who(cell, cells)) " in " (place(cell, cells)) }
                }
            }
        }
    }
}

/// The episodes of a driver, of evaluations and searches.
fn tried(result: &DriverResult, cells: &[Cell]) -> u64 {
    let evaluated =
        cells.iter().filter(|cell| cell.key.policy == result.driver.name).map(|cell| u64::from(cell.count(&EPISODES)));
    evaluated.sum::<u64>() + result.searched.map_or(0, |found| found.episodes)
}

/// The first sentence of what the scenario says about a driver.
fn documentation(all: &Findings<'_>, name: &str) -> Markup {
    let word = all.campaign.words.iter().find(|word| word.form == "driver" && word.name == name);
    prose(word.map_or("", |word| word.first_sentence()))
}

/// What a failure is, in a line: its card tells how it came.
fn worst(found: &Failure, players: &Players) -> Markup {
    html! {
        p {
            (badge(found.class(), found.word())) " "
            @match &found.violation {
                Some(violation) => { "violates " code { (violation.requirement) } },
                None => (format!("at {:.1} m/s", found.impact_speed)),
            }
            ", by " (found.finder()) " in " (found.key.cell.place())
            @if let Some(link) = players.link(&found.name()) { "\u{a0}" a.play href=(link) { "play" } }
        }
    }
}

/// How often a driver has faults: the share of the episodes of its worst cell, or their number if they are very rare; without any cell the share of
/// the starts of its searches, since a search repeats what fails.
fn faults(result: &DriverResult, cell: Option<&Cell>, rate: f64) -> Markup {
    let searched = result.searched.unwrap_or_default();
    let Some(cell) = cell else {
        return html! {
            @if searched.fault == 0 { "no fault in " (count(searched.episodes)) " episodes of searches" }
            @else { "a fault from " (percent(rate)) " of the starts of searches" }
        };
    };
    let episodes: u64 = cell.count(&EPISODES).into();
    html! {
        @if cell.count(&FAULT_COLLISIONS) == 0 && searched.fault > 0 {
            "no fault in " (count(episodes)) " episodes of evaluations; searches found " (count(searched.fault as u64))
        }
        @else if cell.count(&FAULT_COLLISIONS) == 0 { "no fault in " (count(episodes)) " episodes" }
        @else if rate < RARE { "a fault in " (count(cell.count(&FAULT_COLLISIONS).into())) " of " (count(episodes)) " episodes" }
        @else {
            "a fault in " (percent(rate)) " of " (count(episodes)) " episodes "
            @if let Some((low, high)) = cell.rate(&FAULT_RATE).interval { small { (percent(low)) " to " (percent(high)) } }
        }
    }
}

/// A bar whose full width is 100 %.
fn bar(share: f64, pale: bool) -> Markup {
    let width = 100.0 * share;
    html! {
        svg.meter viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true" {
            rect.h0 width="100" height="6" {}
            rect class=(if pale { "f6" } else { "v0" }) width=(px(width)) height="6" {}
        }
    }
}
