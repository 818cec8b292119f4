use super::Players;
use super::make::page;
use super::worst::{listed, worst};
use crate::failure::Failure;
use crate::report::render::table::Section;
use crate::report::{FIGURES, Findings, Manifest, PlayedFailure, ReportFolder, WriteError, worst_failure};

/// Maximum number of failures that are played although their driver is a program of the user.
const MAX_FIRST: usize = 14;
/// Maximum number of failures that can be played, so that the page stays small.
const MAX_PLAYED: usize = 44;
/// Maximum number of violations of evaluations that can be played.
const MAX_VIOLATIONS: usize = 12;

/// The names of the failures that the page plays, each once, the most important first: the worst, the distinct ones, then the first of the list. A program of
/// the user may take long to start, so of its failures only the first are played.
pub fn page_examples(found: &Findings<'_>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let add = |names: &mut Vec<String>, name: String, most: usize| {
        if names.len() < most && !names.contains(&name) {
            names.push(name);
        }
    };
    let worst = worst_failure(&found.drivers).into_iter().chain(worst(&found.drivers)).map(Failure::name);
    let examples = found.distinct.iter().map(|each| each.failure.name());
    worst.chain(examples).for_each(|name| add(&mut names, name, MAX_FIRST));
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
    of_cells.for_each(|(_, name)| add(&mut names, name, MAX_PLAYED));
    let violations = found.gathered.failures.violations();
    let own = violations.filter(|failure| !is_external(&failure.key.cell.policy)).take(MAX_VIOLATIONS);
    own.for_each(|failure| add(&mut names, failure.name(), MAX_PLAYED));
    let of_list = listed(&found.drivers, &found.gathered.failures).into_iter();
    of_list
        .filter(|failure| !is_external(&failure.key.cell.policy))
        .for_each(|failure| add(&mut names, failure.name(), MAX_PLAYED));
    names
}

/// Writes the page of a report, and its figures as files.
///
/// # Errors
/// A file that cannot be written.
pub fn write_page(
    folder: &ReportFolder,
    found: &Findings<'_>,
    sections: &[Section],
    played: &[PlayedFailure<'_>],
    manifest: &Manifest,
) -> Result<(), WriteError> {
    for figure in sections.iter().flat_map(|section| &section.figures) {
        folder.file(&figure.file(), figure.to_svg().as_bytes())?;
        folder.file(&format!("{FIGURES}/{}.txt", figure.name), figure.caption().as_bytes())?;
    }
    let options = folder.has_parquet().then(|| manifest.call.replay_options());
    let players = Players::new(played, &found.distinct, &found.cast_failures, options);
    let html = page(found, sections, &players, manifest, &folder.names()?);
    folder.file("report.html", html.as_bytes())
}
