use super::examples::repeat_examples;
use super::identity::{Named, named};
use super::{Contents, ModeCard, page};
use crate::analysis::{FailureMode, Impact};
use crate::campaign::Finished;
use crate::compile::{Campaign, Evaluation};
use crate::report::{Cell, Gathered, Kinds, Manifest, ReportFolder, WriteError, beside, search_cells};
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
    kinds: &Kinds<'_>,
) -> Result<(), WriteError> {
    let failed = |source| WriteError::Table { name: "report.html".into(), source };
    let names = named(cells);
    let mut cards: Vec<ModeCard> = kinds.modes().filter_map(|mode| card(mode, &names)).collect();
    repeat_examples(&mut cards, campaign, &finished.trainings, &Seed::root(manifest.seed));
    let page = page(&Contents {
        campaign,
        manifest,
        cells,
        runs: &gathered.runs,
        tally: &gathered.tally,
        trainings: &finished.trainings,
        modes: &cards,
        searches: &search_cells(&finished.searches),
        published: &beside(&campaign.published, cells),
        extras: &[],
        files: &folder.names()?,
    })
    .map_err(failed)?;
    for figure in &page.figures {
        folder.file(&format!("{}.svg", figure.name), figure.to_svg().as_bytes())?;
    }
    folder.file("report.html", page.html.as_bytes())
}

/// What the page says of a mode; none for cells that stand in no row of it.
fn card((evaluation, mode, example): (&Evaluation, &FailureMode, String), names: &[Named<'_>]) -> Option<ModeCard> {
    let trained = &evaluation.trained;
    let same = |cell: &Cell| {
        (cell.pedestrian.as_str(), &cell.reward, &cell.trained.0, &cell.trained.1, cell.block)
            == (evaluation.pedestrian.name(), &trained.reward, &trained.town, &trained.policy, evaluation.block)
            && (&cell.town, &cell.policy, &cell.vehicle, &cell.adversary)
                == (&evaluation.town, &evaluation.policy, &evaluation.vehicle, &evaluation.adversary)
    };
    let named = names.iter().find(|named| same(named.cell))?;
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
    let late = if kind.occluded { " It came into sight too late for a careful human." } else { "" };
    Some(ModeCard {
        place: named.place.clone(),
        who: named.who.clone(),
        title: if kind.moving {
            format!("Into {side} of the moving car")
        } else {
            format!("At {side} of the standing car")
        },
        about: format!(
            "{speed}; after {:.1} s. At the last decision the driver’s mode was {}.{late}",
            mode.length,
            kind.mode.name().replace('_', " ")
        ),
        trained: !trained.town.is_empty(),
        verdict: kind.verdict.name(),
        failures: (mode.share * f64::from(named.cell.collisions)).round() as usize,
        share: mode.share,
        impact_speed: middle,
        length: mode.length,
        example,
        replay: None,
    })
}
