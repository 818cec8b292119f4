//! What changed between two drivers, as a text for a terminal and as a page: one HTML file with both episodes of a change side by side.

use maud::{Markup, PreEscaped, html};

use super::page::{OWN_SCRIPTS, Replay, badge, head, json};
use super::table::{Column, Table, Value};
use crate::report::{FailureChange, SideEnd};

/// What the page adds to the style of reports.
const CSS: &str = "\
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(20rem,100%),1fr));gap:1rem}\
.pair>div{min-width:0}.wide{overflow-x:auto;max-width:100%}article.card{max-width:100%}";
/// Maximum number of changes of a word that the page lists.
const MAX_LISTED: usize = 200;

/// The end of the heading of an unchanged section.
const UNCHANGED: &str = ", nothing is new or fixed\n";
/// The title of changes that are none, which a terminal only counts.
const SAME: &str = "same";

/// What changed between two drivers.
#[derive(Debug, Clone, Default)]
pub struct ChangeReport {
    /// What the driver before and the driver after come from.
    pub sides: [String; 2],
    /// The drivers that all rows are about, which then need not say so; empty if they differ.
    pub subject: String,
    /// What a reader must know.
    pub notes: Vec<String>,
    /// The result in a sentence or two.
    pub lead: Vec<String>,
    pub sections: Vec<ChangeSection>,
}

/// A part of it.
#[derive(Debug, Clone, Default)]
pub struct ChangeSection {
    pub heading: String,
    pub paragraphs: Vec<String>,
    pub tables: Vec<Table>,
    /// Whether nothing that is counted is new or fixed; a terminal then has no table.
    pub is_unchanged: bool,
    /// The changes that it lists, by their words.
    pub changes: Vec<FailureChange>,
}

/// A change with both of its episodes.
#[derive(Debug, Clone)]
pub struct PlayedPair {
    pub change: FailureChange,
    /// The episode of the driver before and of the driver after.
    pub replays: [Replay; 2],
    /// The commands that show them.
    pub commands: [String; 2],
}

/// The text for a terminal of this width (columns). `shown` is the maximum number of changes in each list.
pub fn change_text(report: &ChangeReport, shown: usize, width: u16) -> String {
    let [before, after] = &report.sides;
    let mut text = format!("before  {before}\nafter   {after}\n");
    report.notes.iter().for_each(|note| text.push_str(&format!("note    {note}\n")));
    if !report.lead.is_empty() {
        text.push_str(&format!("\n{}\n", report.lead.join("\n")));
    }
    for section in &report.sections {
        if section.is_unchanged {
            let gap = if text.ends_with(UNCHANGED) { "" } else { "\n" };
            text.push_str(&format!("{gap}{}{UNCHANGED}", section.heading));
            continue;
        }
        text.push_str(&format!("\n{}\n", section.heading));
        section.tables.iter().for_each(|table| text.push_str(&table.to_terminal(width)));
        section.paragraphs.iter().for_each(|paragraph| text.push_str(&format!("{paragraph}\n")));
        for (title, all) in section.lists() {
            if title == SAME {
                text.push_str(&format!("\n{title}: {}; `--page FILE` lists them\n", all.len()));
                continue;
            }
            let rest = if all.len() > shown { ": `--page FILE` has all" } else { "" };
            text.push_str(&format!("\n{title}: {}, the worst first{rest}\n", all.len()));
            text.push_str(&list(&all[..all.len().min(shown)], &report.subject).to_terminal(width));
        }
    }
    text
}

impl ChangeSection {
    /// The changes of each word that has some, with the title of the word.
    fn lists(&self) -> impl Iterator<Item = (&'static str, Vec<&FailureChange>)> {
        let titles = [
            "new",
            "worse, a collision of both that is at least 1 m/s faster after, a fault only after, or faster and therefore no fault",
            "fixed",
            "better, a collision of both that is at least 1 m/s slower after, or a fault only before",
            "not met, a collision before, of a pedestrian who would miss the new driver even if that saw nobody",
            SAME,
        ];
        let of_word = |(word, title)| (title, FailureChange::of_word(&self.changes, word));
        FailureChange::WORDS.into_iter().zip(titles).map(of_word).filter(|(_, all)| !all.is_empty())
    }
}

/// A place without the drivers that all rows are about.
pub fn without(subject: &str, place: &str) -> String {
    match subject {
        "" => place.into(),
        _ => place.replacen(&format!("{subject} in "), "", 1).replacen(&format!(", {subject}, "), ", ", 1),
    }
}

/// Changes with the names of both episodes, or with the one that a recheck has; without kinds where none is known, and without the drivers that all are about.
fn list(changes: &[&FailureChange], subject: &str) -> Table {
    let is_renamed = changes.iter().any(|change| change.sides[0].name != change.sides[1].name);
    let has_kind = changes.iter().any(|change| !change.collision().kind.is_empty());
    let mut head = vec![Column::text(if is_renamed { "after" } else { "episode" })];
    head.extend(is_renamed.then(|| Column::text("before")));
    head.push(Column::text("verdict"));
    head.extend(["m/s before", "m/s after"].map(Column::number));
    head.push(Column::text("where"));
    head.extend(has_kind.then(|| Column::text("kind")));
    let row = |change: &&FailureChange| {
        let [before, after] = &change.sides;
        let speed = |side: &SideEnd| Value::number(side.collision.as_ref().map(|found| found.impact_speed), 1);
        let mut row = vec![Value::code(after.name.clone())];
        row.extend(is_renamed.then(|| Value::code(before.name.clone())));
        row.extend([change.verdict().into(), speed(before), speed(after), without(subject, &change.place).into()]);
        row.extend(has_kind.then(|| change.collision().kind.clone().into()));
        row
    };
    Table { head, rows: changes.iter().map(row).collect(), ..Table::default() }
}

/// The page. It needs no other file and no network.
pub fn change_page(report: &ChangeReport, pairs: &[PlayedPair]) -> String {
    let [before, after] = &report.sides;
    let page = html! {
        (PreEscaped("<!doctype html>"))
        html lang="en" {
            (head(&format!("Comparison of {before} and {after}"), None, OWN_SCRIPTS, &[CSS]))
            body {
                header.top {
                    p.kind { "falsify · comparison" }
                    h1 { "What changed" }
                    @for line in &report.lead { p.lead { (line) } }
                    p.meta { "before " code { (before) } " · after " code { (after) } }
                    @for note in &report.notes { p.warn { (with_code(note)) } }
                    button #theme type="button" hidden { "Dark" }
                }
                main #main {
                    @if !pairs.is_empty() {
                        section #played {
                            h2 { "Side by side" }
                            @for (number, pair) in pairs.iter().enumerate() { (card(number, pair)) }
                        }
                    }
                    @for section in &report.sections {
                        section {
                            h2 { (section.heading) }
                            @for paragraph in &section.paragraphs { p { (paragraph) } }
                            @for table in &section.tables { div.wide { (table.to_html()) } }
                            @for (title, all) in section.lists() {
                                details.all {
                                    summary { (title) ": " (all.len()) ", the worst first" }
                                    div.wide { (list(&all[..all.len().min(MAX_LISTED)], &report.subject).to_html()) }
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

fn card(number: usize, pair: &PlayedPair) -> Markup {
    let (change, collision) = (&pair.change, pair.change.collision());
    html! {
        article.card {
            header {
                h3 { (change.word()) ": " (collision.kind) }
                (badge(collision.class, &change.verdict()))
            }
            p.where { (change.place) }
            div.pair {
                @for (side, word) in ["before", "after"].into_iter().enumerate() {
                    div {
                        p {
                            strong { (word) } ": "
                            @match &change.sides[side].collision {
                                Some(found) => { (format!("collision at {:.1} m/s", found.impact_speed)) },
                                None => { "no collision" },
                            }
                        }
                        div.player data-replay={ "replay-" (number) "-" (side) } {}
                        p.replay { code { (pair.commands[side]) } }
                        script type="application/json" id={ "replay-" (number) "-" (side) } { (PreEscaped(json(&pair.replays[side]))) }
                    }
                }
            }
        }
    }
}
