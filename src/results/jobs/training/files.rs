use std::collections::BTreeMap;

use super::TrainingResult;
use crate::report::{Findings, Manifest};
use compile::{Training, TrainingKey};
use world::driving::{ACTION_BOUNDS, ACTION_SCALES, inputs};

/// The path of a trained pedestrian in a report, relative to the report's folder; the format is the file's extension.
pub fn pedestrian_file(key: &TrainingKey, format: &str) -> String {
    format!("pedestrians/{}-{}-{}-{}.{format}", key.reward, key.town, key.policy, key.run)
}

/// The path of a trained driver in a report, relative to the report's folder.
fn driver_file(key: &TrainingKey) -> String {
    format!("drivers/{}-{}-{}.onnx", key.town, key.policy, key.run)
}

/// The networks of a campaign: its pedestrians and its drivers.
pub fn files(found: &Findings<'_>, manifest: &Manifest) -> Vec<(String, Vec<u8>)> {
    let Findings { campaign, finished, .. } = found;
    let mut files = Vec::new();
    for training in finished.all::<TrainingResult>() {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let planned = campaign.all::<Training>().find(|planned| planned.key == *key).expect("it was planned");
        if planned.drive.is_some() {
            let metadata = [("falsify", manifest.version.clone()), ("seed", manifest.seed.to_string())]
                .map(|(name, value)| (name.to_string(), value))
                .into();
            let bytes = trained.actor_critic.to_onnx_with(&inputs(), &ACTION_SCALES, &ACTION_BOUNDS, &metadata);
            files.push((driver_file(key), bytes));
            continue;
        }
        let whole = &planned.scenario.cast;
        // A shared policy moves one pedestrian at a time.
        let first = whole.controlled().next().filter(|_| planned.config.shared.is_some());
        let cast = first.map_or_else(|| whole.clone(), |(number, _)| whole.alone(number));
        let (bounds, interface) = (cast.action_bounds(), cast.interface(&planned.scenario.episode));
        let metadata: BTreeMap<String, String> = [
            ("falsify", manifest.version.clone()),
            ("campaign", campaign.name.clone()),
            ("town", key.town.clone()),
            ("driver", key.policy.clone()),
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
        files.push((pedestrian_file(key, "safetensors"), trained.actor_critic.to_safetensors(&metadata)));
        files.push((pedestrian_file(key, "onnx"), trained.actor_critic.to_onnx(&bounds, &metadata)));
    }
    files
}
