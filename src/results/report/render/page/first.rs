//! What is seen first: who was tested, what is wrong, how often and how bad.

use maud::{Markup, html};

use super::Players;
use super::markup::{count, percent, prose};
use super::player_card::{PlayerCard, badge};
use super::worst::card;
use crate::failure::Failure;
use crate::report::render::sections::{FAULT, Scale, injury, place, who};
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
            details { summary { "All numbers of the drivers" } (numbers.to_html(&|name| players.link(name))) }
        }
    }
}

/// A block for each driver, on common scales.
fn blocks(all: &Findings<'_>, players: &Players) -> Markup {
    let Findings { drivers, cells, .. } = all;
    let cell = |result: &DriverResult| result.cell.map(|cell| &cells[cell]);
    let most = |of: &dyn Fn(&DriverResult) -> Option<f64>| drivers.iter().filter_map(of).fold(0.0, f64::max);
    let often = |result: &DriverResult| match cell(result) {
        Some(cell) => cell.value(&FAULT_RATE),
        None => result.searched.and_then(|found| found.fault_start_rate),
    };
    let bad = |result: &DriverResult| injury(result, cells);
    let scale = Scale::new(drivers, cells, &all.searches);
    let faults_of = |result: &DriverResult| scale.of_driver(result, &FAULT_RATE, |searched| searched.fault_start_rate);
    // The worst driver of a place is no share of itself.
    let share = |share: Option<f64>| {
        let share = share.filter(|share| *share > 0.0 && (scale.blind().is_some() || *share < 1.0))?;
        Some(share_of(share, scale.blind()))
    };
    html! {
        p.note {
            (prose(FAULT)) " "
            @if cells.is_empty() { "Rates are means over each driver’s searches." }
            @else { "Rates are of each driver’s worst pedestrian and town, and so are shares." }
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
                                @if drivers.len() > 1 { (bar(rate, most(&often), blind)) }
                                (faults(result, cell(result), rate))
                                @if !blind { @if let Some(share) = share(faults_of(result)) { (share) } }
                            }
                        }
                    }
                    @if let Some(injury) = bad(result).filter(|injury| *injury > 0.0) {
                        div {
                            dt { "how bad" }
                            dd {
                                @if drivers.len() > 1 { (bar(injury, most(&bad), blind)) }
                                (format!("{injury:.2}")) " avoidable severe injuries in 1,000 episodes"
                                @if !blind { @if let Some(share) = share(scale.injury_of(result)) { (share) } }
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
    let docs = word.map_or("", |word| word.docs.as_str());
    prose(docs.split_inclusive(". ").next().unwrap_or_default().trim_end())
}

/// What a failure is, in the words of its card.
fn worst(found: &Failure, players: &Players) -> Markup {
    html! {
        p {
            (badge(found.class(), found.word())) " "
            @match players.get(&found.name()) {
                Some(replay) => (prose(&replay.short)),
                None => (format!("A collision at {:.1} m/s.", found.impact_speed)),
            }
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

/// A share of the scale, in words.
fn share_of(share: f64, blind: Option<&str>) -> Markup {
    html! {
        b {
            (format!("{share:.2}")) " of "
            @match blind { Some(name) => { (name) "’s there" }, None => "the worst driver’s there" }
        }
    }
}

/// A bar whose full width is the greatest value of all drivers.
fn bar(value: f64, most: f64, pale: bool) -> Markup {
    let width = if most > 0.0 { 100.0 * value / most } else { 0.0 };
    html! {
        svg.meter viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true" {
            rect.h0 width="100" height="6" {}
            rect class=(if pale { "f6" } else { "v0" }) width=(px(width)) height="6" {}
        }
    }
}
