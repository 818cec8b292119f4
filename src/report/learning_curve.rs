use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use crate::campaign::TrainingResult;
use crate::rl::UpdateLog;

/// All updates of all trainings as a table, one row each.
pub fn learning_curve(trainings: &[TrainingResult]) -> DataFrame {
    let updates: Vec<(&TrainingResult, &UpdateLog)> = trainings
        .iter()
        .filter_map(|training| training.result.as_ref().ok().map(|trained| (training, trained)))
        .flat_map(|(training, trained)| trained.learning_curve.iter().map(move |log| (training, log)))
        .collect();
    let text = |name: &str, value: &dyn Fn(&TrainingResult) -> String| {
        let values: Vec<String> = updates.iter().map(|(training, _)| value(training)).collect();
        Column::from(Series::new(name.into(), values))
    };
    let whole = |name: &str, value: &dyn Fn(&UpdateLog) -> u64| {
        Column::from(Series::new(name.into(), updates.iter().map(|(_, log)| value(log)).collect::<Vec<u64>>()))
    };
    let number = |name: &str, value: &dyn Fn(&UpdateLog) -> Option<f64>| {
        let values: Vec<Option<f64>> = updates.iter().map(|(_, log)| value(log)).collect();
        Column::from(Series::new(name.into(), values))
    };
    let runs: Vec<u32> = updates.iter().map(|(training, _)| training.key.run).collect();
    let columns = vec![
        text("reward", &|training| training.key.reward.clone()),
        text("train_town", &|training| training.key.town.clone()),
        text("train_policy", &|training| training.key.policy.clone()),
        Column::from(Series::new("run".into(), runs)),
        whole("update", &|log| log.update),
        whole("steps", &|log| log.steps),
        whole("episodes", &|log| log.episodes as u64),
        number("mean_reward", &|log| log.mean_reward),
        number("mean_length_decisions", &|log| log.mean_length),
        number("approx_kl", &|log| Some(log.approx_kl)),
        number("clip_fraction", &|log| Some(log.clip_fraction)),
        number("explained_variance", &|log| log.explained_variance),
        number("entropy", &|log| Some(log.entropy)),
        number("policy_loss", &|log| Some(log.policy_loss)),
        number("value_loss", &|log| Some(log.value_loss)),
        number("gradient_norm", &|log| Some(log.grad_norm)),
        whole("gradient_steps", &|log| log.gradient_steps),
        number("learning_rate", &|log| Some(log.learning_rate)),
        number("clip", &|log| Some(log.clip_coef)),
        number("action_sd", &|log| Some(log.std)),
    ];
    DataFrame::new(updates.len(), columns).expect("all columns have a value for every row")
}
