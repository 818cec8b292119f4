//! The dossier of a campaign: what was tested, how far that reaches, what was found and why, for a reader who was not there.

mod coverage;
mod finding;
mod provenance;
mod scope;
mod tick_error;

use maud::html;

use super::render::{Section, author_and_date, document};
use super::{Findings, Manifest, answer};
use base::seed::Seed;

/// Said below a heading for which a campaign has nothing.
const NOT_DONE: &str = "**Not done in this campaign.**";

/// Makes the dossier: a file of HTML that needs no other and can be printed. Failures are repeated, shrunk and explained, and some episodes are run again
/// with a shorter tick.
pub fn dossier(found: &Findings<'_>, made: &[Section], manifest: &Manifest, seed: &Seed) -> String {
    let shown = finding::shown(found, seed);
    let sections = [
        scope::scope(found),
        finding::findings(found, &shown),
        scope::requirements(found, made),
        coverage::coverage(found),
        coverage::worlds(found),
        tick_error::tick_error(found, seed),
        scope::models(found, &shown),
        provenance::provenance(manifest),
    ];
    let body = html! {
        header.top {
            p.kind { "falsify · dossier" }
            h1 { (found.campaign.name) }
            (author_and_date())
            button #theme type="button" hidden { "Dark" }
        }
        nav aria-label="Sections" {
            @for section in &sections { a href={ "#" (section.id) } { (section.title) } }
        }
        main #main {
            @for sentence in answer(found) { p.lead { b { (sentence) "." } } }
            section id="bottom-line" { (section("bottom-line", "", finding::bottom_lines(found, &shown), Vec::new()).to_html(&|_| None)) }
            @for (number, section) in sections.iter().enumerate() {
                section id=(section.id) { h2 { (number + 1) " " (section.title) } (section.to_html(&|_| None)) }
            }
        }
    };
    document(&format!("Dossier: {}", found.campaign.name), &manifest.version, &body, false)
}

/// A section whose paragraphs are read before its tables.
fn section(id: &'static str, title: &'static str, lead: Vec<String>, tables: Vec<super::render::Table>) -> Section {
    Section { id, name: title, title, lead, tables, ..Section::default() }
}
