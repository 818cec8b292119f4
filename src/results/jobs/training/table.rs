use super::TrainingResult;
use crate::record::columns::{REWARD, RUN, TRAIN_DRIVER, TRAIN_TOWN};
use crate::record::{Table, entries};
use crate::report::{self, csv_text};
use compile::TrainingKey;
use learn::UpdateLog;

type Update<'a> = (&'a TrainingKey, &'a UpdateLog);

/// All updates of all trainings as a table, one row each.
pub fn learning_curve(trainings: &[TrainingResult]) -> report::Table {
    let trained = trainings.iter().filter_map(|training| Some((&training.key, training.result.as_ref().ok()?)));
    let updates: Vec<Update<'_>> =
        trained.flat_map(|(key, trained)| trained.learning_curve.iter().map(move |log| (key, log))).collect();
    columns().frame(&updates)
}

/// Updates of one training as lines of CSV, the same as in the table of the report; with a line of names if `head`.
pub fn learning_curve_lines(key: &TrainingKey, updates: &[UpdateLog], head: bool) -> Vec<u8> {
    let rows: Vec<Update<'_>> = updates.iter().map(|log| (key, log)).collect();
    let text = csv_text(&columns().frame(&rows));
    let names = if head { 0 } else { text.find('\n').map_or(0, |end| end + 1) };
    text[names..].into()
}

/// The columns of [`learning_curve`].
pub fn columns<'a>() -> Table<'a, Update<'a>> {
    Table::new(
        "learning_curve",
        "One row for each PPO update of each training. The names in parentheses are those of stable-baselines3.",
    )
    .columns(entries! { row: &Update<'_>;
        REWARD = row.0.reward.clone();
        TRAIN_TOWN = row.0.town.clone();
        TRAIN_DRIVER = row.0.policy.clone();
        RUN = row.0.run;
        /// number of the update, from 1 (`time/iterations`)
        update: u64 = row.1.update;
        /// decisions up to its end, over all environments (`total_timesteps`)
        steps: u64 = row.1.steps;
        /// episodes that ended in this update
        episodes: u64 = row.1.episodes as u64;
        /// mean reward of the last episodes that ended, up to 100; missing before the first; the scenario's reward, without any shaping
        /// (`rollout/ep_rew_mean`)
        mean_reward: f64 = row.1.mean_reward;
        /// mean length of the same episodes (`ep_len_mean`)
        mean_length_decisions: f64 ["decisions"] = row.1.mean_length;
        /// share of the same episodes that ended in a collision (`rollout/success_rate`); the pedestrian explores: its actions are drawn, as those of the
        /// pedestrian `stochastic`, where `trained` takes the mean action
        collision_rate: f64 = row.1.success_rate;
        /// share of the same episodes that ended in a fault of the driver; missing where the reward asks for no judgement
        fault_rate: f64 = row.1.fault_rate;
        /// divergence between old and new policy, mean over the minibatches of the last epoch (`train/approx_kl`)
        approx_kl: f64 ["nat"] = row.1.approx_kl;
        /// share of the decisions whose probability ratio left the clip interval (`train/clip_fraction`)
        clip_fraction: f64 = row.1.clip_fraction;
        /// share of the returns' variance that the critic predicted, at most 1; missing if the returns do not vary (`train/explained_variance`)
        explained_variance: f64 = row.1.explained_variance;
        /// entropy of the policy (`train/entropy_loss`, negative)
        entropy: f64 ["nat"] = row.1.entropy;
        /// mean squared error of the critic (`train/value_loss`)
        value_loss: f64 = row.1.value_loss;
    })
}
