use std::sync::Arc;

use super::experiments::Experiments;
use super::{Change, TurnedBy};
use crate::natural_traffic;
use episode::{PolicyMaker, Scenario, Setting};

/// Ratios of a setting's value that are tried, and values in its unit if it is 0: no more than what people would set.
const RATIOS: [f64; 3] = [1.25, 1.6, 2.0];
const FROM_ZERO: [f64; 3] = [0.25, 0.5, 1.0];
/// Size of a change, as a logarithm of the ratio, below which a bisection stops: less shifts the timing alone.
const MIN_CHANGE: f64 = 0.05;
/// Steps of a bisection.
const HALVINGS: u32 = 6;
/// Maximum number of settings whose cost is compared.
const MAX_COSTED: usize = 3;
/// Natural crossings that show what a setting costs.
const NATURAL: u32 = 40;
/// Bounds of a speed limit (m/s) and of the friction of a road that are tried.
const MIN_LIMIT: f64 = 2.0;
const MAX_FRICTION: f64 = 2.0;
/// Acceleration of free fall (m/s²).
const GRAVITY: f64 = 9.81;

/// A quantity of the driver, of its sensors or of the world that can be varied.
pub(super) struct Variable {
    name: String,
    unit: &'static str,
    value: f64,
    bounds: (f64, f64),
    /// The scenario with another value, which has the same starts.
    scenario: Box<dyn Fn(f64) -> Arc<Scenario>>,
}

impl Variable {
    /// Those of the driver and of its sensors.
    pub fn of_driver(settings: &[Setting], scenario: &Arc<Scenario>) -> Vec<Self> {
        let variable = |setting: &Setting| {
            let (make, scenario) = (setting.make.clone(), scenario.clone());
            let Setting { name, unit, value, bounds, .. } = setting;
            Self {
                name: name.clone(),
                unit,
                value: *value,
                bounds: *bounds,
                scenario: Box::new(move |value| driven_by(&scenario, make(value))),
            }
        };
        settings.iter().map(variable).collect()
    }

    /// Those of the world: the speed limit where the episode begins, which the driver may break, and the friction of a slippery road.
    pub fn of_world(experiments: &Experiments<'_>) -> Vec<Self> {
        let (scenario, limit) = (&experiments.incident.scenario, experiments.speed_limit());
        let (of_limit, story) = (scenario.clone(), experiments.story.clone());
        let limited = move |limit: f64| {
            let (make, story) = (of_limit.cast.ego().policy.clone(), story.clone());
            driven_by(&of_limit, Arc::new(move || story.alter(make(), Change::Limited(limit))))
        };
        let (name, bounds) = ("speed_limit".into(), (MIN_LIMIT.min(limit), limit));
        let limit = Self { name, unit: "m/s", value: limit, bounds, scenario: Box::new(limited) };
        let friction = scenario.episode.friction.map(|value| {
            let scenario = scenario.clone();
            let on = move |friction: f64| {
                let mut changed = Scenario::clone(&scenario);
                changed.episode.friction = Some(friction);
                changed.cast.vehicles[0].blueprint.grip = friction * GRAVITY;
                Arc::new(changed)
            };
            let bounds = (value, MAX_FRICTION.max(value));
            Self { name: "friction".into(), unit: "", value, bounds, scenario: Box::new(on) }
        });
        // In a test the driver holds its test speed, whatever the limit is.
        let is_test = scenario.spawn.test_speed(experiments.incident.start).is_some();
        (!is_test).then_some(limit).into_iter().chain(friction).collect()
    }

    /// The least change that turns a failure, as all larger ones that are tried do: its size, as a logarithm of the ratio, and the value.
    fn least_change(&self, experiments: &mut Experiments<'_>) -> Option<(f64, f64)> {
        let before = self.value;
        let size = |value: f64| match before == 0.0 {
            true => 1.0 + value.abs(),
            false => libm::log(value / before).abs(),
        };
        let mut turns = |value: f64| experiments.is_turned_in((self.scenario)(value));
        let mut best: Option<(f64, f64)> = None;
        for up in [true, false] {
            let steps = if before == 0.0 { FROM_ZERO } else { RATIOS };
            let value = |step: f64| match (before == 0.0, up) {
                (true, true) => step,
                (true, false) => -step,
                (false, true) => before * step,
                (false, false) => before / step,
            };
            let values = steps.map(|step| value(step).clamp(self.bounds.0, self.bounds.1));
            let mut fails = before;
            for (place, mut helps) in values.into_iter().enumerate() {
                if helps == fails || best.is_some_and(|(least, _)| size(helps) > 4.0 * least) {
                    break;
                }
                if !turns(helps) {
                    fails = helps;
                    continue;
                }
                // A value that helps by chance of timing has larger changes beyond it that do not.
                let mut beyond = values[place..].windows(2).filter(|pair| pair[0] != pair[1]);
                if !beyond.all(|pair| turns(pair[1])) {
                    break;
                }
                for _ in 0..HALVINGS {
                    let middle = rounded((helps + fails) / 2.0, (helps - before).abs());
                    if middle == helps || middle == fails || size(middle) < MIN_CHANGE {
                        break;
                    }
                    if turns(middle) { helps = middle } else { fails = middle }
                }
                if best.is_none_or(|(least, _)| size(helps) < least) {
                    best = Some((size(helps), helps));
                }
                break;
            }
        }
        best
    }
}

impl Experiments<'_> {
    /// Among the smallest changes of variables that turn the failure, the one that adds fewest faults in natural crossings, and the smallest one of
    /// these. What was tried is noted.
    pub fn setting(&mut self, variables: &[Variable]) -> Option<TurnedBy> {
        let mut found: Vec<(f64, &Variable, f64)> = Vec::new();
        for variable in variables {
            let least = variable.least_change(self);
            self.note(format!("other values of `{}`", variable.name), least.is_some());
            found.extend(least.map(|(size, value)| (size, variable, value)));
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        found.truncate(MAX_COSTED);
        if found.is_empty() {
            return None;
        }
        for _ in 0..(1 + found.len() as u32) * NATURAL {
            self.count()?;
        }
        let seed = self.incident.seed.child("natural");
        let before = natural_traffic(&self.incident.scenario, NATURAL, &seed);
        let turned = |(_, variable, value): (f64, &Variable, f64)| TurnedBy {
            name: variable.name.clone(),
            unit: variable.unit,
            from: variable.value,
            to: value,
            natural: [before, natural_traffic(&(variable.scenario)(value), NATURAL, &seed)],
        };
        cheapest(found.into_iter().map(turned))
    }
}

/// The change that adds fewest faults in natural crossings; of equal ones the first.
fn cheapest(turned: impl Iterator<Item = TurnedBy>) -> Option<TurnedBy> {
    turned.min_by_key(|turned| turned.natural[1].faults.saturating_sub(turned.natural[0].faults))
}

/// A scenario with another driver.
fn driven_by(scenario: &Scenario, policy: PolicyMaker) -> Arc<Scenario> {
    let mut scenario = Scenario::clone(scenario);
    scenario.cast.vehicles[0].policy = policy;
    Arc::new(scenario)
}

/// A value to about three digits of a change.
pub(super) fn rounded(value: f64, change: f64) -> f64 {
    let digits = (2.0 - libm::floor(libm::log10(change.max(1e-9)))).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Traffic;

    #[test]
    fn a_larger_change_that_adds_no_faults_comes_before_a_smaller_one_that_does() {
        let turned = |name: &str, faults: [u32; 2]| TurnedBy {
            name: name.into(),
            unit: "m",
            from: 1.0,
            to: 2.0,
            natural: faults.map(|faults| Traffic { faults: faults.into(), ..Traffic::default() }),
        };
        let best = |all: &[TurnedBy]| cheapest(all.iter().cloned()).map(|turned| turned.name);
        let (costly, free, also_free) = (turned("a", [3, 5]), turned("b", [3, 3]), turned("c", [3, 0]));
        assert_eq!(best(&[costly.clone(), free.clone(), also_free.clone()]).unwrap(), "b");
        assert_eq!(best(&[costly.clone(), also_free, free]).unwrap(), "c", "of equal ones the smallest change");
        assert_eq!(best(&[costly]).unwrap(), "a", "a costly one is said, too");
        assert_eq!(best(&[]), None);
    }
}
