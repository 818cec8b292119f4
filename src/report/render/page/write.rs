use super::examples::repeat_examples;
use super::identity::{Named, named};
use super::{Contents, ModeCard, page};
use crate::analysis::Impact;
use crate::campaign::Finished;
use crate::compile::Campaign;
use crate::record::CellKey;
use crate::report::failure_modes::{CellModes, Mode};
use crate::report::render::sections::{comparisons, published_section, search_section, transfer};
use crate::report::{Cell, Gathered, Manifest, ReportFolder, WriteError, beside, search_cells};
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
    repeat_examples(&mut cards, campaign, &finished.trainings, &Seed::root(manifest.seed));
    let published = beside(&campaign.published, cells);
    let searched = search_cells(&finished.searches);
    let searches = (!searched.is_empty()).then(|| search_section(&searched));
    let sections: Vec<_> =
        [searches, comparisons(&gathered.evidence), transfer(&gathered.evidence)].into_iter().flatten().collect();
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
    let example = mode.example_name();
    let mode = &mode.mode;
    let kind = mode.kind;
    let side = match kind.impact {
        Impact::Front => "the front",
        Impact::Left => "the left side",
        Impact::Right => "the right side",
        Impact::Rear => "the rear",
    };
    let [low, middle, high] = mode.impact_speed;
    let speed = if kind.moving {
        format!("Half of them at {middle:.1} m/s or more, most between {low:.1} and {high:.1}")
    } else {
        "The car stood".into()
    };
    let late = if kind.occluded { " The pedestrian came into sight too late for a careful human." } else { "" };
    Some(ModeCard {
        place: named.place.clone(),
        who: named.who.clone(),
        title: if kind.moving {
            format!("Into {side} of the moving car")
        } else {
            format!("At {side} of the standing car")
        },
        about: format!(
            "{speed}; contact after {:.1} s. At the last decision the driver’s mode was {}.{late}",
            mode.length,
            kind.mode.name().replace('_', " ")
        ),
        trained: key.is_trained(),
        verdict: kind.verdict.name(),
        failures: (mode.share * f64::from(named.cell.collisions)).round() as usize,
        share: mode.share,
        impact_speed: middle,
        length: mode.length,
        example,
        replay: None,
    })
}
