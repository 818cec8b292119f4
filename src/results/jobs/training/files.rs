use std::collections::BTreeMap;

use super::TrainingResult;
use crate::report::{Findings, Manifest};
use compile::{Training, TrainingKey};
use episode::Cast;
use learn::Policies;
use search::driving::{ACTION_BOUNDS, ACTION_SCALES, inputs};

/// The paths of the networks of trained pedestrians in a report, relative to the report's folder, in the order of their policies; the format is the
/// file's extension.
pub fn pedestrian_files(training: &Training, format: &str) -> Vec<String> {
    let TrainingKey { town, policy, reward, run } = &training.key;
    let first = format!("pedestrians/{reward}-{town}-{policy}-{run}");
    let own = |role: Option<&str>| {
        role.map_or_else(|| format!("{first}.{format}"), |role| format!("{first}-{role}.{format}"))
    };
    roles(training).into_iter().map(|(role, _)| own(role)).collect()
}

/// Whom each policy of a training moves: its role, if roles have policies of their own, and the actors that it sees.
fn roles(training: &Training) -> Vec<(Option<&str>, Cast)> {
    let cast = &training.scenario.cast;
    let Some(policies) = training.config.policies else { return vec![(None, cast.clone())] };
    let mut all: Vec<(Option<&str>, Cast)> = Vec::new();
    for ((number, role), agent) in cast.controlled().zip(cast.agents(Some(policies))) {
        if agent.policy == all.len() {
            // A policy moves one pedestrian at a time.
            all.push(((policies == Policies::Each).then_some(&*role.name), cast.alone(number)));
        }
    }
    all
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
            let bytes = trained.policies[0].to_onnx_with(&inputs(), &ACTION_SCALES, &ACTION_BOUNDS, &metadata);
            files.push((driver_file(key), bytes));
            continue;
        }
        let places = pedestrian_files(planned, "safetensors").into_iter().zip(pedestrian_files(planned, "onnx"));
        for (((role, cast), networks), (own, onnx)) in roles(planned).into_iter().zip(&trained.policies).zip(places) {
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
            .chain(role.map(|role| ("role", role.to_owned())))
            .chain(interface)
            .map(|(name, value)| (name.to_string(), value))
            .collect();
            files.push((own, networks.to_safetensors(&metadata)));
            files.push((onnx, networks.to_onnx(&bounds, &metadata)));
        }
    }
    files
}
