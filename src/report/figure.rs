//! Learning curves as a picture.

use std::collections::BTreeMap;

use kuva::prelude::*;

use super::svg::COLOURS;
use crate::campaign::TrainingResult;
use crate::rl::UpdateLog;

/// Draws a quantity of the updates over the steps: the mean over runs, and one standard deviation about it.
///
/// None when no training has any value.
fn curves(
    trainings: &[TrainingResult],
    title: &str,
    label: &str,
    value: &dyn Fn(&UpdateLog) -> Option<f64>,
) -> Option<String> {
    let mut groups: BTreeMap<String, BTreeMap<u64, Vec<f64>>> = BTreeMap::new();
    for training in trainings {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let group = groups.entry(format!("{}, {}, {}", key.reward, key.town, key.policy)).or_default();
        for log in &trained.learning_curve {
            if let Some(value) = value(log) {
                group.entry(log.steps).or_default().push(value);
            }
        }
    }
    let mut plots: Vec<Plot> = Vec::new();
    for ((name, points), colour) in groups.iter().zip(COLOURS.iter().cycle()) {
        if points.is_empty() {
            continue;
        }
        let steps: Vec<f64> = points.keys().map(|steps| *steps as f64).collect();
        let spreads: Vec<(f64, f64)> = points.values().map(|values| mean_and_sd(values)).collect();
        if points.values().any(|values| values.len() > 1) {
            let low = spreads.iter().map(|(mean, sd)| mean - sd);
            let high = spreads.iter().map(|(mean, sd)| mean + sd);
            let band = BandPlot::new(steps.clone(), low, high).with_color(*colour).with_opacity(0.2);
            plots.push(band.into());
        }
        let line = steps.iter().copied().zip(spreads.iter().map(|(mean, _)| *mean));
        plots.push(LinePlot::new().with_data(line).with_color(*colour).with_legend(name.as_str()).into());
    }
    if plots.is_empty() {
        return None;
    }
    let layout = Layout::auto_from_plots(&plots).with_title(title).with_x_label("decisions").with_y_label(label);
    Some(render_to_svg(plots, layout))
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0).max(1.0);
    (mean, variance.sqrt())
}

/// The figures of the trainings, each with its name.
pub fn learning_figures(trainings: &[TrainingResult]) -> Vec<(&'static str, String)> {
    type Quantity = fn(&UpdateLog) -> Option<f64>;
    let quantities: [(&'static str, &str, Quantity); 2] = [
        ("learning_reward", "mean reward of the last 100 episodes", |log| log.mean_reward),
        ("learning_length", "mean length of the last 100 episodes [decisions]", |log| log.mean_length),
    ];
    let figure = |(name, label, value): (&'static str, &str, Quantity)| {
        curves(trainings, "Training: mean over runs ± 1 sd", label, &value).map(|svg| (name, svg))
    };
    quantities.into_iter().filter_map(figure).collect()
}
