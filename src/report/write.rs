use std::collections::BTreeMap;

use super::{
    Kinds, Manifest, ReportFolder, WriteError, episodes, learning_curve, learning_figures, metrics, search_cell_table,
    search_cells, search_failures, search_summary, searches, summary, town_map,
};
use crate::campaign::{EpisodeRow, Finished};
use crate::compile::{Campaign, TrainingKey};
use crate::seed::Seed;

/// Where a report holds a trained pedestrian, relative to its folder; the format is the file's extension.
pub fn pedestrian_file(key: &TrainingKey, format: &str) -> String {
    format!("pedestrians/{}-{}-{}-{}.{format}", key.reward, key.town, key.policy, key.run)
}

/// Fills a report's folder with all that is to be seen of a campaign.
///
/// # Errors
/// A table that cannot be made or a file that cannot be written.
pub fn write(
    folder: &ReportFolder,
    campaign: &Campaign,
    finished: &Finished,
    manifest: &Manifest,
) -> Result<(), WriteError> {
    let failed = |name: &str| {
        let name = name.to_string();
        move |source| WriteError::Table { name, source }
    };
    let episodes = episodes(&finished.rows);
    let metrics = metrics(&episodes).map_err(failed("cells"))?;
    folder.table("episodes", &episodes)?;
    folder.table("runs", &metrics.runs)?;
    folder.table("cells", &metrics.cells)?;
    let mut kinds = Kinds::new(campaign, &finished.trainings, &Seed::root(manifest.seed));
    for run in finished.rows.chunk_by(is_of_one_run) {
        kinds.add(&super::episodes(run)).map_err(failed("failure_modes"))?;
    }
    let kinds = kinds.write(folder)?;
    folder.table("learning_curve", &learning_curve(&finished.trainings))?;
    for (name, svg) in learning_figures(&finished.trainings) {
        folder.file(&format!("{name}.svg"), svg.as_bytes())?;
    }
    for town in &campaign.towns {
        let here = |row: &&EpisodeRow| row.town == town.name && row.pedestrian == "trained";
        let rows: Vec<&EpisodeRow> = finished.rows.iter().filter(here).collect();
        folder.file(&format!("town-{}.svg", town.name), town_map(&town.town, &rows).as_bytes())?;
    }
    for training in &finished.trainings {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let planned = campaign.trainings.iter().find(|planned| planned.key == *key).expect("it was planned");
        let bounds = planned.scenario.adversary.action_bounds();
        let metadata: BTreeMap<String, String> = [
            ("falsify", manifest.version.clone()),
            ("campaign", campaign.name.clone()),
            ("town", key.town.clone()),
            ("policy", key.policy.clone()),
            ("reward", key.reward.clone()),
            ("run", key.run.to_string()),
            ("seed", manifest.seed.to_string()),
            ("states_stacked", planned.config.frame_stack.to_string()),
            ("action_low", format!("{:?}", bounds.map(|bound| bound.0))),
            ("action_high", format!("{:?}", bounds.map(|bound| bound.1))),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        folder.file(&pedestrian_file(key, "safetensors"), &trained.actor_critic.to_safetensors(&metadata))?;
        folder.file(&pedestrian_file(key, "onnx"), &trained.actor_critic.to_onnx(&bounds, &metadata))?;
    }
    let cells = metrics.cells().map_err(failed("cells"))?;
    let mut page = summary(campaign, &cells, manifest);
    page.push_str(&kinds);
    if !finished.searches.is_empty() {
        let cells = search_cells(&finished.searches);
        folder.table("searches", &searches(&finished.searches))?;
        folder.table("search_cells", &search_cell_table(&cells))?;
        folder.table("search_failures", &search_failures(&finished.searches))?;
        page.push_str(&search_summary(&cells));
    }
    folder.file("summary.md", page.as_bytes())?;
    folder.file("manifest.toml", manifest.to_toml().as_bytes())
}

/// Whether two rows are of one pedestrian in one town against one policy.
fn is_of_one_run(a: &EpisodeRow, b: &EpisodeRow) -> bool {
    let place = |row: &EpisodeRow| {
        (row.town.clone(), row.policy.clone(), row.vehicle.clone(), row.adversary.clone(), row.block)
    };
    (&a.trained, a.pedestrian) == (&b.trained, b.pedestrian) && place(a) == place(b)
}
