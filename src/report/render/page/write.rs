use super::examples::repeat_examples;
use super::identity::{Named, named};
use super::{Contents, ModeCard, page};
use crate::analysis::{Impact, Kind};
use crate::campaign::Finished;
use crate::compile::Campaign;
use crate::record::CellKey;
use crate::report::failure_modes::{CellModes, Mode};
use crate::report::render::sections::{comparisons, learnt, published_section, search_section, transfer};
use crate::report::{
    Cell, Gathered, Manifest, ReportFolder, SearchKind, WriteError, beside, doubts, search_cells, search_kinds,
};
use crate::seed::Seed;

/// Writes the page of a report, and its figures as files.
///
/// # Errors
/// A table that cannot be read or a file that cannot be written.
pub fn write_page(
    folder: &ReportFolder,
    campaign: &Campaign,
    finished: &Finished,
    gathered: &Gathered,
    manifest: &Manifest,
    cells: &[Cell],
    modes: &[CellModes<'_>],
) -> Result<(), WriteError> {
    let failed = |source| WriteError::Table { name: "report.html".into(), source };
    let names = named(cells);
    let mut cards: Vec<ModeCard> =
        modes.iter().flat_map(|cell| cell.modes.iter().filter_map(|mode| card(&cell.key, mode, &names))).collect();
    cards.extend(search_kinds(&finished.searches).iter().map(searched_card));
    repeat_examples(&mut cards, campaign, finished, &Seed::root(manifest.seed));
    let published = beside(&campaign.published, cells);
    let searched = search_cells(&finished.searches);
    let searches = (!searched.is_empty()).then(|| search_section(&searched));
    let doubts = if manifest.smoke { Vec::new() } else { doubts(&gathered.evidence.cells) };
    let sections: Vec<_> = [
        searches,
        learnt(cells, &gathered.evidence, &doubts),
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
        runs: &gathered.runs,
        tally: &gathered.tally,
        trainings: &finished.trainings,
        modes: &cards,
        published: &published,
        published_section: published_section(&published),
        sections: &sections,
        doubts: &doubts,
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
    Some(ModeCard {
        place: named.place.clone(),
        who: named.who.clone(),
        trained: key.is_trained(),
        failures: (mode.share * f64::from(named.cell.collisions)).round() as usize,
        share: mode.share,
        impact_speed: middle,
        length: mode.length,
        example,
        ..of_kind(mode.kind, &speed, mode.length)
    })
}

/// The card of a kind of failure that searches found.
fn searched_card(found: &SearchKind) -> ModeCard {
    let speed = format!("Half of them at {:.1} m/s or more", found.impact_speed);
    ModeCard {
        place: format!("{} · {}", found.key.town, found.key.policy),
        who: format!("search: {}", found.key.falsifier),
        failures: found.failures,
        share: found.share,
        impact_speed: found.impact_speed,
        length: found.length,
        example: found.example_name(),
        ..of_kind(found.kind, &speed, found.length)
    }
}

/// The words about a kind of collision, with a usual time of the contact (s).
fn of_kind(kind: Kind, speed: &str, length: f64) -> ModeCard {
    let side = match kind.impact {
        Impact::Front => "the front",
        Impact::Left => "the left side",
        Impact::Right => "the right side",
        Impact::Rear => "the rear",
    };
    let speed = if kind.moving { speed } else { "The car stood" };
    let late = if kind.occluded { " The pedestrian came into sight too late for a careful human." } else { "" };
    let mode = kind.mode.name().replace('_', " ");
    ModeCard {
        title: if kind.moving {
            format!("Into {side} of the moving car")
        } else {
            format!("At {side} of the standing car")
        },
        about: format!(
            "{speed}; contact after {length:.1} s. At the last decision the driver’s mode was {mode}.{late}"
        ),
        verdict: kind.verdict.name(),
        ..ModeCard::default()
    }
}
