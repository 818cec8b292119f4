use std::f64::consts::PI;
use std::sync::Arc;

use super::{FailureKind, Incident, Plan, Rerun, Reruns, Segment};
use episode::walker::log_likelihood;
use episode::{ActionSpec, Cast, PedestrianRole, Scenario};
use road::geometry::wrap_angle;
use world::sim::{ActorId, WalkCommand};

/// A step of a command towards the natural walk: of its heading (rad) and of its speed (m/s).
const STEP: (f64, f64) = (5.0 * PI / 180.0, 0.1);
/// The mean speed of natural pedestrians (m/s).
const WALKING: f64 = 1.314;
/// Maximum number of straight walks that are tried first.
const MAX_STRAIGHT: usize = 6;
/// Minimum gain of a logarithm of a likelihood.
const MIN_GAIN: f64 = 1e-9;

/// Why shrinking ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// No single removal of an actor or a command, no merge and no step towards the natural walk keeps the failure.
    Minimal,
    /// The budget of runs was used up.
    Budget,
}

/// A failure with fewer actors and commands, nearer to a natural walk.
#[derive(Debug, Clone)]
pub struct Shrunk {
    /// What repeats it.
    pub incident: Incident,
    /// Its episode.
    pub rerun: Rerun,
    pub kind: FailureKind,
    /// The roles of the actors that it does not need, in the order in which they were taken away.
    pub without: Vec<Arc<str>>,
    /// The number of commands before and now. A command that is kept counts once.
    pub counts: [usize; 2],
    /// The logarithm of the likelihood of the walks of those that are left among natural ones, before and now: [`log_likelihood`].
    pub log_likelihoods: [f64; 2],
    /// The number of episodes that it took.
    pub runs: u32,
    pub limit: Limit,
}

impl Shrunk {
    /// The likelihood of the walk now over that before.
    pub fn likelier(&self) -> f64 {
        libm::exp(self.log_likelihoods[1] - self.log_likelihoods[0])
    }

    /// The actors that it does not need: `, without `van`, `child``; empty if it needs all.
    pub fn without(&self) -> String {
        let names: Vec<String> = self.without.iter().map(|name| format!("`{name}`")).collect();
        if names.is_empty() { String::new() } else { format!(", without {}", names.join(", ")) }
    }

    /// The kind of the shrunk failure and its number of commands: failures in which they are equal are one finding.
    pub fn class(&self) -> (FailureKind, usize) {
        let criterion = self.kind.criterion;
        let judged = self.rerun.judged(criterion, &self.incident.scenario);
        (FailureKind::new(criterion, &judged).unwrap_or(self.kind), self.counts[1])
    }
}

/// Shrinks a failure: the same kind without the actors that it does not need, with the fewest commands of the others, then the likeliest walk. It takes at
/// most this number of runs, and the same ones every time. `None` if the incident is not a failure when it is repeated.
///
/// # Source
/// Zeller and Hildebrandt, *Simplifying and isolating failure-inducing input*, IEEE TSE 28 (2002); the result is 1-minimal.
pub fn shrink(incident: &Incident, max_runs: u32) -> Option<Shrunk> {
    let incident = &incident.lasting();
    let mut reruns = Reruns::new(incident);
    let first = reruns.run(&incident.commands)?;
    let kind = FailureKind::new(incident.criterion, &first.judged(incident.criterion, &incident.scenario))?;
    let best = Candidate::new(first.clone(), incident);
    let before = best.plan.clone();
    let mut search = Search { incident: incident.clone(), reruns, kind, best, without: Vec::new(), max_runs };
    let limit = search.run();
    let Search { incident, reruns, best, without, .. } = search;
    let log_before = likelihood(&first, &before, &incident);
    Some(Shrunk {
        incident: Incident { commands: best.rerun.commands.clone(), ..incident },
        kind,
        without,
        counts: [before.count(), best.plan.count()],
        log_likelihoods: [log_before, best.log],
        rerun: best.rerun,
        runs: reruns.runs,
        limit,
    })
}

/// An episode that may be the result.
struct Candidate {
    rerun: Rerun,
    plan: Plan,
    log: f64,
}

impl Candidate {
    fn new(rerun: Rerun, incident: &Incident) -> Self {
        let roles = &incident.scenario.cast.pedestrians;
        let mut plan = Plan::new(&rerun.commands, roles.len());
        plan.pedestrians.iter_mut().zip(roles).filter(|(_, role)| role.is_absent).for_each(|(walk, _)| walk.clear());
        let log = likelihood(&rerun, &plan, incident);
        Self { rerun, plan, log }
    }
}

/// The logarithm of the likelihood of the commands of a plan along an episode.
fn likelihood(rerun: &Rerun, plan: &Plan, incident: &Incident) -> f64 {
    let controlled = incident.scenario.cast.controlled().filter(|(_, role)| !role.is_absent);
    let of = |(number, _): (usize, &PedestrianRole)| {
        let each = plan.pedestrians[number].iter();
        let walk: Vec<_> = each.flat_map(|segment| std::iter::repeat_n(segment.command, segment.decisions)).collect();
        log_likelihood(&rerun.trace.pair(&incident.scenario, 0, number), &walk)
    };
    controlled.map(of).sum()
}

/// The budget is used up.
struct Spent;

struct Search {
    incident: Incident,
    reruns: Reruns,
    kind: FailureKind,
    best: Candidate,
    /// That of [`Shrunk`].
    without: Vec<Arc<str>>,
    max_runs: u32,
}

impl Search {
    fn run(&mut self) -> Limit {
        if self.try_all().is_ok() { Limit::Minimal } else { Limit::Budget }
    }

    fn try_all(&mut self) -> Result<(), Spent> {
        while self.remove_actor()? {}
        for plan in self.straight() {
            if self.attempt(&plan)? {
                break;
            }
        }
        loop {
            self.remove_many()?;
            self.approach()?;
            if !self.first_of(neighbours)? && !self.remove_actor()? {
                return Ok(());
            }
        }
    }

    /// Tries a plan; whether it is better and is now the best.
    fn attempt(&mut self, plan: &Plan) -> Result<bool, Spent> {
        let (count, best) = (plan.count(), self.best.plan.count());
        // A step that makes the walk less likely is no step towards the natural one.
        let gain = || likelihood(&self.best.rerun, plan, &self.incident) - self.best.log;
        if count > best || count == best && gain() < MIN_GAIN {
            return Ok(false);
        }
        if self.reruns.runs >= self.max_runs {
            return Err(Spent);
        }
        let Some(rerun) = self.reruns.run(&plan.commands()) else { return Ok(false) };
        if !self.reruns.fails(&rerun) {
            return Ok(false);
        }
        let found = Candidate::new(rerun, &self.incident);
        let count = found.plan.count();
        let is_better = count < best || count == best && found.log - self.best.log >= MIN_GAIN;
        let is_taken = is_better && self.is_kept(&found.rerun, &self.incident.scenario);
        if is_taken {
            self.best = found;
        }
        Ok(is_taken)
    }

    /// Whether an episode is a failure of the same kind.
    fn is_kept(&self, rerun: &Rerun, scenario: &Scenario) -> bool {
        let now = FailureKind::new(self.kind.criterion, &rerun.judged(self.kind.criterion, scenario));
        now.is_some_and(|now| self.kind.is_kept_by(&now))
    }

    /// Takes away the first actor without whom the car still fails, and hits the same pedestrian if it hits one; whether there was one. The others start
    /// where they did, and carry out the same commands.
    fn remove_actor(&mut self) -> Result<bool, Spent> {
        let Incident { scenario, commands, .. } = &self.incident;
        let there: Vec<ActorId> = scenario.cast.actors().filter(|actor| !scenario.cast.is_absent(*actor)).collect();
        let struck = |rerun: &Rerun| rerun.trace.contact().and_then(|contact| contact.pedestrian_at_ego());
        for actor in there.iter().filter(|actor| **actor != ActorId::EGO && there.len() > 2) {
            if self.reruns.runs >= self.max_runs {
                return Err(Spent);
            }
            let without = Arc::new(Scenario { cast: scenario.cast.without(*actor), ..Scenario::clone(scenario) });
            let mut reruns = Reruns::with(&self.incident, without.clone());
            let rerun = reruns.run(commands);
            self.reruns.runs += 1;
            let is_same = |rerun: &Rerun| struck(rerun) == struck(&self.best.rerun) && self.is_kept(rerun, &without);
            let Some(rerun) = rerun.filter(is_same) else { continue };
            self.without.push(scenario.cast.name(*actor).clone());
            reruns.runs = self.reruns.runs;
            self.incident = Incident { scenario: without, commands: rerun.commands.clone(), ..self.incident.clone() };
            self.best = Candidate::new(rerun, &self.incident);
            self.reruns = reruns;
            return Ok(true);
        }
        Ok(false)
    }

    /// Tries the plans that are made of the best one, until one is better; whether there was one.
    fn first_of(&mut self, plans: fn(&Plan, &Cast) -> Vec<Plan>) -> Result<bool, Spent> {
        for plan in plans(&self.best.plan, &self.incident.scenario.cast) {
            if self.attempt(&plan)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Walks straight to where the episode ended, after having stood for some decisions: those of the most natural speed first.
    fn straight(&self) -> Vec<Plan> {
        let Incident { scenario, .. } = &self.incident;
        let Candidate { rerun, plan, .. } = &self.best;
        let struck = rerun.trace.contact().and_then(|contact| contact.pedestrian_at_ego()).unwrap_or(0);
        let track = rerun.trace.pedestrian(struck);
        let (Some(first), Some(last)) = (track.first(), track.last()) else { return Vec::new() };
        let way = last.pose.position() - first.pose.position();
        let heading = libm::atan2(way.y, way.x);
        let (low, high) = scenario.cast.pedestrians[struck].action.speed;
        let rule = &scenario.episode;
        let decisions = rerun.trace.decisions(struck).len();
        let mut found = Vec::new();
        for waits in 0..decisions {
            // CARLA's walkers need two seconds up to a commanded speed.
            for lag in [0.0, 1.0] {
                let time = rerun.outcome.duration - waits as f64 * f64::from(rule.hold) * rule.tick - lag;
                let speed = way.norm() / time.max(rule.tick);
                if speed < low || speed > high {
                    continue;
                }
                let wait = Segment { command: WalkCommand { heading, speed: low }, decisions: waits };
                let walk = Segment { command: WalkCommand { heading, speed }, decisions: decisions - waits };
                let mut straight = plan.clone();
                straight.pedestrians[struck] = if waits == 0 { vec![walk] } else { vec![wait, walk] };
                found.push(((speed - WALKING).abs() + if waits == 0 { 0.0 } else { 1.0 }, straight));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, plan)| plan).take(MAX_STRAIGHT).collect()
    }

    /// Removes many segments at once, as long as that keeps the failure.
    fn remove_many(&mut self) -> Result<(), Spent> {
        for pedestrian in 0..self.best.plan.pedestrians.len() {
            let mut size = self.best.plan.pedestrians[pedestrian].len() / 2;
            while size > 1 {
                let mut first = 0;
                while first < self.best.plan.pedestrians[pedestrian].len() {
                    let parts = [false, true].map(|next| self.best.plan.without(pedestrian, first, size, next));
                    let mut removed = false;
                    for plan in parts.into_iter().flatten() {
                        removed = removed || self.attempt(&plan)?;
                    }
                    first += if removed { 0 } else { size };
                }
                size /= 2;
            }
        }
        Ok(())
    }

    /// Moves commands far towards the natural walk, as long as that keeps the failure.
    fn approach(&mut self) -> Result<(), Spent> {
        while self.first_of(jumps)? {}
        Ok(())
    }
}

/// The plans with a segment that has gone a part of the way to the segment before or after it, or to the natural speed; the largest jumps first.
fn jumps(plan: &Plan, cast: &Cast) -> Vec<Plan> {
    let mut all = Vec::new();
    for part in [1.0, 0.5, 0.25] {
        for (pedestrian, PedestrianRole { action, .. }) in cast.controlled() {
            let segments = &plan.pedestrians[pedestrian];
            for (place, Segment { command, .. }) in segments.iter().enumerate() {
                let beside = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
                let mut aims: Vec<_> =
                    beside.filter_map(|place| segments.get(place)).map(|near| near.command).collect();
                aims.push(WalkCommand { speed: WALKING, ..*command });
                for aim in aims {
                    let turn = part * wrap_angle(aim.heading - command.heading);
                    let faster = part * (aim.speed - command.speed);
                    for (turn, faster) in [(turn, 0.0), (0.0, faster)] {
                        all.extend(moved(plan, action, (pedestrian, place), (turn, faster)));
                    }
                }
            }
        }
    }
    all
}

/// The plans that differ from a plan in one removal, one merge or one step of a command of a pedestrian that is controlled.
fn neighbours(plan: &Plan, cast: &Cast) -> Vec<Plan> {
    let mut all = Vec::new();
    for (pedestrian, PedestrianRole { action, .. }) in cast.controlled() {
        let segments = &plan.pedestrians[pedestrian];
        for place in 0..segments.len() {
            all.extend(plan.without(pedestrian, place, 1, false));
            all.extend(plan.without(pedestrian, place, 1, true));
            all.extend(plan.merged(pedestrian, place));
        }
        for place in 0..segments.len() {
            for step in [(STEP.0, 0.0), (-STEP.0, 0.0), (0.0, STEP.1), (0.0, -STEP.1)] {
                all.extend(moved(plan, action, (pedestrian, place), step));
            }
        }
    }
    all
}

/// The plan with a command that is turned by an angle (rad) and faster (m/s), within the speeds of the pedestrian; `None` if that changes nothing.
fn moved(
    plan: &Plan,
    action: &ActionSpec,
    (pedestrian, place): (usize, usize),
    (turn, faster): (f64, f64),
) -> Option<Plan> {
    let before = plan.pedestrians[pedestrian][place].command;
    let speed =
        if faster == 0.0 { before.speed } else { (before.speed + faster).clamp(action.speed.0, action.speed.1) };
    let command = WalkCommand { heading: wrap_angle(before.heading + turn), speed };
    (command != before).then(|| plan.with(pedestrian, place, command))
}
