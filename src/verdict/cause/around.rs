use std::sync::Arc;

use rand::RngExt;

use super::{Incident, Plan, Reruns};
use crate::classification_tree::ClassificationTree;
use base::seed::Stream;
use base::signature::short;
use episode::{EgoStart, Scenario, StartParameter};

/// The number of starts that are tried.
const STARTS: u64 = 200;
/// How far they lie from that of the failure at most: a share of the range of each quantity, and of the walking speed.
const SHARE: f64 = 0.25;
/// Minimum number of starts in a leaf of the tree.
const MIN_ROWS: usize = 8;
/// Parts of a cross-validation.
const PARTS: usize = 5;
/// A rule is none if its error is above this, or above this share of the error without a rule.
const MAX_ERROR: (f64, f64) = (0.15, 0.5);
/// A second condition must take away this much of the error.
const MIN_GAIN: f64 = 0.02;

/// How many starts around that of a failure fail too, and which.
#[derive(Debug, Clone, PartialEq)]
pub struct Around {
    pub starts: usize,
    pub failures: usize,
    /// `None` if no rule with one or two numbers tells them apart.
    pub rule: Option<StartRule>,
}

/// Which starts fail, in one or two conditions that hold together.
#[derive(Debug, Clone, PartialEq)]
pub struct StartRule {
    /// Each with the quantity, its unit, a bound in this unit, and whether the quantity is at most the bound.
    pub conditions: Vec<(&'static str, &'static str, f64, bool)>,
    /// The share of held-out starts that it tells wrongly.
    pub error: f64,
    /// The same of the word that fits most starts.
    pub error_without: f64,
}

/// A quantity of a start.
#[derive(Clone, Copy)]
struct Quantity {
    parameter: StartParameter,
    value: f64,
    bounds: (f64, f64),
}

/// Runs starts around that of a failure: the pedestrian at other places about the car, the car faster or slower where its speed is drawn, and the same
/// commands at another speed. The car begins at the same place; what else the scenario draws of a start may be drawn anew. `None` if it is not a failure when it is repeated, if its driver cannot be copied, if
/// there are other actors, or if the scenario draws nothing of this.
pub fn around(incident: &Incident) -> Option<Around> {
    let scenario = &incident.scenario;
    let mut reruns = Reruns::new(incident);
    let base = reruns.run(&incident.commands).filter(|base| reruns.fails(base) && reruns.is_copied())?;
    if scenario.cast.actors().count() > 2 {
        return None;
    }
    let (car, pedestrian) = (base.trace.vehicle(0).first()?.state, base.trace.pedestrian(0).first()?.pose);
    let place = car.pose.to_local(pedestrian.position());
    let plan = Plan::new(&incident.commands, 1);
    let decisions = incident.commands.len() as f64;
    let walking = incident.commands.iter().map(|command| command.speed).sum::<f64>() / decisions;
    let drawn = scenario.start_parameters();
    let quantity = |parameter: StartParameter| {
        let value = match parameter {
            StartParameter::Bearing => libm::atan2(place.y, place.x),
            StartParameter::Distance => place.norm(),
            StartParameter::EgoSpeed => car.speed,
            _ => return None,
        };
        let (low, high) = drawn.iter().find(|drawn| drawn.parameter == parameter)?.distribution.support();
        Some(Quantity { parameter, value, bounds: (low, high) })
    };
    let placed = [StartParameter::Bearing, StartParameter::Distance, StartParameter::EgoSpeed];
    let mut quantities: Vec<Quantity> = placed.into_iter().filter_map(quantity).collect();
    let bounds = scenario.cast.pedestrian().action.speed;
    if walking > 0.0 && bounds.0 < bounds.1 {
        quantities.push(Quantity { parameter: StartParameter::WalkingSpeed, value: walking, bounds });
    }
    if quantities.is_empty() {
        return None;
    }
    let is_placed = quantities.iter().any(|quantity| placed.contains(&quantity.parameter));
    let mut rule = scenario.spawn.clone();
    rule.ego_start = if is_placed { EgoStart::Poses(vec![car.pose]) } else { rule.ego_start };
    let mut tried: Vec<(Vec<f64>, bool)> = Vec::new();
    for number in 0..STARTS {
        let stream = &mut incident.seed.child("around").index(number).stream();
        let values: Vec<f64> = quantities.iter().map(|quantity| quantity.near(stream)).collect();
        let fixed: Vec<_> =
            quantities.iter().zip(&values).map(|(quantity, value)| (quantity.parameter, *value)).collect();
        let first = scenario.cast.pedestrian().first_heading;
        let mut settled = || rule.fixed(&fixed).settled(&scenario.town, &scenario.obstacles, first, stream);
        let Some(spawn) = (if is_placed { settled() } else { Some(rule.clone()) }) else { continue };
        let speed = fixed.iter().find(|(parameter, _)| *parameter == StartParameter::WalkingSpeed);
        let factor = speed.map_or(1.0, |(_, speed)| speed / walking);
        let mut plan = plan.clone();
        for segment in &mut plan.pedestrians[0] {
            segment.command.speed = (factor * segment.command.speed).clamp(bounds.0, bounds.1);
        }
        let mut reruns = Reruns::with(incident, Arc::new(Scenario { spawn, ..Scenario::clone(scenario) }));
        let Some(rerun) = reruns.run(&plan.commands()).filter(|rerun| rerun.outcome.counts()) else { continue };
        tried.push((values, reruns.fails(&rerun)));
    }
    let (rows, fails): (Vec<Vec<f64>>, Vec<bool>) = tried.into_iter().unzip();
    let failures = fails.iter().filter(|fails| **fails).count();
    let rule = Rule::best(&rows, &fails).map(|(rule, error, error_without)| {
        let condition = |(feature, bound, is_at_most): (usize, f64, bool)| {
            let parameter = quantities[feature].parameter;
            let (unit, factor) = parameter.unit();
            (parameter.name(), unit, factor * bound, is_at_most)
        };
        StartRule { conditions: rule.0.into_iter().map(condition).collect(), error, error_without }
    });
    Some(Around { starts: fails.len(), failures, rule })
}

impl Quantity {
    /// A value near that of the failure.
    fn near(&self, stream: &mut Stream) -> f64 {
        let (low, high) = self.bounds;
        let reach = match self.parameter {
            StartParameter::WalkingSpeed => SHARE * self.value,
            _ => SHARE * (high - low),
        };
        (self.value + stream.random_range(-1.0..1.0) * reach).clamp(low, high)
    }
}

/// Conditions that hold together: the quantity, its bound, and whether it is at most the bound.
#[derive(Debug, Clone, PartialEq)]
struct Rule(Vec<(usize, f64, bool)>);

impl Rule {
    fn holds(&self, row: &[f64]) -> bool {
        self.0.iter().all(|(feature, bound, is_at_most)| (row[*feature] <= *bound) == *is_at_most)
    }

    /// The leaf of a tree of this depth with most failures; `None` if no leaf fails.
    fn learn(rows: &[Vec<f64>], fails: &[bool], depth: u16) -> Option<Self> {
        let count = |rule: &Self| rows.iter().zip(fails).filter(|(row, fails)| **fails && rule.holds(row)).count();
        let leaves = ClassificationTree::learn(rows, fails, depth, MIN_ROWS).hits().into_iter().map(Self);
        leaves.max_by_key(count).filter(|rule| !rule.0.is_empty())
    }

    /// The share of rows that rules of this depth tell wrongly which were made of the other rows.
    fn error(rows: &[Vec<f64>], fails: &[bool], depth: u16) -> f64 {
        let mut wrong = 0;
        for part in 0..PARTS {
            let others = (0..rows.len()).filter(|row| row % PARTS != part);
            let (seen, ends): (Vec<Vec<f64>>, Vec<bool>) = others.map(|row| (rows[row].clone(), fails[row])).unzip();
            let rule = Self::learn(&seen, &ends, depth);
            let held_out = (0..rows.len()).filter(|row| row % PARTS == part);
            wrong +=
                held_out.filter(|row| rule.as_ref().is_some_and(|rule| rule.holds(&rows[*row])) != fails[*row]).count();
        }
        wrong as f64 / rows.len().max(1) as f64
    }

    /// The rule with the least error, a short one if a second condition gains little, with its error and that without a rule; `None` if there is none.
    fn best(rows: &[Vec<f64>], fails: &[bool]) -> Option<(Self, f64, f64)> {
        let share = fails.iter().filter(|fails| **fails).count() as f64 / fails.len().max(1) as f64;
        let without = share.min(1.0 - share);
        let errors = [1, 2].map(|depth| Self::error(rows, fails, depth));
        let depth = if errors[1] <= errors[0] - MIN_GAIN { 2 } else { 1 };
        let error = errors[usize::from(depth) - 1];
        let is_one = error <= MAX_ERROR.0 && error <= MAX_ERROR.1 * without;
        is_one.then(|| Self::learn(rows, fails, depth))?.map(|rule| (rule, error, without))
    }
}

impl Around {
    /// The rule in a sentence: `63 of 200 starts around it fail: those with a distance of at most 14.2 m (wrong in 6 %, 32 % without a rule).`
    pub fn sentence(&self) -> String {
        let Self { starts, failures, rule } = self;
        let all = format!("{failures} of {starts} starts around it fail");
        match rule {
            _ if failures == starts => format!("{all}."),
            _ if *failures == 0 => format!("None of {starts} starts around it fails."),
            None => format!("{all}; no rule with one or two numbers says which."),
            Some(StartRule { conditions, error, error_without }) => {
                let condition = |(what, unit, bound, is_at_most): &(&str, &str, f64, bool)| {
                    let word = if *is_at_most { "of at most" } else { "above" };
                    format!("{} {word} {} {unit}", what.replace('_', " "), short((bound * 100.0).round() / 100.0))
                };
                let conditions: Vec<String> = conditions.iter().map(condition).collect();
                let (error, without) = (100.0 * error, 100.0 * error_without);
                format!(
                    "{all}: those with a {} (wrong in {error:.0} % of held-out starts, {without:.0} % without a rule).",
                    conditions.join(" and a ")
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    /// Rows of three numbers, and whether each fails.
    fn rows(fails: impl Fn(&[f64], &mut Stream) -> bool) -> (Vec<Vec<f64>>, Vec<bool>) {
        let stream = &mut Seed::root(3).stream();
        let row = |_| {
            let row: Vec<f64> = (0..3).map(|_| stream.random_range(0.0..10.0)).collect();
            let fails = fails(&row, stream);
            (row, fails)
        };
        (0..200).map(row).unzip()
    }

    #[test]
    fn one_or_two_numbers_are_found_and_noise_has_no_rule() {
        let (one, fails) = rows(|row, _| row[1] <= 4.0);
        let (rule, error, without) = Rule::best(&one, &fails).unwrap();
        let [(1, bound, true)] = rule.0[..] else { panic!("{rule:?}") };
        assert!((bound - 4.0).abs() < 0.2 && error < 0.05 && without > 0.3, "{bound} {error}");
        let (two, fails) = rows(|row, _| row[0] > 5.0 && row[2] <= 6.0);
        let (mut rule, error, _) = Rule::best(&two, &fails).unwrap();
        rule.0.sort_by_key(|(feature, ..)| *feature);
        let [(0, a, false), (2, b, true)] = rule.0[..] else { panic!("{rule:?}") };
        assert!((a - 5.0).abs() < 0.3 && (b - 6.0).abs() < 0.3 && error < 0.07, "{rule:?} {error}");
        let (noise, fails) = rows(|_, stream| stream.random());
        assert_eq!(Rule::best(&noise, &fails), None);
        let (all, fails) = rows(|_, _| true);
        assert_eq!(Rule::best(&all, &fails), None, "all fail: nothing to tell apart");
    }
}
