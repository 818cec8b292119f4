use super::{MOST_ROOM, PedestrianEnv, SignalMeter, Wanted, is_measured};
use crate::av::DrivingMode;
use crate::env::{Scenario, Situation};
use crate::geometry::Vector;
use crate::requirement::{Degree, Monitor};
use crate::sim::Contact;

/// The signals that the formulas of a scenario name and that are measured in every tick; none if there are none, and no requirements.
pub(super) fn wanted(scenario: &Scenario) -> Option<Wanted> {
    let end = scenario.episode.end_when.iter();
    let formulas = || scenario.reward.formulas().chain(end.clone());
    let wanted = Wanted::new(|id| {
        is_measured(id) && formulas().any(|formula| formula.mentions(&|other| other == id))
            || scenario
                .requirements
                .iter()
                .chain(&*scenario.reward.requirements)
                .any(|each| each.requirement.mentions(&|other| other == id))
    });
    (wanted != Wanted::default()).then_some(wanted)
}

/// Watches the requirements of a scenario; none without any.
pub(super) fn monitor(scenario: &Scenario) -> Option<Monitor> {
    let (all, rule) = (&scenario.requirements, &scenario.episode);
    (!all.is_empty()).then(|| Monitor::new(all.clone(), rule.tick, rule.ticks.min(MOST_ROOM) as usize + 1))
}

/// Watches the requirements that the reward names; none without any.
pub(super) fn paid(scenario: &Scenario) -> Option<Monitor> {
    let (all, rule) = (&scenario.reward.requirements, &scenario.episode);
    (!all.is_empty()).then(|| Monitor::new(all.clone(), rule.tick, rule.ticks.min(MOST_ROOM) as usize + 1))
}

/// The greatest size of a robustness in a reward; an infinite one has it.
const MOST_ROBUST: f64 = 100.0;

/// The ego and the nearest pedestrian at a sample.
#[derive(Debug, Clone, Copy)]
pub(in crate::env) struct Moment {
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
}

/// The samples of an episode: one at its start, and one after each tick.
impl PedestrianEnv {
    /// The degree of each requirement of the scenario in the episode that has ended; empty without requirements, while it runs, and after a driver
    /// or a controller failed.
    pub fn degrees(&self) -> &[Degree] {
        self.monitor.as_ref().map_or(&[], Monitor::degrees)
    }

    /// Takes the sample at the start of an episode.
    pub(super) fn begin_samples(&mut self) {
        if let Some(signals) = &mut self.signals {
            signals.begin(&self.world);
        }
        self.monitor.iter_mut().chain(&mut self.paid).for_each(Monitor::clear);
        self.moments.clear();
        self.watch_requirements(None);
        self.measure_robustness();
    }

    /// Evaluates the requirements of the reward over the samples up to now.
    pub(super) fn measure_robustness(&mut self) {
        if let Some(monitor) = &mut self.paid {
            monitor.conclude();
            self.robustness.clear();
            let held = |degree: &Degree| degree.robustness.clamp(-MOST_ROBUST, MOST_ROBUST);
            self.robustness.extend(monitor.degrees().iter().map(held));
        }
    }

    /// Whether the samples up to the last decision violate the requirement in this place among those of the reward.
    pub(super) fn violates_paid(&self, place: usize) -> bool {
        self.paid.as_ref().and_then(|monitor| monitor.degrees().get(place)).is_some_and(Degree::is_violated)
    }

    /// Takes the sample after a tick.
    #[inline]
    pub(super) fn take_sample(&mut self, contact: Option<&Contact>) {
        if let Some(signals) = &mut self.signals {
            signals.tick(&self.world, contact);
            self.watch_requirements(contact);
        }
    }

    fn watch_requirements(&mut self, contact: Option<&Contact>) {
        if self.monitor.is_none() && self.paid.is_none() {
            return;
        }
        let values = self.sample(contact).values();
        self.monitor.iter_mut().chain(&mut self.paid).for_each(|monitor| monitor.push(&|id| values[id.0]));
        if self.scenario.criterion.requirement().is_some() {
            let (ego, number) = (self.world.ego(), SignalMeter::pedestrian(&self.world, contact));
            let walker = &self.world.pedestrians[number].state;
            self.moments.push(Moment {
                place: ego.state.pose.to_local(walker.pose.position()),
                yaw: ego.state.pose.yaw,
                speed: ego.state.speed,
                velocity: walker.velocity,
                // Nothing was done before the start.
                mode: if self.world.ticks == 0 { DrivingMode::default() } else { self.policies[0].mode() },
            });
        }
    }

    /// Ends the samples of an episode.
    pub(super) fn conclude_requirements(&mut self) {
        if let Some(monitor) = &mut self.monitor {
            monitor.conclude();
        }
    }

    /// Whether the episode that has ended is a failure by the criterion of the scenario.
    pub fn is_failure(&self) -> bool {
        self.outcome().is_some_and(|outcome| self.scenario.criterion.is_met(outcome, self.degrees()))
    }

    /// What an episode that ends now earns by its goal; none without a goal. It ends the samples.
    pub(super) fn goal_reward(&mut self) -> Option<f64> {
        let goal = self.scenario.criterion.requirement()?;
        self.conclude_requirements();
        let robustness = self.degrees().get(goal)?.robustness;
        Some(match robustness.is_infinite() {
            true => 1.0 - robustness.signum(),
            false => 1.0 - robustness / (1.0 + robustness.abs()),
        })
    }

    /// The moment that decides the goal of the episode that has ended; none without a goal, and if nothing violates it.
    pub(in crate::env) fn goal_moment(&self) -> Option<&Moment> {
        let degree =
            self.degrees().get(self.scenario.criterion.requirement()?).filter(|degree| degree.is_violated())?;
        self.moments.get(degree.sample as usize)
    }

    /// The variables that requirements name.
    fn sample(&self, contact: Option<&Contact>) -> Situation {
        let Some(signals) = &self.signals else { return Situation::default() };
        let number = SignalMeter::pedestrian(&self.world, contact);
        let wanted = signals.wanted();
        let is_placed = wanted.bearing || wanted.distance || wanted.ahead || wanted.aside || wanted.facing;
        if is_placed || wanted.turn || wanted.pace || wanted.miss_distance {
            return self.situation_of(number, contact);
        }
        let hit = contact.filter(|contact| contact.pedestrian_at_ego().is_some());
        Situation {
            ego_speed: hit.map_or(self.world.ego().state.speed, |hit| hit.impact_speed),
            walking_speed: self.world.pedestrians[number].state.speed(),
            elapsed: self.elapsed(contact),
            ..*signals.now()
        }
    }
}
