use maud::{Markup, PreEscaped, html};
use polars::prelude::PolarsResult;

use super::Contents;
use super::closing::{data, meaning};
use super::head::{OWN_SCRIPTS, head as head_of_file};
use super::identity::{named, run_rates};
use super::learning::learning;
use super::markup::{count, prose};
use super::modes::modes;
use super::results::results;
use super::severity::{near_misses, severity};
use super::spawns::spawns;
use super::verdicts::verdicts;
use super::worst::{failures, worst};
use crate::report::ListedFailure;
use crate::report::render::sections::{PROTOCOL, drivers};
use crate::report::render::summary::{INCOMPLETE, SMOKE};
use crate::report::render::svg::Figure;
use compile::Campaign;

/// A page with its figures, for callers that also want them as files.
#[derive(Debug, Clone)]
pub struct Page {
    /// The page.
    pub html: String,
    pub figures: Vec<Figure>,
}

/// A section of the page with its place in the list of contents.
struct Part {
    id: &'static str,
    name: &'static str,
    html: Markup,
    figures: Vec<Figure>,
}

/// Makes the page of a report.
///
/// # Errors
/// Those of polars; none for a table made by [`metrics`](crate::report::metrics).
pub fn page(contents: &Contents<'_>) -> PolarsResult<Page> {
    let cells = named(contents.cells);
    let rates = run_rates(contents.runs)?;
    let text = |id, name, html| Part { id, name, html, figures: Vec::new() };
    // The results of a protocol's tests are what its campaign is run for.
    let (leading, others): (Vec<_>, Vec<_>) = contents.sections.iter().partition(|section| section.id == PROTOCOL);
    let mut parts: Vec<Part> =
        leading.into_iter().map(|section| text(section.id, section.name, section.to_html())).collect();
    let link = |found: &ListedFailure| contents.players.link(&found.name());
    if let Some(section) = drivers(contents.drivers, contents.cells, link) {
        parts.push(text(section.id, section.name, section.to_html()));
        parts.push(text("failures", "Failures", failures(contents.drivers, contents.failures, contents.players)));
    }
    if !cells.is_empty() {
        parts.push(text("results", "Results", results(contents, &cells, &rates)));
    }
    parts.extend(contents.published_section.as_ref().map(|each| text(each.id, each.name, each.to_html())));
    parts.extend(figures(
        "verdicts",
        "Avoidable?",
        "Would a careful driver have avoided them?",
        VERDICTS,
        verdicts(&cells),
    ));
    if !contents.modes.is_empty() {
        let worst: Vec<String> = worst(contents.drivers).map(ListedFailure::name).collect();
        let played: Vec<&str> = worst.iter().map(String::as_str).collect();
        parts.push(text("modes", "Kinds", modes(contents.modes, contents.players, &played)));
    }
    parts.extend(figures("speed", "Speed", "How fast the car was", SPEED, severity(contents.tally, &cells)));
    parts.extend(figures("near", "Near misses", "Near misses", NEAR, near_misses(contents.tally, &cells)));
    let starts = spawns(contents.tally, &cells, &contents.campaign.towns);
    parts.extend(figures("places", "Starts", "Where episodes start", "", starts));
    parts.extend(figures("learning", "Learning", "How the controllers learnt", "", learning(contents.trainings)));
    for section in others {
        parts.push(text(section.id, section.name, section.to_html()));
    }
    parts.push(text("meaning", "Names", meaning(contents.campaign)));
    parts.push(text("data", "Data", data(contents.manifest, contents.files)));
    let body = html! {
        a.skip href="#main" { "Skip to the results" }
        (head(contents))
        nav aria-label="Sections" { @for part in &parts { a href={ "#" (part.id) } { (part.name) } } }
        main #main { (key_numbers(contents)) @for part in &parts { (part.html) } }
    };
    let html = document(&contents.campaign.name, &contents.manifest.version, &body, true);
    Ok(Page { html, figures: parts.into_iter().flat_map(|part| part.figures).collect() })
}

/// A file of HTML that needs no other: this body with the style sheet and the scripts, the player's if there are any players.
pub fn document(title: &str, version: &str, body: &Markup, has_players: bool) -> String {
    let html = html! {
        (PreEscaped("<!doctype html>"))
        html lang="en" {
            (head_of_file(title, Some(version), OWN_SCRIPTS, &[]))
            body {
                (body)
                script {
                    (PreEscaped(include_str!("page.js")))
                    @if has_players { (PreEscaped(include_str!("player.js"))) }
                }
            }
        }
    };
    html.into_string() + "\n"
}

/// The most doubts at the top of the page; the section on learning has all.
const DOUBTS: usize = 3;
const VERDICTS: &str = "Each collision was run again with reference drivers, from the instant at which the danger starts. Until one brakes, its car is the \
recorded one. The pedestrian is at the same places at the same times. The careful human is that of UN R157, in both readings. R157 is not written for roads with \
pedestrians, so read the labels as a comparison.";
const NEAR: &str = "Episodes that end without a collision. Least time to collision: the shortest time to a touch at any tick while the car moves, \
if both kept their velocities. Post-encroachment time: between the instant at which one leaves a place and the instant at which the other enters it.";
const SPEED: &str =
    "The height at the left is how often a moving car is hit. Curves that reach far to the right are severe.";

/// A section of figures; none without any.
fn figures(
    id: &'static str,
    name: &'static str,
    title: &str,
    lead: &str,
    figures: impl IntoIterator<Item = Figure>,
) -> Option<Part> {
    let figures: Vec<Figure> = figures.into_iter().collect();
    let html = html! {
        section id=(id) {
            h2 { (title) }
            @if !lead.is_empty() { p.lead { (lead) } }
            @for figure in &figures { (figure.to_html()) }
        }
    };
    (!figures.is_empty()).then_some(Part { id, name, html, figures })
}

/// Name, documentation and how it was run.
fn head(contents: &Contents<'_>) -> Markup {
    let (campaign, manifest) = (contents.campaign, contents.manifest);
    html! {
        header.top {
            p.kind { "falsify · campaign" }
            h1 { (campaign.name) }
            @if !campaign.docs.is_empty() { p.lead { (prose(&campaign.docs.join("\n"))) } }
            @else { p.lead { (grid(campaign)) } }
            @if manifest.smoke { p.warn { (SMOKE) } }
            @if !manifest.complete { p.warn { (INCOMPLETE) } }
            @for lost in contents.lost { p.warn { (prose(&format!("{lost}."))) } }
            @for doubt in contents.doubts.iter().take(DOUBTS) { p.warn { (prose(&format!("{doubt}."))) } }
            @if contents.doubts.len() > DOUBTS {
                p.warn { a href="#learnt" { (contents.doubts.len() - DOUBTS) " more doubts about trainings" } }
            }
            p.meta {
                "seed " (manifest.seed) " · falsify " (manifest.version)
                @for setting in &manifest.settings { " · " code { (setting) } }
            }
            button #theme type="button" hidden { "Dark" }
        }
    }
}

/// What is run, for a campaign without documentation: the drivers and the towns.
fn grid(campaign: &Campaign) -> String {
    let drivers: Vec<&str> = campaign.drivers.iter().map(|driver| driver.name.as_str()).collect();
    let towns: Vec<&str> = campaign.towns.iter().map(|town| town.name.as_str()).collect();
    format!("Drivers: {}. Towns: {}.", drivers.join(", "), towns.join(", "))
}

/// A few key numbers.
fn key_numbers(contents: &Contents<'_>) -> Markup {
    let mut tiles: Vec<(String, String)> = Vec::new();
    let episodes: u64 = contents.cells.iter().map(|cell| u64::from(cell.episodes)).sum();
    if episodes > 0 {
        tiles.push((count(episodes), "episodes evaluated".into()));
    }
    if contents.manifest.search_ticks > 0 {
        tiles.push((count(contents.manifest.search_ticks), "simulator ticks of searches".into()));
    }
    let done = contents.trainings.iter().filter(|training| training.result.is_ok()).count();
    if done > 0 {
        let failed = contents.trainings.len() - done;
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        tiles.push((done.to_string(), format!("trainings{failed}")));
    }
    if contents.manifest.errors > 0 {
        tiles.push((
            count(contents.manifest.errors),
            "episodes in which a driver or a controller failed as a program; no number includes them".into(),
        ));
    }
    html! { dl.key { @for (number, what) in tiles { div { dt { (number) } dd { (what) } } } } }
}
