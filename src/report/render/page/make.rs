use std::fmt::Write;

use polars::prelude::PolarsResult;

use super::closing::{data, meaning, prose};
use super::extras::extra;
use super::identity::{Named, named, run_rates};
use super::learning::learning;
use super::markup::{count, escape, percent};
use super::modes::modes;
use super::palette::{FIGURE_CSS, properties};
use super::published::published;
use super::results::results;
use super::searches::searches;
use super::severity::{near_misses, severity};
use super::spawns::spawns;
use super::verdicts::verdicts;
use super::{ComparisonSection, Contents, Figure};

/// A page with the figures on it, for those who want them as files.
#[derive(Debug, Clone)]
pub struct Page {
    /// The page.
    pub html: String,
    /// Its figures.
    pub figures: Vec<Figure>,
}

/// Makes the page of a report.
///
/// # Errors
/// Those of polars; none for a table made by [`metrics`](crate::report::metrics).
pub fn page(contents: &Contents<'_>) -> PolarsResult<Page> {
    let cells = named(contents.cells);
    let rates = run_rates(contents.runs)?;
    let mut body = String::new();
    let mut figures = Vec::new();
    if !cells.is_empty() {
        body.push_str(&results(contents, &cells, &rates));
    }
    body.push_str(&published(contents, &cells));
    if let Some(figure) = verdicts(&cells) {
        section(
            &mut body,
            "verdicts",
            "Would a careful driver have avoided them?",
            VERDICTS,
            std::slice::from_ref(&figure),
        );
        figures.push(figure);
    }
    body.push_str(&modes(contents.modes));
    if let Some(figure) = severity(contents.tally, &cells) {
        section(&mut body, "speed", "How fast the car was", SPEED, std::slice::from_ref(&figure));
        figures.push(figure);
    }
    let near = near_misses(contents.tally, &cells);
    if !near.is_empty() {
        section(&mut body, "near", "Near misses", NEAR, &near);
        figures.extend(near);
    }
    let places = spawns(contents.tally, &cells, &contents.campaign.towns);
    if !places.is_empty() {
        section(&mut body, "places", "Where it begins", "", &places);
        figures.extend(places);
    }
    let curves = learning(contents.trainings);
    if !curves.is_empty() {
        section(&mut body, "learning", "How they learnt", "", &curves);
        figures.extend(curves);
    }
    body.push_str(&searches(contents.searches));
    for each in contents.extras {
        body.push_str(&extra(each)?);
    }
    body.push_str(&meaning(contents.campaign));
    body.push_str(&data(contents.manifest, contents.files));
    let html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <meta name=\"generator\" content=\"falsify {}\">\n<title>{name}</title>\n<style>\n{}{FIGURE_CSS}{}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">Skip to the results</a>\n{}{}<main id=\"main\">{}{body}</main>\n<script>\n{}{}</script>\n</body>\n</html>\n",
        escape(&contents.manifest.version),
        properties(),
        include_str!("page.css"),
        head(contents),
        contents_list(&body, contents.extras),
        key_numbers(contents, &cells),
        include_str!("page.js"),
        include_str!("player.js"),
        name = escape(&contents.campaign.name),
    );
    Ok(Page { html, figures })
}

const VERDICTS: &str = "Each collision was run again with other drivers at the brake, from where the danger began: the same path, the same \
pedestrian at the same places and times, and nobody steers. A careful human is that of UN R157, in both readings; R157 is not written for \
roads with pedestrians, so read the labels as a comparison.";
const NEAR: &str = "Episodes that end without a collision. Least time to collision: both keeping their velocities, the shortest time to a touch at any \
tick while the car moves. Post-encroachment time: between one leaving a place and the other taking it.";
const SPEED: &str =
    "Height on the left is how often a moving car is hit at all; what reaches far to the right is severe.";

fn section(body: &mut String, id: &str, title: &str, lead: &str, figures: &[Figure]) {
    let _ = write!(body, "<section id=\"{id}\"><h2>{title}</h2>");
    if !lead.is_empty() {
        let _ = write!(body, "<p class=\"lead\">{lead}</p>");
    }
    figures.iter().for_each(|figure| body.push_str(&figure.to_html()));
    body.push_str("</section>");
}

/// Name, documentation and how it was run.
fn head(contents: &Contents<'_>) -> String {
    let (campaign, manifest) = (contents.campaign, contents.manifest);
    let mut html =
        format!("<header class=\"top\"><p class=\"kind\">falsify · campaign</p><h1>{}</h1>", escape(&campaign.name));
    if !campaign.docs.is_empty() {
        let _ = write!(html, "<p class=\"lead\">{}</p>", prose(&campaign.docs.join("\n")));
    }
    if manifest.smoke {
        html.push_str(
            "<p class=\"warn\">A smoke run: it shows that everything works, and its numbers mean nothing.</p>",
        );
    }
    if !manifest.complete {
        html.push_str(
            "<p class=\"warn\">Incomplete: it was stopped, a training failed, or a reward was no number. The manifest says which.</p>",
        );
    }
    let _ = write!(html, "<p class=\"meta\">seed {} · falsify {}", manifest.seed, escape(&manifest.version));
    for setting in &manifest.settings {
        let _ = write!(html, " · <code>{}</code>", escape(setting));
    }
    html.push_str("</p><button type=\"button\" id=\"theme\" hidden>Dark</button></header>");
    html
}

/// Links to the sections that there are.
fn contents_list(body: &str, extras: &[ComparisonSection]) -> String {
    let mut html = String::from("<nav aria-label=\"Sections\">");
    let mut link = |id: &str, text: &str| {
        if body.contains(&format!("<section id=\"{id}\"")) {
            let _ = write!(html, "<a href=\"#{id}\">{}</a>", escape(text));
        }
    };
    for (id, text) in [
        ("results", "Results"),
        ("published", "Published"),
        ("verdicts", "Avoidable?"),
        ("modes", "Kinds"),
        ("speed", "Speed"),
        ("near", "Near misses"),
        ("places", "Where"),
        ("learning", "Learning"),
        ("searches", "Falsifiers"),
        ("meaning", "What is what"),
        ("data", "Data"),
    ] {
        if id == "meaning" {
            extras.iter().for_each(|extra| link(extra.id, extra.title));
        }
        link(id, text);
    }
    html + "</nav>"
}

/// A few numbers that say what there is.
fn key_numbers(contents: &Contents<'_>, cells: &[Named<'_>]) -> String {
    let mut tiles: Vec<(String, String)> = Vec::new();
    let episodes: u64 = contents.cells.iter().map(|cell| u64::from(cell.episodes)).sum();
    if episodes > 0 {
        tiles.push((count(episodes), "episodes tried".into()));
    }
    let trained: Vec<&Named<'_>> = cells.iter().filter(|named| named.cell.key.controller == "trained").collect();
    let most = |rate: fn(&Named<'_>) -> Option<f64>| {
        let judged: &[&Named<'_>] = &trained;
        judged.iter().filter_map(|named| Some((rate(named)?, *named))).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let at = |named: &Named<'_>| format!("{}, {}", named.who, named.place);
    if let Some((rate, named)) = most(|named| named.cell.moving.mean) {
        tiles.push((percent(rate), format!("highest rate with a moving car: {}", at(named))));
    }
    if let Some((rate, named)) = most(|named| named.cell.preventable.mean).filter(|(rate, _)| *rate > 0.0) {
        let (low, high) = named.cell.preventable_interval;
        let interval = format!("{} to {}", percent(low), percent(high));
        tiles.push((percent(rate), format!("highest preventable rate ({interval}): {}", at(named))));
    }
    if let Some((speed, named)) = most(|named| named.cell.impact_speed.mean) {
        tiles.push((format!("{speed:.1} m/s"), format!("fastest mean impact: {}", at(named))));
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
            "episodes in which a driver failed as a program; they count nowhere".into(),
        ));
    }
    let list = tiles.iter().fold(String::new(), |text, (number, what)| {
        text + &format!("<div><dt>{}</dt><dd>{}</dd></div>", escape(number), escape(what))
    });
    format!("<dl class=\"key\">{list}</dl>")
}
