use maud::{Markup, PreEscaped, html};

use super::Players;
use super::closing::{data, meaning};
use super::first::first;
use super::head::{OWN_SCRIPTS, head as head_of_file};
use super::markup::{count, prose};
use super::worst::{failures, worst};
use crate::failure::Failure;
use crate::jobs::TrainingResult;
use crate::report::render::summary::{INCOMPLETE, SMOKE};
use crate::report::render::table::{Depth, Section};
use crate::report::{Findings, Manifest, answer, worst_failure};
use crate::tables::metrics::EPISODES;
use compile::Campaign;

/// A section of the page with its place in the list of found. It can be folded; a script unfolds it where the window is wide.
struct Part {
    id: &'static str,
    name: &'static str,
    title: &'static str,
    /// Whether it stays folded until somebody asks for it.
    deep: bool,
    html: Markup,
}

impl Part {
    fn to_html(&self) -> Markup {
        html! {
            details.part.deep[self.deep] {
                summary { h2 { (self.title) } }
                section id=(self.id) { (self.html) }
            }
        }
    }
}

/// Makes the page of a report. The first section is that of the drivers, if there are any.
pub fn page(
    found: &Findings<'_>,
    sections: &[Section],
    players: &Players,
    manifest: &Manifest,
    files: &[String],
) -> String {
    let (campaign, drivers) = (found.campaign, &found.drivers);
    let (of_drivers, others): (Vec<&Section>, Vec<&Section>) =
        sections.iter().partition(|section| section.id == "drivers");
    let part = |section: &&Section| Part {
        id: section.id,
        name: section.name,
        title: section.title,
        deep: section.depth == Depth::Page,
        html: section.to_html(&|name| players.link(name)),
    };
    let mut parts: Vec<Part> = others.iter().map(part).collect();
    if !drivers.is_empty() {
        let very_worst = worst_failure(drivers).into_iter();
        let cards: Vec<String> = very_worst.chain(worst(drivers)).map(Failure::name).collect();
        let html = failures(drivers, &found.gathered.failures, &cards, players);
        // The results of a protocol's tests are what its campaign is run for: the failures follow.
        let place = usize::from(parts.first().is_some_and(|part| part.id == "protocol"));
        parts.insert(place, Part { id: "failures", name: "Failures", title: "Failures", deep: false, html });
    }
    let names = ("meaning", "Names", "Names of the scenario", meaning(campaign));
    for (id, name, title, html) in [names, ("data", "Data", "Data", data(manifest, files))] {
        parts.push(Part { id, name, title, deep: true, html });
    }
    let body = html! {
        a.skip href="#main" { "Skip to the results" }
        (head(found, manifest))
        nav aria-label="Sections" {
            @for section in &of_drivers { a href={ "#" (section.id) } { (section.name) } }
            @for part in &parts { a href={ "#" (part.id) } { (part.name) } }
        }
        main #main {
            @for section in &of_drivers { (first(found, section, players)) }
            @for part in &parts { (part.to_html()) }
        }
    };
    document(&campaign.name, &manifest.version, &body, true)
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

/// A line for a name that a reader may write, and the date of the file, which the script reads: the bytes of a page are the same at any time.
pub fn author_and_date() -> Markup {
    html! {
        p.meta { "Author: " span #author contenteditable="plaintext-only" role="textbox" aria-label="Author" {} " " time #made hidden {} }
    }
}

/// Maximum number of doubts at the top of the page; the section on learning has all.
const MAX_DOUBTS: usize = 3;

/// Name, documentation and how it was run.
fn head(found: &Findings<'_>, manifest: &Manifest) -> Markup {
    let campaign = found.campaign;
    html! {
        header.top {
            h1 { (campaign.name) }
            (author_and_date())
            @if !campaign.docs.is_empty() { p.lead { (prose(&campaign.docs.join("\n"))) } }
            @else { p.lead { (grid(campaign)) } }
            @for sentence in answer(found) { p.lead { b { (sentence) "." } } }
            @if manifest.smoke { p.warn { (SMOKE) } }
            @if !manifest.complete { p.warn { (INCOMPLETE) } }
            @for caution in &found.cautions { p.warn { (prose(&format!("{caution}."))) } }
            @for doubt in found.doubts.iter().take(MAX_DOUBTS) { p.warn { (prose(&format!("{doubt}."))) } }
            @if found.doubts.len() > MAX_DOUBTS {
                p.warn { a href="#beats-untrained" { (found.doubts.len() - MAX_DOUBTS) " more doubts about trainings" } }
            }
            @if manifest.errors > 0 {
                p.warn {
                    "In " (count(manifest.errors)) " episodes a driver or a pedestrian failed as a program; no number includes them."
                }
            }
            p.meta {
                @for part in amount(found, manifest) { (part) " · " }
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
    format!("Are there faults of {} in {}?", drivers.join(", "), towns.join(", "))
}

/// How much was run, in a line.
fn amount(found: &Findings<'_>, manifest: &Manifest) -> Vec<String> {
    let mut parts = Vec::new();
    let episodes: u64 = found.cells.iter().map(|cell| u64::from(cell.count(&EPISODES))).sum();
    if episodes > 0 {
        parts.push(format!("{} episodes evaluated", count(episodes)));
    }
    if manifest.search_ticks > 0 {
        parts.push(format!("{} simulator ticks of searches", count(manifest.search_ticks)));
    }
    let done = found.finished.all::<TrainingResult>().iter().filter(|training| training.result.is_ok()).count();
    if done > 0 {
        let failed = found.finished.all::<TrainingResult>().len() - done;
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        parts.push(format!("{done} trainings{failed}"));
    }
    parts
}
