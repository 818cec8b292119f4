use polars::prelude::PolarsResult;

use super::examples::repeat_examples;
use super::identity::{Named, named};
use super::{ComparisonSection, Contents, ModeCard, page};
use crate::analysis::Impact;
use crate::campaign::Finished;
use crate::compile::Campaign;
use crate::record::CellKey;
use crate::report::evidence::{self, Evidence};
use crate::report::failure_modes::{CellModes, Mode};
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
        extras: &extras(&gathered.evidence).map_err(failed)?,
        files: &folder.names()?,
    })
    .map_err(failed)?;
    for figure in &page.figures {
        folder.file(&format!("{}.svg", figure.name), figure.to_svg().as_bytes())?;
    }
    folder.file("report.html", page.html.as_bytes())
}

/// Tables of what is compared.
fn extras(found: &Evidence) -> PolarsResult<Vec<ComparisonSection>> {
    let comparisons = evidence::comparison_table(&found.comparisons).select([
        "reward",
        "train_town",
        "train_policy",
        "pedestrian",
        "other_pedestrian",
        "other_reward",
        "town",
        "policy",
        "figure",
        "value",
        "other_value",
        "difference",
        "difference_student_low",
        "difference_student_high",
        "p_holm",
    ])?;
    let transfers = evidence::transfer_table(&found.transfers).select([
        "reward",
        "pedestrian",
        "changed",
        "home_town",
        "home_policy",
        "away_town",
        "away_policy",
        "figure",
        "home_value",
        "away_value",
        "gap",
        "gap_student_low",
        "gap_student_high",
    ])?;
    Ok(vec![
        ComparisonSection {
            id: "comparisons",
            title: "Compared on the same beginnings",
            lead: "Each trained pedestrian against one that is not trained, or was trained for another reward, on the same beginnings. \
                   The interval is Student’s 95 % over trainings; p is corrected for all comparisons of the campaign (Holm).",
            table: comparisons,
        },
        ComparisonSection {
            id: "transfer",
            title: "Elsewhere",
            lead: "What a trained pedestrian does where it was trained, less what it does in another town or against another driver, with \
                   Student’s 95 % interval over trainings.",
            table: transfers,
        },
    ])
}

/// What the page says of a mode; none for cells that stand in no row of it.
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
