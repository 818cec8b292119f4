//! A comparison of two sides as a page: one HTML file with both episodes of a change side by side.

use maud::{Markup, PreEscaped, html};

use super::comparison_text::{
    change_title, changes, common_starts, counts, headline, list, power, rates, searches, start_changes, start_list,
    title,
};
use super::page::{OWN_SCRIPTS, Replay, badge, head, json};
use crate::report::{FailureChange, ReportComparison};

/// What the page adds to the style of reports.
const CSS: &str = "\
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(20rem,100%),1fr));gap:1rem}\
.pair>div{min-width:0}.wide{overflow-x:auto;max-width:100%}article.card{max-width:100%}";
/// Most changes of a word that the page lists.
const LISTED: usize = 200;

/// A change with both of its episodes.
#[derive(Debug, Clone)]
pub struct PlayedPair {
    pub change: FailureChange,
    /// The episode of the first side and of the second.
    pub replays: [Replay; 2],
}

/// The page. It needs no other file and no network.
pub fn comparison_page(comparison: &ReportComparison, pairs: &[PlayedPair]) -> String {
    let [before, after] = comparison.folders.each_ref().map(|folder| folder.display().to_string());
    let page = html! {
        (PreEscaped("<!doctype html>"))
        html lang="en" {
            (head(&format!("Comparison of {before} and {after}"), None, OWN_SCRIPTS, &[CSS]))
            body {
                header.top {
                    p.kind { "falsify · comparison" }
                    h1 { "What changed" }
                    p.lead { (headline(comparison)) }
                    @if let Some(power) = power(comparison) { p { (power) } }
                    p.meta { "before " code { (before) } " · after " code { (after) } }
                    @for caveat in &comparison.caveats { p.warn { (with_code(&caveat.to_string())) } }
                    button #theme type="button" hidden { "Dark" }
                }
                nav aria-label="Sections" {
                    a href="#rates" { "Rates" }
                    @if !comparison.searches.is_empty() { a href="#searches" { "Searches" } }
                    a href="#played" { "Side by side" }
                    a href="#failures" { "Failures" }
                }
                main #main {
                    section #rates {
                        h2 { "Rates over common starts" }
                        @for cell in &comparison.cells {
                            h3 { (title(cell)) }
                            p { (common_starts(cell)) }
                            div.wide { (rates(cell).to_html()) }
                        }
                    }
                    @if !comparison.searches.is_empty() {
                        section #searches {
                            h2 { "Searches over the starts that both tried" }
                            p { "Share of these starts from which a fault was found. A search goes where its driver fails, so a start that is fixed was not proved safe." }
                            div.wide { (searches(comparison).to_html()) }
                            @for word in ["new", "fixed"] {
                                @let all = start_changes(comparison, word);
                                @if !all.is_empty() {
                                    details.all {
                                        summary { (word) ": " (all.len()) ", the worst first" }
                                        div.wide { (start_list(&all[..all.len().min(LISTED)]).to_html()) }
                                    }
                                }
                            }
                        }
                    }
                    section #played {
                        h2 { "Side by side" }
                        @if pairs.is_empty() { p { "No start ends in a collision, or in a fault, on one side alone." } }
                        @for (number, pair) in pairs.iter().enumerate() { (card(number, pair, comparison)) }
                    }
                    section #failures {
                        h2 { "Failures" }
                        div.wide { (counts(comparison, "verdict", usize::MAX).to_html()) }
                        div.wide { (counts(comparison, "kind", usize::MAX).to_html()) }
                        @for word in FailureChange::WORDS {
                            @let all = changes(comparison, word);
                            @if !all.is_empty() {
                                details.all {
                                    summary { (change_title(word)) ": " (all.len()) ", the worst first" }
                                    div.wide { (list(&all[..all.len().min(LISTED)]).to_html()) }
                                }
                            }
                        }
                    }
                }
                script { (PreEscaped(include_str!("page/page.js"))) (PreEscaped(include_str!("page/player.js"))) }
            }
        }
    };
    page.into_string() + "\n"
}

/// A sentence in which words between backticks are code.
fn with_code(text: &str) -> Markup {
    html! {
        @for (place, part) in text.split('`').enumerate() {
            @if place % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

fn card(number: usize, pair: &PlayedPair, comparison: &ReportComparison) -> Markup {
    let (change, failure) = (&pair.change, pair.change.failure());
    html! {
        article.card {
            header {
                h3 { (change.word()) ": " (failure.kind()) }
                (badge(failure.class(), &pair.change.verdict()))
            }
            p.where { (title(&comparison.cells[change.cell])) }
            div.pair {
                @for (side, word) in ["before", "after"].into_iter().enumerate() {
                    @let episode = &change.sides[side];
                    div {
                        p {
                            strong { (word) } ": "
                            @match &episode.failure {
                                Some(failure) => { (format!("hit at {:.1} m/s", failure.impact_speed)) },
                                None => { "no collision" },
                            }
                        }
                        div.player data-replay={ "replay-" (number) "-" (side) } {}
                        p.replay { code { "falsify replay " (comparison.folders[side].join(&episode.name).display()) } }
                        script type="application/json" id={ "replay-" (number) "-" (side) } { (PreEscaped(json(&pair.replays[side]))) }
                    }
                }
            }
        }
    }
}
