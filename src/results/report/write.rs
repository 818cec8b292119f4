use super::actors::{ACTORS, actors};
use super::aggregate::{PROTOCOL, RESULTS, protocol_table, results};
use super::dossier::dossier;
use super::infer::{COMPARISONS, comparisons};
use super::metric_table::{METRICS, metric_table};
use super::render::{Section, page_examples, summary, write_page};
use super::replayed::replayed;
use super::{DOSSIER, FIGURES, Findings, Manifest, ReportFolder, WriteError, town_map};
use crate::jobs::KINDS;
use base::seed::Seed;

/// Fills a report's folder with all files of a campaign, except the table of episodes, which [`aggregate_episodes`](super::aggregate_episodes) has written.
///
/// # Errors
/// A table that cannot be made or a file that cannot be written.
pub fn write(
    folder: &ReportFolder,
    found: &Findings<'_>,
    sections: &[Section],
    manifest: &Manifest,
    has_dossier: bool,
) -> Result<(), WriteError> {
    let Findings { campaign, gathered, .. } = found;
    let evidence = &gathered.evidence;
    folder.table(RESULTS, &results(found))?;
    folder.table(METRICS, &metric_table(found))?;
    folder.table(COMPARISONS, &comparisons(&evidence.comparisons, found.search_pairs.table()))?;
    for (name, table) in KINDS.iter().filter_map(|kind| (kind.tables)(found)).flatten() {
        folder.table(name, &table)?;
    }
    for town in &campaign.towns {
        let starts = gathered.starts.get(&town.name).cloned().unwrap_or_default();
        folder.file(&format!("{FIGURES}/town-{}.svg", town.name), town_map(&town.town, &starts).as_bytes())?;
    }
    for (name, contents) in KINDS.iter().flat_map(|kind| (kind.files)(found, manifest)) {
        folder.file(&name, &contents)?;
    }
    if !gathered.protocol.is_empty() || !found.layers.is_empty() {
        let all: Vec<_> = gathered.protocol.iter().chain(&found.layers).cloned().collect();
        folder.table(PROTOCOL, &protocol_table().frame(&all))?;
    }
    if !found.cast_failures.is_empty() {
        folder.table(ACTORS, &actors(&found.cast_failures))?;
    }
    folder.file("summary.md", summary(found, sections, manifest).as_bytes())?;
    folder.file("manifest.toml", manifest.to_toml().as_bytes())?;
    if has_dossier {
        folder.file(DOSSIER, dossier(found, sections, manifest, &Seed::root(manifest.seed)).as_bytes())?;
    }
    let played = replayed(&page_examples(found), found, &Seed::root(manifest.seed));
    write_page(folder, found, sections, &played, manifest)
}
