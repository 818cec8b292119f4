use super::TrainingResult;
use crate::report::svg::{Chart, Curve, Figure, Panel, short, thousands};
use crate::tables::Metric;
use crate::tables::metrics::LEARNT;
use base::statistics::{self, sample_deviation};
use compile::TrainingKey;
use learn::UpdateLog;

/// The points of a training's curve.
type Points = Vec<(f64, f64)>;

/// The pedestrian that learns nothing, whose level the charts have, and the colour of that.
pub const LEVEL: (&str, usize) = ("intercept", 3);
/// Approximate largest number of points of a curve.
const POINTS: usize = 160;

/// A figure of learning curves.
struct Quantity {
    name: &'static str,
    title: &'static str,
    value: fn(&UpdateLog) -> Option<f64>,
    /// The same of evaluations.
    metric: Option<&'static Metric>,
}

/// The learning curves: mean reward, shares of collisions and faults and mean length of episodes over the decisions of a training.
pub fn learning(trainings: &[TrainingResult], level: Level<'_>) -> Vec<Figure> {
    let [reward, collisions, faults] = LEARNT;
    let quantities = [
        Quantity {
            name: "learning_reward",
            title: "Reward of an episode while exploring, mean of the last 100",
            value: |log| log.mean_reward,
            metric: Some(reward),
        },
        Quantity {
            name: "learning_collisions",
            title: "Share of the last 100 episodes with a collision, with drawn actions as of `stochastic`",
            value: |log| log.success_rate,
            metric: Some(collisions),
        },
        Quantity {
            name: "learning_faults",
            title: "Share of the last 100 episodes with a fault, with drawn actions",
            value: |log| log.fault_rate,
            metric: Some(faults),
        },
        Quantity {
            name: "learning_length",
            title: "Length of an episode in decisions, mean of the last 100",
            value: |log| log.mean_length,
            metric: None,
        },
    ];
    quantities.iter().filter_map(|quantity| figure(trainings, level, quantity)).collect()
}

/// The mean of a metric of the pedestrian that learns nothing, in the town of a training, against its driver and with its reward.
pub type Level<'a> = &'a dyn Fn(&TrainingKey, &Metric) -> Option<f64>;

fn figure(trainings: &[TrainingResult], level: Level<'_>, quantity: &Quantity) -> Option<Figure> {
    let Quantity { name, title, value, metric } = quantity;
    let mut groups: Vec<(String, Vec<Points>, Option<f64>)> = Vec::new();
    for training in trainings {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let group = format!("{} · {} · {}", key.reward, key.town, key.policy);
        let stride = trained.learning_curve.len().div_ceil(POINTS).max(1);
        let last = trained.learning_curve.len().saturating_sub(1);
        let kept = trained.learning_curve.iter().enumerate().filter(|(place, _)| place % stride == 0 || *place == last);
        let curve: Points = kept.filter_map(|(_, log)| Some((log.steps as f64, value(log)?))).collect();
        if curve.is_empty() {
            continue;
        }
        match groups.iter_mut().find(|(known, ..)| *known == group) {
            Some((_, curves, _)) => curves.push(curve),
            None => groups.push((group, vec![curve], metric.and_then(|metric| level(key, metric)))),
        }
    }
    if groups.is_empty() {
        return None;
    }
    let panels = groups.iter().map(|(group, curves, level)| panel(title, group, curves, *level));
    Some(Figure {
        name: (*name).into(),
        title: format!("{title}. Thick: mean over trainings, band ± 1 sd; thin: each training."),
        legend: if groups.iter().any(|(.., level)| level.is_some()) {
            vec![("s0".into(), "trained".into()), (format!("s{}", LEVEL.1), format!("{}, evaluated", LEVEL.0))]
        } else {
            Vec::new()
        },
        panels: panels.collect(),
        ..Figure::default()
    })
}

/// The curves of equal trainings, their mean, and the level beside them.
fn panel(title: &str, group: &str, curves: &[Points], level: Option<f64>) -> Panel {
    let end = curves.iter().flatten().map(|point| point.0).fold(0.0, f64::max);
    let level: Points = level.iter().flat_map(|level| [(0.0, *level), (end, *level)]).collect();
    let all = || curves.iter().flatten().chain(&level);
    let span = |pick: fn(&(f64, f64)) -> f64| {
        all().map(pick).fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (x, y) = (span(|point| point.0), span(|point| point.1));
    let room = ((y.1 - y.0) * 0.06).max(1e-6);
    let chart = Chart {
        size: Chart::SMALL,
        x: (0.0, x.1),
        y: (y.0.min(0.0) - if y.0 < 0.0 { room } else { 0.0 }, y.1 + room),
        x_label: "decisions".into(),
        x_text: thousands,
        y_text: short,
    };
    let mean = mean(curves);
    let ends = mean.points.last().map_or(0.0, |point| point.1);
    let begins = mean.points.first().map_or(0.0, |point| point.1);
    let says = format!("{title}, {} trainings: from {} to {}.", curves.len(), short(begins), short(ends));
    let thin = |points: &Points| Curve { thin: true, points: points.clone(), ..Curve::default() };
    let mut drawn: Vec<Curve> = if curves.len() > 1 { curves.iter().map(thin).collect() } else { Vec::new() };
    drawn.push(Curve { colour: LEVEL.1, points: level.clone(), ..Curve::default() });
    drawn.push(mean);
    chart.panel(group.to_owned(), says, &drawn)
}

/// The mean over curves where all have a value, and one standard deviation around it.
fn mean(curves: &[Points]) -> Curve {
    let mut mean = Curve::default();
    for (x, _) in &curves[0] {
        let values: Vec<f64> =
            curves.iter().filter_map(|curve| curve.iter().find(|point| point.0 == *x)).map(|point| point.1).collect();
        if values.len() < curves.len() {
            continue;
        }
        let middle = statistics::mean(values.iter().copied()).unwrap_or_default();
        mean.points.push((*x, middle));
        mean.band.extend(sample_deviation(values).map(|sd| (middle - sd, middle + sd)));
    }
    if mean.points.is_empty() {
        mean.points = curves[0].clone();
        mean.band.clear();
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_one_standard_deviation_about_the_mean() {
        let curve = mean(&[vec![(0.0, 1.0), (5.0, 2.0)], vec![(0.0, 3.0), (9.0, 2.0)]]);
        assert_eq!(curve.points, [(0.0, 2.0)], "only where all have a value");
        let half = 2.0_f64.sqrt();
        assert_eq!(curve.band, [(2.0 - half, 2.0 + half)]);
        assert!(mean(&[vec![(1.0, 1.0)]]).band.is_empty());
    }
}
