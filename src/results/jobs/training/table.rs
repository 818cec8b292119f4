use super::TrainingResult;
use crate::record::Table;
use crate::record::columns::{REWARD, RUN, TRAIN_DRIVER, TRAIN_TOWN};
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
    type Row<'a> = Update<'a>;
    Table::new(
        "learning_curve",
        "One row for each PPO update of each training. The names in parentheses are those of stable-baselines3.",
    )
    .column(REWARD.of(|row: &Row<'_>| row.0.reward.clone()))
    .column(TRAIN_TOWN.of(|row: &Row<'_>| row.0.town.clone()))
    .column(TRAIN_DRIVER.of(|row: &Row<'_>| row.0.policy.clone()))
    .column(RUN.of(|row: &Row<'_>| row.0.run))
    .count("update", "number of the update, from 1 (`time/iterations`)", |row| row.1.update)
    .count("steps", "decisions up to its end, over all environments (`total_timesteps`)", |row| row.1.steps)
    .count("episodes", "episodes that ended in this update", |row| row.1.episodes as u64)
    .number(
        "mean_reward",
        "mean reward of the last episodes that ended, up to 100; missing before the first; the scenario's reward, \
         without any shaping (`rollout/ep_rew_mean`)",
        |row| row.1.mean_reward,
    )
    .measure("mean_length_decisions", "decisions", "mean length of the same episodes (`ep_len_mean`)", |row| {
        row.1.mean_length
    })
    .number(
        "collision_rate",
        "share of the same episodes that ended in a collision (`rollout/success_rate`); the pedestrian explores: its \
         actions are drawn, as those of the pedestrian `stochastic`, where `trained` takes the mean action",
        |row| row.1.success_rate,
    )
    .number(
        "fault_rate",
        "share of the same episodes that ended in a fault of the driver; missing where the reward asks for no \
         judgement",
        |row| row.1.fault_rate,
    )
    .measure(
        "approx_kl",
        "nat",
        "divergence between old and new policy, mean over the minibatches of the last epoch (`train/approx_kl`)",
        |row| row.1.approx_kl,
    )
    .number(
        "clip_fraction",
        "share of the decisions whose probability ratio left the clip interval (`train/clip_fraction`)",
        |row| row.1.clip_fraction,
    )
    .number(
        "explained_variance",
        "share of the returns' variance that the critic predicted, at most 1; missing if the returns do not vary \
         (`train/explained_variance`)",
        |row| row.1.explained_variance,
    )
    .measure("entropy", "nat", "entropy of the policy (`train/entropy_loss`, negative)", |row| row.1.entropy)
    .number("value_loss", "mean squared error of the critic (`train/value_loss`)", |row| row.1.value_loss)
}
