use crate::requirement::{Degree, Monitor, NamedRequirement};
use crate::scenario::actor_signal;
use crate::scenario::signal::is_silent;
use crate::{Scenario, Scene, Situation};
use base::signature::VariableId;
use road::geometry::Vector;
use std::sync::Arc;
use world::av::DrivingMode;

/// Evaluates requirements over the samples of an episode: one at its start, and one after each tick.
#[derive(Debug, Clone)]
pub(super) struct RequirementWatch {
    /// The requirements of the scenario; `None` without any.
    all: Option<Monitor>,
    /// The requirements that the reward names; `None` without any.
    paid: Option<Monitor>,
    /// Their robustness over the samples up to the last decision, as plain numbers from -100 to 100.
    pub(super) robustness: Vec<f64>,
    goal: Option<usize>,
    /// The moment of each sample; empty without a goal.
    moments: Vec<Moment>,
}

/// The maximum size of a robustness in a reward; an infinite one has it.
const MAX_ROBUSTNESS: f64 = 100.0;

/// The ego and the nearest pedestrian at a sample.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// The pedestrian's centre, ahead and to the left of that of the ego (m).
    pub place: Vector,
    /// The heading of the ego (rad).
    pub yaw: f64,
    /// The speed of the ego (m/s).
    pub speed: f64,
    /// The velocity of the pedestrian (m/s).
    pub velocity: Vector,
    /// The driver's action.
    pub mode: DrivingMode,
    /// The number of the pedestrian.
    pub pedestrian: usize,
}

impl RequirementWatch {
    /// A watch of a scenario's requirements, with memory for this number of samples.
    pub(super) fn new(scenario: &Scenario, samples: usize) -> Self {
        let monitor = |all: &Arc<[NamedRequirement]>| {
            let is_silent = |id| is_silent(id, scenario);
            (!all.is_empty()).then(|| Monitor::new(all.clone(), scenario.episode.tick, samples, &is_silent))
        };
        Self {
            all: monitor(&scenario.requirements),
            paid: monitor(&scenario.reward.requirements),
            robustness: Vec::with_capacity(scenario.reward.requirements.len()),
            goal: scenario.criterion.requirement(),
            moments: Vec::with_capacity(if scenario.criterion.requirement().is_some() { samples } else { 0 }),
        }
    }

    /// Whether there are no requirements.
    pub(super) fn is_idle(&self) -> bool {
        self.all.is_none() && self.paid.is_none()
    }

    /// Forgets the last episode.
    pub(super) fn clear(&mut self) {
        self.monitors().for_each(Monitor::clear);
        self.moments.clear();
    }

    /// Takes a sample, which is about this pedestrian.
    pub(super) fn push(&mut self, scene: &Scene<'_>, pedestrian: usize, situation: &Situation) {
        let values = situation.values();
        let value = |id: VariableId| match id.of_actor() {
            Some(signal) => actor_signal::value(scene.world, signal, scene.contact()),
            None => values[id.0],
        };
        self.monitors().for_each(|monitor| monitor.push(&value));
        if self.goal.is_some() {
            let (ego, walker) = (scene.world.ego(), &scene.world.pedestrians[pedestrian].state);
            self.moments.push(Moment {
                place: ego.state.pose.to_local(walker.pose.position()),
                yaw: ego.state.pose.yaw,
                speed: ego.state.speed,
                velocity: walker.velocity,
                // Nothing was done before the start.
                mode: if scene.world.ticks == 0 { DrivingMode::default() } else { scene.actions.modes[0] },
                pedestrian,
            });
        }
    }

    /// Evaluates the requirements of the reward over the samples up to now.
    pub(super) fn settle(&mut self) {
        if let Some(monitor) = &mut self.paid {
            monitor.conclude();
            self.robustness.clear();
            let held = |degree: &Degree| degree.robustness.clamp(-MAX_ROBUSTNESS, MAX_ROBUSTNESS);
            self.robustness.extend(monitor.degrees().iter().map(held));
        }
    }

    /// Whether the samples up to the last decision violate the requirement in this place among those of the reward.
    pub(super) fn violates_paid(&self, place: usize) -> bool {
        self.paid.as_ref().and_then(|monitor| monitor.degrees().get(place)).is_some_and(Degree::is_violated)
    }

    /// Ends the samples of an episode.
    pub(super) fn conclude(&mut self) {
        self.all.iter_mut().for_each(Monitor::conclude);
    }

    /// The degree of each requirement of the scenario in the episode that has ended; empty while it runs.
    pub(super) fn degrees(&self) -> &[Degree] {
        self.all.as_ref().map_or(&[], Monitor::degrees)
    }

    /// What an episode that ends now earns by its goal; `None` without a goal. It ends the samples.
    pub(super) fn goal_reward(&mut self) -> Option<f64> {
        let goal = self.goal?;
        self.conclude();
        let robustness = self.degrees().get(goal)?.robustness;
        Some(match robustness.is_infinite() {
            true => 1.0 - robustness.signum(),
            false => 1.0 - robustness / (1.0 + robustness.abs()),
        })
    }

    /// The moment that decides the goal of the episode that has ended; `None` without a goal, and if nothing violates it.
    pub(super) fn goal_moment(&self) -> Option<&Moment> {
        let degree = self.degrees().get(self.goal?).filter(|degree| degree.is_violated())?;
        self.moments.get(degree.sample as usize)
    }

    fn monitors(&mut self) -> impl Iterator<Item = &mut Monitor> {
        self.all.iter_mut().chain(&mut self.paid)
    }
}
