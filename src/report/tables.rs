use polars::prelude::{Column, DataFrame, NamedFrom, PlSmallStr, Scalar, Series};

use crate::campaign::EpisodeRow;
use crate::compile::Evaluation;
use crate::env::Ending;
use crate::judge::{NearMiss, Reference, Trial};

/// Episodes as a table, one row each, in the order given. The columns are explained in `reports/README.md`.
pub fn episodes(rows: &[EpisodeRow]) -> DataFrame {
    let text = |name: &str, value: &dyn Fn(&EpisodeRow) -> String| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<String>>()))
    };
    let count = |name: &str, value: &dyn Fn(&EpisodeRow) -> u32| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<u32>>()))
    };
    let mut columns = vec![
        text("run_id", &|row| row.run_id.to_string()),
        text("reward", &|row| row.trained.reward.clone()),
        text("train_town", &|row| row.trained.town.clone()),
        text("train_policy", &|row| row.trained.policy.clone()),
        count("run", &|row| row.trained.run),
        text("pedestrian", &|row| row.pedestrian.into()),
        text("town", &|row| row.town.to_string()),
        text("policy", &|row| row.policy.to_string()),
        text("vehicle", &|row| row.vehicle.to_string()),
        text("adversary", &|row| row.adversary.to_string()),
        count("block", &|row| row.block),
    ];
    columns.extend(outcomes(rows).columns().iter().cloned());
    DataFrame::new(rows.len(), columns).expect("all columns have a value for every row")
}

/// The columns that tell an evaluation's episodes from those of others.
pub(super) fn identity(evaluation: &Evaluation, rows: usize) -> Vec<Column> {
    let text = |name: &str, value: &str| Column::new_scalar(name.into(), Scalar::from(PlSmallStr::from(value)), rows);
    let count = |name: &str, value: u32| Column::new_scalar(name.into(), Scalar::from(value), rows);
    let trained = &evaluation.trained;
    vec![
        text("run_id", &evaluation.id.to_string()),
        text("reward", &trained.reward),
        text("train_town", &trained.town),
        text("train_policy", &trained.policy),
        count("run", trained.run),
        text("pedestrian", evaluation.pedestrian.name()),
        text("town", &evaluation.town),
        text("policy", &evaluation.policy),
        text("vehicle", &evaluation.vehicle),
        text("adversary", &evaluation.adversary),
        count("block", evaluation.block),
    ]
}

/// What became of episodes, without what tells them from those of other evaluations.
pub(super) fn outcomes(rows: &[EpisodeRow]) -> DataFrame {
    let text = |name: &str, value: &dyn Fn(&EpisodeRow) -> String| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<String>>()))
    };
    let count = |name: &str, value: &dyn Fn(&EpisodeRow) -> u32| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<u32>>()))
    };
    let truth = |name: &str, value: &dyn Fn(&EpisodeRow) -> bool| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<bool>>()))
    };
    let number = |name: &str, value: &dyn Fn(&EpisodeRow) -> f64| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<f64>>()))
    };
    let maybe = |name: &str, value: &dyn Fn(&EpisodeRow) -> Option<f64>| {
        Column::from(Series::new(name.into(), rows.iter().map(value).collect::<Vec<Option<f64>>>()))
    };
    let hit = |row: &EpisodeRow| match row.outcome.ending {
        Ending::Collision { front, moving, impact_speed, bearing } => Some((front, moving, impact_speed, bearing)),
        _ => None,
    };
    // A driver that failed has not driven to the end.
    let near = |row: &EpisodeRow| if row.outcome.fault().is_some() { NearMiss::default() } else { row.near_miss };
    let mut columns = vec![
        count("episode", &|row| row.episode),
        text("outcome", &|row| ending(&row.outcome.ending).into()),
        text("error", &|row| row.outcome.fault().map_or(String::new(), |fault| fault.to_string())),
        truth("collision", &|row| hit(row).is_some()),
        truth("front", &|row| hit(row).is_some_and(|(front, ..)| front)),
        truth("moving", &|row| hit(row).is_some_and(|(_, moving, ..)| moving)),
        maybe("impact_speed_mps", &|row| hit(row).map(|(_, _, speed, _)| speed)),
        maybe("impact_bearing_deg", &|row| hit(row).map(|(.., bearing)| bearing.to_degrees())),
        number("episode_reward", &|row| row.outcome.reward),
        number("episode_length_s", &|row| row.outcome.duration),
        count("ticks", &|row| row.outcome.ticks),
        number("least_gap_m", &|row| row.outcome.least_gap),
        maybe("min_ttc_s", &|row| near(row).min_ttc),
        maybe("pet_s", &|row| near(row).pet),
        text("driving_mode", &|row| row.outcome.last_mode.name().into()),
        number("ego_x_m", &|row| row.outcome.spawn.ego.x),
        number("ego_y_m", &|row| row.outcome.spawn.ego.y),
        number("ego_yaw_deg", &|row| row.outcome.spawn.ego.yaw.to_degrees()),
        number("ego_speed_mps", &|row| row.outcome.spawn.ego_speed),
        number("pedestrian_x_m", &|row| row.outcome.spawn.pedestrian.x),
        number("pedestrian_y_m", &|row| row.outcome.spawn.pedestrian.y),
        number("pedestrian_yaw_deg", &|row| row.outcome.spawn.pedestrian.yaw.to_degrees()),
        text("digest", &|row| format!("{:016x}", row.outcome.digest)),
    ];
    columns.push(trail(rows));
    columns.extend(verdicts(rows));
    DataFrame::new(rows.len(), columns).expect("all columns have a value for every row")
}

/// The marks on the way to a collision; missing without one.
fn trail(rows: &[EpisodeRow]) -> Column {
    let trail = |row: &EpisodeRow| row.outcome.is_collision().then(|| row.outcome.trail.to_string());
    Series::new("trail".into(), rows.iter().map(trail).collect::<Vec<Option<String>>>()).into()
}

/// What reference drivers make of the collisions: missing values without one.
fn verdicts(rows: &[EpisodeRow]) -> Vec<Column> {
    let judged = || rows.iter().map(|row| row.verdict.as_ref());
    let series = |name: &str, values: Vec<Option<f64>>| Column::from(Series::new(name.into(), values));
    let truth = |name: &str, values: Vec<Option<bool>>| Column::from(Series::new(name.into(), values));
    let labels: Vec<Option<&str>> = judged().map(|verdict| verdict.map(|verdict| verdict.label.name())).collect();
    let mut columns = vec![
        Column::from(Series::new("verdict".into(), labels)),
        truth("foreseeable", judged().map(|verdict| verdict.map(|verdict| verdict.foreseeable)).collect()),
        series("warning_s", judged().map(|verdict| verdict.map(|verdict| verdict.warning)).collect()),
        series("hidden_share", judged().map(|verdict| verdict.map(|verdict| verdict.sight.hidden)).collect()),
        series("in_sight_s", judged().map(|verdict| verdict.map(|verdict| verdict.sight.seen)).collect()),
    ];
    for reference in Reference::ALL {
        let name = reference.name();
        let trials = || judged().map(|verdict| verdict.map(|verdict| verdict.trial(reference)));
        let avoids = trials().map(|trial| trial.map(Trial::is_avoided));
        columns.push(truth(&format!("{name}_avoids"), avoids.collect()));
        let margins = trials().map(|trial| trial.filter(|trial| trial.is_avoided()).map(|trial| trial.least_gap));
        columns.push(series(&format!("{name}_margin_m"), margins.collect()));
        let reductions = judged().map(|verdict| verdict.map(|verdict| verdict.reduction(reference)));
        columns.push(series(&format!("{name}_impact_speed_reduction_mps"), reductions.collect()));
    }
    columns
}

fn ending(ending: &Ending) -> &'static str {
    match ending {
        Ending::Collision { .. } => "collision",
        Ending::Lost => "lost",
        Ending::Timeout => "timeout",
        Ending::Error(_) => "error",
    }
}
