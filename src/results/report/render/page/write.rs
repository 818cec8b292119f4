use super::identity::{Named, named};
use super::modes::order;
use super::worst::{listed, worst};
use super::{Contents, ModeCard, Players, page};
use crate::analysis::{Impact, Kind};
use crate::jobs::{CoverResult, EstimateResult, HardenResult, TrainingResult};
use crate::record::CellKey;
use crate::report::failure_modes::Mode;
use crate::report::render::sections::{
    comparisons, cover_section, estimates, hardened_section, learnt, protocol, published_section, requirements,
    search_section, transfer,
};
use crate::report::{
    Findings, ListedFailure, Manifest, PlayedFailure, ReportFolder, SearchKind, WriteError, worst_failure,
};

/// The most failures that have cards, and the most that can be played, so that the page stays small.
const CARDS: usize = 14;
const PLAYED: usize = 44;
/// The most violations of evaluations that can be played.
const VIOLATIONS: usize = 12;

/// The names of the failures that the page plays, each once, the most important first: those with cards, then the first of the list. A program of the user
/// may take long to start, so of its failures only those with cards are played.
pub fn page_examples(found: &Findings<'_>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let add = |names: &mut Vec<String>, name: String, most: usize| {
        if names.len() < most && !names.contains(&name) {
            names.push(name);
        }
    };
    let worst = worst_failure(&found.drivers).into_iter().chain(worst(&found.drivers)).map(ListedFailure::name);
    worst.chain(cards(found).into_iter().map(|card| card.example)).for_each(|name| add(&mut names, name, CARDS));
    let is_external =
        |name: &str| found.drivers.iter().any(|each| each.driver.name == name && each.driver.is_external());
    let of_cells = found
        .gathered
        .protocol
        .iter()
        .chain(&found.layers)
        .filter_map(|cell| cell.worst.clone().map(|name| (cell, name)));
    let of_cells = of_cells.filter(|(cell, _)| {
        !found.drivers.iter().any(|each| each.driver.name == cell.policy && each.driver.is_external())
    });
    of_cells.for_each(|(_, name)| add(&mut names, name, PLAYED));
    let violations = found.gathered.failures.violations().iter().map(|(_, failure)| failure);
    let own = violations.filter(|failure| !is_external(&failure.policy)).take(VIOLATIONS);
    own.for_each(|failure| add(&mut names, failure.name(), PLAYED));
    let of_list = listed(&found.drivers, &found.gathered.failures).into_iter();
    of_list.filter(|failure| !is_external(&failure.policy)).for_each(|failure| add(&mut names, failure.name(), PLAYED));
    names
}

/// The cards of the kinds of failures, in their order.
fn cards(found: &Findings<'_>) -> Vec<ModeCard> {
    let names = named(&found.cells);
    let mut cards: Vec<ModeCard> = found
        .modes
        .iter()
        .flat_map(|cell| cell.modes.iter().filter_map(|mode| card(&cell.key, mode, &names)))
        .collect();
    cards.extend(found.search_kinds.iter().map(searched_card));
    let is_blind =
        |name: &str| found.campaign.drivers.iter().any(|driver| driver.name == name && driver.sees_no_pedestrians());
    order(&mut cards, is_blind);
    cards
}

/// Writes the page of a report, and its figures as files.
///
/// # Errors
/// A table that cannot be read or a file that cannot be written.
pub fn write_page(
    folder: &ReportFolder,
    found: &Findings<'_>,
    played: &[PlayedFailure<'_>],
    manifest: &Manifest,
) -> Result<(), WriteError> {
    let failed = |source| WriteError::Table { name: "report.html".into(), source };
    let Findings { campaign, finished, gathered, cells, drivers, published, doubts, .. } = found;
    let cards = cards(found);
    let players = Players::new(played, manifest.call.replay_options());
    let searches = (!found.searches.is_empty()).then(|| search_section(&found.searches, &found.search_comparisons));
    let sections: Vec<_> = [
        protocol(&gathered.protocol, &found.layers, &|name| players.link(name)),
        requirements(cells, &gathered.requirements, &|cell, name| {
            let violations = gathered.failures.violations().iter();
            let named = |failure: &ListedFailure| {
                failure.violation.as_ref().is_some_and(|violation| violation.requirement == name)
            };
            let mut found = violations.filter(|(key, failure)| key == cell && named(failure));
            found.next().and_then(|(_, failure)| players.link(&failure.name()))
        }),
        searches,
        estimates(finished.all::<EstimateResult>()),
        (!found.covers.is_empty()).then(|| cover_section(&found.covers)),
        hardened_section(finished.all::<HardenResult>()),
        learnt(cells, &gathered.evidence, doubts),
        comparisons(&gathered.evidence),
        transfer(&gathered.evidence),
    ]
    .into_iter()
    .flatten()
    .collect();
    let page = page(&Contents {
        campaign,
        manifest,
        cells,
        drivers,
        failures: &gathered.failures,
        players: &players,
        runs: &gathered.runs,
        tally: &gathered.tally,
        trainings: finished.all::<TrainingResult>(),
        modes: &cards,
        covered: finished.all::<CoverResult>(),
        covers: &found.covers,
        published,
        published_section: published_section(published),
        sections: &sections,
        estimates: finished.all::<EstimateResult>(),
        cautions: &found.cautions,
        doubts,
        files: &folder.names()?,
    })
    .map_err(failed)?;
    for figure in &page.figures {
        folder.file(&format!("{}.svg", figure.name), figure.to_svg().as_bytes())?;
    }
    folder.file("report.html", page.html.as_bytes())
}

/// The card of a mode; none for cells without a row on the page.
fn card(key: &CellKey, mode: &Mode, names: &[Named<'_>]) -> Option<ModeCard> {
    let named = names.iter().find(|named| named.cell.key == *key)?;
    let [low, middle, high] = mode.mode.impact_speed;
    let speed = format!("Half of them at {middle:.1} m/s or more, most between {low:.1} and {high:.1}");
    let example = mode.example_name();
    let mode = &mode.mode;
    let (title, about) = words(mode.kind, &speed, mode.length);
    Some(ModeCard {
        place: named.place.clone(),
        driver: key.policy.clone(),
        who: named.who.clone(),
        title,
        about,
        verdict: mode.kind.verdict,
        failures: (mode.share * f64::from(named.cell.collisions)).round() as usize,
        share: mode.share,
        impact_speed: middle,
        length: mode.length,
        example,
    })
}

/// The card of a kind of failure that searches found.
fn searched_card(found: &SearchKind) -> ModeCard {
    let speed = format!("Half of them at {:.1} m/s or more", found.impact_speed);
    let (title, about) = words(found.kind, &speed, found.length);
    ModeCard {
        place: format!("{} · {}", found.key.town, found.key.policy),
        driver: found.key.policy.clone(),
        who: format!("search: {}", found.key.falsifier),
        title,
        about,
        verdict: found.kind.verdict,
        failures: found.failures,
        share: found.share,
        impact_speed: found.impact_speed,
        length: found.length,
        example: found.example_name(),
    }
}

/// A title and a text about a kind of collision, with a usual time of the contact (s).
fn words(kind: Kind, speed: &str, length: f64) -> (String, String) {
    let side = match kind.impact {
        Impact::Front => "the front",
        Impact::Left => "the left side",
        Impact::Right => "the right side",
        Impact::Rear => "the rear",
    };
    let late = if kind.occluded { " The pedestrian came into sight too late for a careful human." } else { "" };
    let mode = kind.mode.name().replace('_', " ");
    (
        format!("Into {side} of the car"),
        format!("{speed}; contact after {length:.1} s. At the touch the driver’s mode was {mode}.{late}"),
    )
}
