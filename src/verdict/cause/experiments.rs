use std::sync::Arc;

use super::altered::{BRAKING, Story};
use super::{Change, Incident, Rerun, Reruns, RunLimit};
use episode::{Criterion, Pair, PolicyMaker, Scenario, VehicleFrame};
use road::geometry::Point;
use world::av::Fault;
use world::sim::{Control, WalkCommand};

/// Time after the touch for which a run that avoids it goes on (s).
const AFTER: f64 = 5.0;

/// Parts of a maximum that are tried one after the other.
pub(super) const PARTS: [f64; 5] = [0.0625, 0.125, 0.25, 0.5, 1.0];
/// Maximum number of obstacles that are taken away, one at a time.
const MAX_OBSTACLES: usize = 8;

/// Runs of an incident with one thing changed.
pub(super) struct Experiments<'a> {
    pub incident: &'a Incident,
    /// What happened.
    pub base: Rerun,
    /// The scenario, which ends soon after the touch.
    scenario: Arc<Scenario>,
    pub story: Arc<Story>,
    reruns: Reruns,
    /// The same start, in an episode that only its length ends.
    probes: Reruns,
    limit: RunLimit<'a>,
    /// The number of episodes up to now.
    pub runs: u32,
    /// Whether a run was wanted beyond the limit, or had no answer of the driver.
    pub is_cut: bool,
    /// Why the driver failed as a program in a run: what it does then is no evidence.
    pub fault: Option<Fault>,
    /// What was tried, each with whether it turns the failure or shows a weakness.
    pub tried: Vec<(String, bool)>,
    /// Changes that were run, each with whether it turns the failure.
    known: Vec<(Change, bool)>,
}

impl<'a> Experiments<'a> {
    /// `None` if the incident is not a failure when it is repeated, or if its driver cannot be copied and the caller is not patient.
    pub fn new(incident: &'a Incident, patient: bool, limit: RunLimit<'a>) -> Option<Self> {
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
        let mut endless = Scenario::clone(&scenario);
        endless.episode.end_when = None;
        endless.episode.ticks = base.outcome.ticks + (AFTER / endless.episode.tick) as u32;
        let probes = Reruns::with(incident, Arc::new(endless));
        let (tried, known) = (Vec::new(), Vec::new());
        let (runs, is_cut, fault) = (1, false, None);
        Some(Self { incident, base, scenario, story, reruns, probes, limit, runs, is_cut, fault, tried, known })
    }

    /// A run in which the driver answered; after another one there are no more.
    fn answered(&mut self, rerun: Option<Rerun>) -> Option<Rerun> {
        let rerun = rerun?;
        self.fault = rerun.outcome.fault();
        self.is_cut |= self.fault.is_some();
        self.fault.is_none().then_some(rerun)
    }

    /// Counts a run; `None` beyond the limit.
    pub fn count(&mut self) -> Option<()> {
        self.is_cut |= self.runs >= self.limit.max_runs;
        (!self.is_cut).then(|| {
            self.runs += 1;
            (self.limit.ran)();
        })
    }

    /// Notes what was tried, unless the limit has cut it.
    pub fn note(&mut self, what: impl Into<String>, turns: bool) -> bool {
        if !self.is_cut {
            self.tried.push((what.into(), turns));
        }
        turns
    }

    /// Whether a run takes no run-up.
    pub fn is_copied(&self) -> bool {
        self.reruns.is_copied()
    }

    /// The speed limit at the start (m/s).
    pub fn speed_limit(&self) -> f64 {
        self.reruns.speed_limit
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
        self.count()?;
        let story = self.story.clone();
        let wrap = Arc::new(move |driver| story.alter(driver, change)) as _;
        let rerun = self.reruns.run_with(&self.incident.commands, &wrap);
        self.answered(rerun)
    }

    /// Whether the driver presses its brake no harder in a time before the end (s) than at the beginning of that time.
    pub fn keeps_brake(&self, time: f64) -> bool {
        let frames = self.base.trace.vehicle(0);
        let last = &frames[frames.len().saturating_sub((time / self.dt()) as usize)..];
        let brake = |frame: &VehicleFrame| frame.driven.control.brake;
        last.first().is_none_or(|first| last.iter().all(|frame| brake(frame) <= brake(first) + BRAKING))
    }

    /// Whether a run avoids the failure.
    fn avoids(&self, rerun: &Rerun) -> bool {
        rerun.outcome.counts() && !self.reruns.fails(rerun)
    }

    /// Whether a change turns the failure.
    pub fn turns(&mut self, change: Change) -> bool {
        if let Some((_, turns)) = self.known.iter().find(|(known, _)| *known == change) {
            return *turns;
        }
        let turns = self.run(change).is_some_and(|rerun| self.avoids(&rerun));
        self.known.push((change, turns));
        turns
    }

    /// Whether another driver avoids it.
    pub fn is_turned_by(&mut self, driver: &PolicyMaker) -> bool {
        let mut scenario = Scenario::clone(&self.scenario);
        scenario.cast.vehicles[0].policy = driver.clone();
        self.is_turned_in(Arc::new(scenario))
    }

    /// Whether it does not happen in another scenario, from the same start of the pedestrian.
    pub fn is_turned_in(&mut self, scenario: Arc<Scenario>) -> bool {
        if self.count().is_none() {
            return false;
        }
        let mut reruns = Reruns::with(self.incident, scenario);
        let start = |rerun: &Rerun| rerun.trace.pedestrian(0).first().map(|first| first.pose);
        let rerun = self.answered(reruns.run(&self.incident.commands));
        rerun.filter(|rerun| start(rerun) == start(&self.base)).is_some_and(|rerun| self.avoids(&rerun))
    }

    /// What turns the failure if it is not there: the traffic lights, if they matter, or one of the obstacles that hide the pedestrian. What was tried is noted.
    pub fn without(&mut self, lights: bool) -> Option<String> {
        let scenario = self.scenario.clone();
        let mut turned = None;
        if lights && scenario.episode.traffic_lights && !scenario.town.traffic_lights.is_empty() {
            let mut dark = Scenario::clone(&scenario);
            dark.episode.traffic_lights = false;
            let turns = self.is_turned_in(Arc::new(dark));
            turned = self.note("no traffic lights", turns).then(|| "traffic lights".to_owned());
        }
        let pair = self.pair();
        let hidden = pair.frames().map(|frame| (pair.eye(&frame), frame.pedestrian.pose.position()));
        let hiding = scenario.obstacles.hiding(hidden);
        for place in hiding.into_iter().take(MAX_OBSTACLES) {
            let (obstacles, middle) = scenario.obstacles.without(place);
            let without = Scenario { obstacles: Arc::new(obstacles), ..Scenario::clone(&scenario) };
            let turns = self.is_turned_in(Arc::new(without));
            let name = format!("the obstacle at ({:.1} m, {:.1} m)", middle.x, middle.y);
            self.note(format!("without {name}"), turns);
            turned = turned.or(turns.then_some(name));
        }
        turned
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
        for part in PARTS {
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

    /// The episode in which all pedestrians stand still, and somebody appears: [`Change::Appears`].
    pub fn appears(&mut self, from: u32, somebody: Option<Point>, speed: f64) -> Option<Rerun> {
        let role = self.scenario.cast.pedestrian();
        let heading = self.pair().walking.first().map_or(0.0, |first| first.pose.yaw);
        let still = vec![WalkCommand { heading, speed: role.action.speed.0 }; self.scenario.cast.pedestrians.len()];
        self.count()?;
        let (story, change) = (self.story.clone(), Change::Appears { from, somebody, speed });
        let rerun = self.probes.run_with(&still, &(Arc::new(move |driver| story.alter(driver, change)) as _));
        self.answered(rerun)
    }

    /// The ticks in which the driver brakes harder than in a run without the pedestrian: the first, the last, and whether it has let go before the end while
    /// the car moved. `None` if it does not brake after a tick.
    pub fn braking(&self, after: u32, unseen: &Rerun) -> Option<(u32, u32, bool)> {
        let brake = |frame: Option<&VehicleFrame>| frame.map_or(0.0, |frame| frame.driven.control.brake);
        let (frames, without) = (self.base.trace.vehicle(0), unseen.trace.vehicle(0));
        let harder = |tick: usize| brake(frames.get(tick)) > BRAKING + brake(without.get(tick));
        let brakes: Vec<bool> = (1..frames.len()).map(harder).collect();
        let first = brakes.iter().enumerate().position(|(tick, brakes)| *brakes && tick as u32 >= after)?;
        let last = brakes.iter().rposition(|brakes| *brakes)?;
        let released = brakes[first..].iter().any(|brakes| !brakes);
        Some((first as u32, last as u32, released))
    }
}
