use std::collections::BTreeMap;

use super::aggregate::{PROTOCOL, RESULTS, RUNS, protocol_table, results};
use super::failure_modes;
use super::metric_table::METRICS;
use super::render::{Section, page_examples, summary, write_page};
use super::replayed::replayed;
use super::{Findings, Manifest, ReportFolder, WriteError, infer, published, town_map};
use crate::jobs::{KINDS, TrainingResult};
use base::seed::Seed;
use compile::{Training, TrainingKey};
use world::driving::{ACTION_BOUNDS, ACTION_SCALES, inputs};

/// The path of a trained pedestrian in a report, relative to the report's folder; the format is the file's extension.
pub fn pedestrian_file(key: &TrainingKey, format: &str) -> String {
    format!("pedestrians/{}-{}-{}-{}.{format}", key.reward, key.town, key.policy, key.run)
}

/// The path of a trained driver in a report, relative to the report's folder.
pub fn driver_file(key: &TrainingKey) -> String {
    format!("drivers/{}-{}-{}.onnx", key.town, key.policy, key.run)
}

/// Fills a report's folder with all files of a campaign, except the table of episodes, which [`gather`](super::gather) has written.
///
/// # Errors
/// A table that cannot be made or a file that cannot be written.
pub fn write(
    folder: &ReportFolder,
    found: &Findings<'_>,
    sections: &[Section],
    manifest: &Manifest,
) -> Result<(), WriteError> {
    let Findings { campaign, finished, gathered, .. } = found;
    let evidence = &gathered.evidence;
    folder.table(RUNS, &found.runs)?;
    folder.table(RESULTS, &results(&found.cells, &evidence.cells, &gathered.failures))?;
    folder.table(METRICS, &found.metrics)?;
    folder.table("comparisons", &infer::comparison_table(&evidence.comparisons))?;
    folder.table("failure_modes", &failure_modes::failure_modes(&found.modes))?;
    folder.table("explanations", &failure_modes::explanations(&found.modes))?;
    for (name, table) in KINDS.iter().flat_map(|kind| (kind.tables)(found)) {
        folder.table(name, &table)?;
    }
    for town in &campaign.towns {
        let starts = gathered.starts.get(&town.name).cloned().unwrap_or_default();
        folder.file(&format!("town-{}.svg", town.name), town_map(&town.town, &starts).as_bytes())?;
    }
    for training in finished.all::<TrainingResult>() {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let planned = campaign.all::<Training>().find(|planned| planned.key == *key).expect("it was planned");
        if planned.drive.is_some() {
            let metadata = [("falsify", manifest.version.clone()), ("seed", manifest.seed.to_string())]
                .map(|(name, value)| (name.to_string(), value))
                .into();
            let bytes = trained.actor_critic.to_onnx_with(&inputs(), &ACTION_SCALES, &ACTION_BOUNDS, &metadata);
            folder.file(&driver_file(key), &bytes)?;
            continue;
        }
        let bounds = planned.scenario.cast.action_bounds();
        let interface = planned.scenario.cast.interface(&planned.scenario.episode);
        let metadata: BTreeMap<String, String> = [
            ("falsify", manifest.version.clone()),
            ("campaign", campaign.name.clone()),
            ("town", key.town.clone()),
            ("policy", key.policy.clone()),
            ("reward", key.reward.clone()),
            ("run", key.run.to_string()),
            ("seed", manifest.seed.to_string()),
            ("states_stacked", planned.config.frame_stack.to_string()),
            ("action_low", format!("{:?}", bounds.iter().map(|bound| bound.0).collect::<Vec<_>>())),
            ("action_high", format!("{:?}", bounds.iter().map(|bound| bound.1).collect::<Vec<_>>())),
        ]
        .into_iter()
        .chain(interface)
        .map(|(name, value)| (name.to_string(), value))
        .collect();
        folder.file(&pedestrian_file(key, "safetensors"), &trained.actor_critic.to_safetensors(&metadata))?;
        folder.file(&pedestrian_file(key, "onnx"), &trained.actor_critic.to_onnx(&bounds, &metadata))?;
    }
    if !campaign.published.is_empty() {
        folder.table("published", &published(&found.published))?;
    }
    if !gathered.protocol.is_empty() || !found.layers.is_empty() {
        let all: Vec<_> = gathered.protocol.iter().chain(&found.layers).cloned().collect();
        folder.table(PROTOCOL, &protocol_table(&all))?;
    }
    folder.file("summary.md", summary(found, sections, manifest).as_bytes())?;
    folder.file("manifest.toml", manifest.to_toml().as_bytes())?;
    let played = replayed(&page_examples(found), found, &Seed::root(manifest.seed));
    write_page(folder, found, sections, &played, manifest)
}
