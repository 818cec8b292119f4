use std::sync::Arc;

use super::altered::{BRAKING, Story};
use super::{Change, Incident, Rerun, Reruns};
use crate::env::{Criterion, Pair, PolicyMaker, Scenario, VehicleFrame};
use crate::sim::{Control, WalkCommand};

/// A brake above this is pressed for somebody.
const PRESSED: f64 = 0.1;
/// A car that is slower (m/s) may let go of the brake.
const MOVING: f64 = 1.0;
/// Time after the touch for which a run that avoids it goes on (s).
const AFTER: f64 = 5.0;

/// Runs of an incident with one thing changed.
pub(super) struct Experiments<'a> {
    pub incident: &'a Incident,
    /// What happened.
    pub base: Rerun,
    /// The scenario, which ends soon after the touch.
    scenario: Arc<Scenario>,
    story: Arc<Story>,
    reruns: Reruns,
    /// Runs with other drivers.
    others: u32,
}

/// The reaction of a driver to somebody who suddenly stands there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    /// Until the commands of the driver change (s).
    pub time: f64,
    /// Distance from the bumper when it brakes (m); `None` if it does not brake before it is there.
    pub gap: Option<f64>,
    /// The hardest braking from then on, 0 to 1.
    pub hardest: f64,
    /// Whether it lets go of the brake while the car moves and is not there yet.
    pub releases: bool,
}

impl<'a> Experiments<'a> {
    /// `None` if the incident is not a failure when it is repeated, or if its driver cannot be copied and the caller is not patient.
    pub fn new(incident: &'a Incident, patient: bool) -> Option<Self> {
        let mut whole = Reruns::new(incident);
        if !patient && !whole.is_copied() {
            return None;
        }
        let base = whole.run(&incident.commands)?;
        if !whole.fails(&base) {
            return None;
        }
        let mut scenario = incident.scenario.clone();
        // The degree of a requirement depends on the length of the episode.
        if incident.criterion == Criterion::Collision {
            let rule = &mut Arc::make_mut(&mut scenario).episode;
            rule.ticks = rule.ticks.min(base.outcome.ticks + (AFTER / rule.tick) as u32);
        }
        let story = Arc::new(Story::new(&base.trace, &scenario));
        let reruns = Reruns::with(incident, scenario.clone());
        Some(Self { incident, base, scenario, story, reruns, others: 1 })
    }

    /// The number of episodes up to now.
    pub fn runs(&self) -> u32 {
        self.reruns.runs + self.others
    }

    /// Length of a tick (s).
    pub fn dt(&self) -> f64 {
        self.scenario.episode.tick
    }

    /// Time from a tick to the end of the failure (s).
    pub fn before(&self, tick: u32) -> f64 {
        self.base.outcome.duration - f64::from(tick) * self.dt()
    }

    /// The car and the pedestrian of the failure.
    pub fn pair(&self) -> Pair<'_> {
        self.base.trace.main_pair(&self.scenario)
    }

    /// The episode with one thing changed.
    pub fn run(&mut self, change: Change) -> Option<Rerun> {
        self.walked(change, &self.incident.commands.clone())
    }

    fn walked(&mut self, change: Change, commands: &[WalkCommand]) -> Option<Rerun> {
        let story = self.story.clone();
        self.reruns.run_with(commands, &(Arc::new(move |driver| story.alter(driver, change)) as _))
    }

    /// Whether a run avoids the failure.
    fn avoids(&self, rerun: &Rerun) -> bool {
        rerun.outcome.counts() && !self.reruns.fails(rerun)
    }

    /// Whether a change turns the failure.
    pub fn turns(&mut self, change: Change) -> bool {
        self.run(change).is_some_and(|rerun| self.avoids(&rerun))
    }

    /// Whether another driver avoids it.
    pub fn is_turned_by(&mut self, driver: &PolicyMaker) -> bool {
        let mut scenario = Scenario::clone(&self.scenario);
        scenario.cast.vehicles[0].policy = driver.clone();
        self.is_turned_in(Arc::new(scenario))
    }

    /// Whether it does not happen in another scenario with the same start.
    pub fn is_turned_in(&mut self, scenario: Arc<Scenario>) -> bool {
        let mut reruns = Reruns::with(self.incident, scenario);
        self.others += 1;
        reruns.run(&self.incident.commands).is_some_and(|rerun| self.avoids(&rerun))
    }

    /// The last tick from which on a change turns it, if it does from the start on and not at the end.
    pub fn last(&mut self, change: impl Fn(u32) -> Change) -> Option<u32> {
        if !self.turns(change(0)) {
            return None;
        }
        let (mut helps, mut fails) = (0, self.base.outcome.ticks);
        while fails - helps > 1 {
            let middle = helps + (fails - helps) / 2;
            if self.turns(change(middle)) { helps = middle } else { fails = middle }
        }
        Some(helps)
    }

    /// The least amount of a change that turns it, up to a maximum, to a hundredth of it.
    pub fn least(&mut self, maximum: f64, change: impl Fn(f64) -> Change) -> Option<f64> {
        let mut fails = 0.0;
        for part in [0.0625, 0.125, 0.25, 0.5, 1.0] {
            let mut helps = part * maximum;
            if !self.turns(change(helps)) {
                fails = helps;
                continue;
            }
            while helps - fails > maximum / 100.0 {
                let middle = (helps + fails) / 2.0;
                if self.turns(change(middle)) { helps = middle } else { fails = middle }
            }
            return Some(helps);
        }
        None
    }

    /// The first tick in which the driver's commands differ from those of another run; `None` if they are the same, bit for bit, as long as both last.
    pub fn differs(one: &Rerun, other: &Rerun) -> Option<u32> {
        let controls =
            |rerun: &'_ Rerun| rerun.trace.vehicle(0).iter().skip(1).map(|frame| frame.driven.control).collect();
        let (one, other): (Vec<Control>, Vec<Control>) = (controls(one), controls(other));
        one.iter().zip(&other).position(|(one, other)| one != other).map(|tick| tick as u32)
    }

    /// What the driver does if somebody stands there from a tick on, ahead of the bumper and to the left of the axis by these distances (m), while the
    /// car seems to have this share of its speed and nobody else is there. `None` if it does nothing.
    pub fn respond(&mut self, from: u32, (ahead, left): (f64, f64), speed: f64) -> Option<Response> {
        let nobody = self.appears(u32::MAX, (ahead, left), speed)?;
        let somebody = self.appears(from, (ahead, left), speed)?;
        let tick = Self::differs(&nobody, &somebody).filter(|tick| *tick >= from)?;
        let frames = somebody.trace.vehicle(0);
        let begun = frames.get(from as usize)?.state.pose.position();
        let gap = |frame: &VehicleFrame| ahead - (frame.state.pose.position() - begun).norm();
        let mut after = frames.iter().skip(tick as usize + 1);
        let brakes =
            after.clone().take_while(|frame| gap(frame) > 0.0).find(|frame| frame.driven.control.brake > PRESSED);
        let ahead_of_it = after.clone().take_while(|frame| gap(frame) > 0.0 && frame.state.speed > MOVING);
        let brakes_at = |frame: &VehicleFrame| frame.driven.control.brake > BRAKING;
        let releases = ahead_of_it.skip_while(|frame| !brakes_at(frame)).any(|frame| !brakes_at(frame));
        let hardest = after.by_ref().map(|frame| frame.driven.control.brake).fold(0.0, f64::max);
        Some(Response { time: f64::from(tick - from) * self.dt(), gap: brakes.map(gap), hardest, releases })
    }

    /// The episode in which all pedestrians stand still, and somebody appears.
    fn appears(&mut self, from: u32, (ahead, left): (f64, f64), speed: f64) -> Option<Rerun> {
        let role = self.scenario.cast.pedestrian();
        let heading = self.pair().walking.first().map_or(0.0, |first| first.pose.yaw);
        let still = vec![WalkCommand { heading, speed: role.action.speed.0 }; self.scenario.cast.pedestrians.len()];
        self.walked(Change::Appears { from, ahead, left, speed }, &still)
    }

    /// The first tick in which the car has nearly its greatest speed, and that speed (m/s).
    pub fn fast(&self) -> (u32, f64) {
        let speeds: Vec<f64> = self.base.trace.vehicle(0).iter().map(|frame| frame.state.speed).collect();
        let greatest = speeds.iter().copied().fold(0.0, f64::max);
        let tick = speeds.iter().position(|speed| *speed >= 0.8 * greatest).unwrap_or(0);
        (tick as u32, speeds.get(tick).copied().unwrap_or(0.0))
    }

    /// The ticks in which the driver brakes: the first, the last, and whether it has let go before the end while the car moved. `None` if it does not
    /// brake after a tick.
    pub fn braking(&self, after: u32) -> Option<(u32, u32, bool)> {
        let frames = self.base.trace.vehicle(0);
        let brakes: Vec<bool> = frames.iter().skip(1).map(|frame| frame.driven.control.brake > BRAKING).collect();
        let first = brakes.iter().enumerate().position(|(tick, brakes)| *brakes && tick as u32 >= after)?;
        let last = brakes.iter().rposition(|brakes| *brakes)?;
        let released = brakes[first..].iter().any(|brakes| !brakes);
        Some((first as u32, last as u32, released))
    }
}
