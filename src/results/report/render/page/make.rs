use maud::{Markup, PreEscaped, html};
use polars::prelude::PolarsResult;

use super::Contents;
use super::closing::{data, meaning};
use super::covers::covers;
use super::first::first;
use super::head::{OWN_SCRIPTS, head as head_of_file};
use super::identity::{named, run_rates};
use super::learning::learning;
use super::likelihood::likelihoods;
use super::markup::{count, prose};
use super::modes::modes;
use super::results::results;
use super::severity::{near_misses, severity};
use super::spawns::spawns;
use super::verdicts::verdicts;
use super::worst::{failures, worst};
use crate::report::render::sections::PROTOCOL;
use crate::report::render::summary::{INCOMPLETE, SMOKE};
use crate::report::render::svg::Figure;
use crate::report::render::table::Section;
use crate::report::{ListedFailure, worst_failure};
use compile::Campaign;

/// A page with its figures, for callers that also want them as files.
#[derive(Debug, Clone)]
pub struct Page {
    /// The page.
    pub html: String,
    pub figures: Vec<Figure>,
}

/// A section of the page with its place in the list of contents. It can be folded; a script unfolds it where the window is wide.
struct Part {
    id: &'static str,
    name: &'static str,
    title: &'static str,
    html: Markup,
    figures: Vec<Figure>,
}

impl Part {
    fn new(id: &'static str, name: &'static str, title: &'static str, html: Markup) -> Self {
        Self { id, name, title, html, figures: Vec::new() }
    }

    fn of(section: &Section) -> Self {
        Self::new(section.id, section.name, section.title, section.to_html())
    }

    fn to_html(&self) -> Markup {
        html! {
            details.part {
                summary { h2 { (self.title) } }
                section id=(self.id) { (self.html) }
            }
        }
    }
}

/// Makes the page of a report.
///
/// # Errors
/// Those of polars; none for a table made by [`metrics`](crate::report::metrics).
pub fn page(contents: &Contents<'_>) -> PolarsResult<Page> {
    let cells = named(contents.cells);
    let rates = run_rates(contents.runs)?;
    // The results of a protocol's tests are what its campaign is run for: they follow what is wrong with the drivers.
    let (leading, others): (Vec<_>, Vec<_>) = contents.sections.iter().partition(|section| section.id == PROTOCOL);
    let mut parts: Vec<Part> = Vec::new();
    let very_worst = worst_failure(contents.drivers).into_iter();
    let worst: Vec<String> = very_worst.chain(worst(contents.drivers)).map(ListedFailure::name).collect();
    let played: Vec<&str> = worst.iter().map(String::as_str).collect();
    if !contents.drivers.is_empty() {
        let examples = contents.modes.iter().map(|card| card.example.as_str());
        let cards: Vec<&str> = played.iter().copied().chain(examples).collect();
        let html = failures(contents.drivers, contents.failures, &cards, contents.players);
        parts.push(Part::new("failures", "Failures", "Failures", html));
    }
    if !cells.is_empty() {
        parts.push(Part::new("results", "Results", "How often cars are hit", results(contents, &cells, &rates)));
    }
    parts.extend(contents.published_section.as_ref().map(Part::of));
    parts.extend(figures("likely", "How likely", "How likely faults are", LIKELY, likelihoods(contents.estimates)));
    parts.extend(figures(
        "verdicts",
        "Avoidable?",
        "Would a careful driver have avoided them?",
        VERDICTS,
        verdicts(&cells),
    ));
    if !contents.modes.is_empty() {
        let html = modes(contents.modes, contents.players, &played);
        parts.push(Part::new("modes", "Kinds", "Kinds of collisions", html));
    }
    parts.extend(figures("speed", "Speed", "How fast the car was", SPEED, severity(contents.tally, &cells)));
    parts.extend(figures("near", "Near misses", "Near misses", NEAR, near_misses(contents.tally, &cells)));
    let starts = spawns(contents.tally, &cells, &contents.campaign.towns);
    parts.extend(figures("places", "Starts", "Where episodes start", "", starts));
    parts.extend(figures("learning", "Learning", "How the controllers learnt", "", learning(contents.trainings)));
    parts.extend(figures(
        "pictures",
        "Pictures",
        "Where starts pass and fail",
        "",
        covers(contents.covered, contents.covers),
    ));
    parts.extend(others.into_iter().map(Part::of));
    parts.push(Part::new("meaning", "Names", "Names of the scenario", meaning(contents.campaign)));
    parts.push(Part::new("data", "Data", "Data", data(contents.manifest, contents.files)));
    let body = html! {
        a.skip href="#main" { "Skip to the results" }
        (head(contents))
        nav aria-label="Sections" {
            @if !contents.drivers.is_empty() { a href="#drivers" { "Drivers" } }
            @for section in &leading { a href={ "#" (section.id) } { (section.name) } }
            @for part in &parts { a href={ "#" (part.id) } { (part.name) } }
        }
        main #main {
            @if !contents.drivers.is_empty() { (first(contents)) }
            @for section in leading { (Part::of(section).to_html()) }
            @for part in &parts { (part.to_html()) }
        }
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
const LIKELY: &str = "The probability of a fault in an encounter that the scenario draws, with a pedestrian who walks by itself. It is no rate per hour or \
kilometre: that needs a number of encounters.";
const NEAR: &str = "Episodes that end without a collision. Least time to collision: the shortest time to a touch at any tick while the car moves, \
if both kept their velocities. Post-encroachment time: between the instant at which one leaves a place and the instant at which the other enters it.";
const SPEED: &str =
    "The height at the left is how often there is a collision. Curves that reach far to the right are severe.";

/// A section of figures; none without any.
fn figures(
    id: &'static str,
    name: &'static str,
    title: &'static str,
    lead: &str,
    figures: impl IntoIterator<Item = Figure>,
) -> Option<Part> {
    let figures: Vec<Figure> = figures.into_iter().collect();
    let html = html! {
        @if !lead.is_empty() { p.lead { (lead) } }
        @for figure in &figures { (figure.to_html()) }
    };
    (!figures.is_empty()).then_some(Part { id, name, title, html, figures })
}

/// Name, documentation and how it was run.
fn head(contents: &Contents<'_>) -> Markup {
    let (campaign, manifest) = (contents.campaign, contents.manifest);
    html! {
        header.top {
            h1 { (campaign.name) }
            @if !campaign.docs.is_empty() { p.lead { (prose(&campaign.docs.join("\n"))) } }
            @else { p.lead { (grid(campaign)) } }
            @if manifest.smoke { p.warn { (SMOKE) } }
            @if !manifest.complete { p.warn { (INCOMPLETE) } }
            @for caution in contents.cautions { p.warn { (prose(&format!("{caution}."))) } }
            @for doubt in contents.doubts.iter().take(DOUBTS) { p.warn { (prose(&format!("{doubt}."))) } }
            @if contents.doubts.len() > DOUBTS {
                p.warn { a href="#learnt" { (contents.doubts.len() - DOUBTS) " more doubts about trainings" } }
            }
            @if manifest.errors > 0 {
                p.warn {
                    "In " (count(manifest.errors)) " episodes a driver or a controller failed as a program; no number includes them."
                }
            }
            p.meta {
                @for part in amount(contents) { (part) " · " }
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

/// How much was run, in a line.
fn amount(contents: &Contents<'_>) -> Vec<String> {
    let mut parts = Vec::new();
    let episodes: u64 = contents.cells.iter().map(|cell| u64::from(cell.episodes)).sum();
    if episodes > 0 {
        parts.push(format!("{} episodes evaluated", count(episodes)));
    }
    if contents.manifest.search_ticks > 0 {
        parts.push(format!("{} simulator ticks of searches", count(contents.manifest.search_ticks)));
    }
    let done = contents.trainings.iter().filter(|training| training.result.is_ok()).count();
    if done > 0 {
        let failed = contents.trainings.len() - done;
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        parts.push(format!("{done} trainings{failed}"));
    }
    parts
}
