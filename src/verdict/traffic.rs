use std::ops::ControlFlow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{Blame, Judged};
use base::seed::Seed;
use episode::walker::{Natural, WalkPolicy};
use episode::{Criterion, Outcome, Scenario, Trace, evaluate_observed};

/// Time over which a deceleration is averaged (s): ignores single-tick peaks.
const BRAKING_TIME: f64 = 0.5;

/// Deceleration over half a second above which braking is hard (m/s²).
const HARD_BRAKING: f64 = 4.0;

/// Encounters with natural pedestrians.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Traffic {
    /// Those that count.
    pub episodes: u64,
    /// Those with a fault.
    pub faults: u64,
    /// Those in which the car braked hard.
    pub hard_braking: u64,
    /// Way of the car in all of them (m).
    pub distance: f64,
    /// Their duration (s).
    pub time: f64,
    /// Episodes in which a program failed.
    pub errors: u64,
}

impl Traffic {
    /// Mean speed (m/s); `None` without an episode.
    pub fn speed(&self) -> Option<f64> {
        (self.time > 0.0).then(|| self.distance / self.time)
    }

    /// Share of episodes with hard braking; `None` without an episode.
    pub fn braking_rate(&self) -> Option<f64> {
        (self.episodes > 0).then(|| self.hard_braking as f64 / self.episodes as f64)
    }

    /// Counts an episode.
    pub fn add(&mut self, episode: &Drive) {
        self.errors += u64::from(episode.error);
        if !episode.counts {
            return;
        }
        self.episodes += 1;
        self.faults += u64::from(episode.fault);
        self.hard_braking += u64::from(episode.hard_braking);
        self.distance += episode.distance;
        self.time += episode.time;
    }
}

/// An episode, as far as traffic is about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    pub counts: bool,
    pub error: bool,
    pub fault: bool,
    pub hard_braking: bool,
    pub distance: f64,
    pub time: f64,
    /// With those of its run-up.
    pub ticks: u64,
}

impl Drive {
    pub fn new(scenario: &Scenario, outcome: &Outcome, trace: &Trace) -> Self {
        let judged = Judged::by(Criterion::Collision, outcome, &trace.main_pair(scenario));
        let frames = trace.vehicle(0);
        let dt = scenario.episode.tick;
        let window = ((BRAKING_TIME / dt).round() as usize).max(1);
        let speeds = frames.iter().zip(frames.iter().skip(window));
        let hardest =
            speeds.map(|(one, later)| (one.state.speed - later.state.speed) / (window as f64 * dt)).fold(0.0, f64::max);
        let steps = frames.iter().zip(frames.iter().skip(1));
        Self {
            counts: outcome.counts(),
            error: outcome.fault().is_some(),
            fault: outcome.counts() && judged.is(Criterion::Collision, Blame::Fault),
            hard_braking: hardest > HARD_BRAKING,
            distance: steps.map(|(one, next)| (next.state.pose.position() - one.state.pose.position()).norm()).sum(),
            time: outcome.duration,
            ticks: u64::from(outcome.ticks) + u64::from(outcome.run_up),
        }
    }
}

/// Evaluates a walk policy in this number of fresh episodes; fewer when `stop` is true before the end.
pub fn drives(
    scenario: &Arc<Scenario>,
    walker: &mut dyn WalkPolicy,
    episodes: u32,
    seed: &Seed,
    stop: &dyn Fn() -> bool,
) -> Vec<Drive> {
    let mut note = |_: u32, outcome: &Outcome, trace: &Trace| Drive::new(scenario, outcome, trace);
    let mut go_on = |_: u32| if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let (starts, drawn) = (seed.child("starts"), seed.child("walker"));
    evaluate_observed(walker, scenario, 0..episodes, &starts, &drawn, &mut note, &mut go_on)
}

/// Traffic of a scenario's driver with natural pedestrians, in this number of episodes.
pub fn natural_traffic(scenario: &Arc<Scenario>, episodes: u32, seed: &Seed) -> Traffic {
    let mut traffic = Traffic::default();
    drives(scenario, &mut Natural::default(), episodes, seed, &|| false).iter().for_each(|drive| traffic.add(drive));
    traffic
}
