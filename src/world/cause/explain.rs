use std::sync::Arc;

use super::altered::BRAKING;
use super::experiments::{Experiments, Response};
use super::{Change, Incident};
use crate::av::{DrivingMode, Weakness};
use crate::env::{DriverParts, Scenario, Setting};
use crate::hardening::{Traffic, natural_traffic};

/// Distance at which somebody suddenly stands before the bumper and is far away (m).
const FAR: f64 = 40.0;
/// The same, so near that every driver must react at once (m).
const NEAR: f64 = 2.0;
/// The same beside the axis: within the car's width (m, m).
const BESIDE: (f64, f64) = (5.0, 0.9);
/// Ticks by which somebody appears later.
const SHIFTS: [u32; 5] = [0, 4, 8, 12, 16];
/// Response times above this (s) count as a delay: two ticks of most drivers are none.
const PROMPT: f64 = 0.15;
/// A driver that presses its brake no harder than this for somebody near brakes weakly.
const WEAK: f64 = 0.6;
/// Multiples of a delay by which pedestrians are seen earlier: the driver's plan is late, too.
const COMPENSATED: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// A response time above this (s) is a weakness by itself.
const LATE: f64 = 0.4;
/// Decelerations that must be enough for somebody far ahead (m/s²): beyond a fixed range, and at a distance that grows with the speed.
const ENOUGH: (f64, f64) = (3.0, 5.0);
/// The speed that the car seems to have, and the ratio of distances of reaction below which they do not grow with it.
const FASTER: f64 = 1.5;
const SAME: f64 = 1.1;
/// Distance that is left before somebody who is not hit (m).
const SPARE: f64 = 1.0;
/// Maximum amounts that are tried: how much earlier (s), farther to the middle, and nearer (m).
const MAX: (f64, f64, f64) = (3.0, 6.0, 30.0);
/// The time before a touch in which a car that drove off stood (s).
const DROVE_OFF: f64 = 6.0;
/// Ratios of a setting's value that are tried, and values in its unit if it is 0.
const RATIOS: [f64; 4] = [1.25, 1.6, 2.5, 5.0];
const FROM_ZERO: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
/// A driver that reacts earlier by this to a pedestrian from the other side (s) sees one side only.
const EARLIER: f64 = 0.5;
/// Steps of a bisection.
const HALVINGS: u32 = 6;
/// Natural crossings that show what a setting costs.
const NATURAL: u32 = 40;

/// Why a driver failed, by runs with one thing changed. Times are before the touch, or before the end of the episode that violates a requirement (s).
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    pub weakness: Weakness,
    /// Of [`Weakness`]: how much of it, such as the delay (s) or by how much the corridor is too narrow (m).
    pub amount: Option<f64>,
    /// When full braking, comfortable braking and swerving help for the last time; `None` if they never do.
    pub last: [Option<f64>; 3],
    /// For how long the pedestrian was in sight without a break.
    pub seen: f64,
    /// When the driver's commands depend on the pedestrian for the first time; `None` if they are those of an empty road, bit for bit.
    pub reacted: Option<f64>,
    /// When it braked for the first time after that; `None` if it did not.
    pub braked: Option<f64>,
    /// Whether it stood shortly before, and at a red light.
    pub drove_off: Option<bool>,
    /// The smallest change of a setting that turns it.
    pub setting: Option<TurnedBy>,
    /// What was tried, each with whether it turns the failure.
    pub tried: Vec<(String, bool)>,
    /// The number of episodes that it took, without the natural crossings.
    pub runs: u32,
}

/// A setting with another value, with which a failure does not happen.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedBy {
    pub name: String,
    pub unit: &'static str,
    pub from: f64,
    pub to: f64,
    /// Natural crossings with the value before, and with the other.
    pub natural: [Traffic; 2],
}

/// Finds out why an incident happened; `None` if it is not a failure when it is repeated. A driver that cannot be copied, such as a program, drives its
/// run-up in each of about a hundred runs; it is left out unless `patient`.
pub fn explain(incident: &Incident, patient: bool) -> Option<Cause> {
    let parts = &incident.scenario.cast.ego().parts;
    let experiments = Experiments::new(incident, patient)?;
    let mut inquiry = Inquiry { experiments, tried: Vec::new() };
    let facts = inquiry.facts()?;
    let (weakness, amount) = inquiry.weakness(parts, &facts);
    let setting = inquiry.setting(&parts.settings);
    let Inquiry { experiments, tried } = inquiry;
    let Facts { last, seen, reaction, braked, drove_off, .. } = facts;
    let before = |tick: u32| experiments.before(tick);
    Some(Cause {
        weakness,
        amount,
        last: last.map(|tick| tick.map(before)),
        seen,
        reacted: reaction.map(before),
        braked: braked.map(before),
        drove_off,
        setting,
        tried,
        runs: experiments.runs(),
    })
}

/// What happened, in ticks of the episode.
struct Facts {
    last: [Option<u32>; 3],
    /// (s)
    seen: f64,
    reaction: Option<u32>,
    braked: Option<u32>,
    released: bool,
    drove_off: Option<bool>,
    /// The responses to somebody who suddenly stands near, at different ticks.
    near: [Option<Response>; SHIFTS.len()],
    /// That to somebody far ahead.
    far: Option<Response>,
    /// The car's speed then (m/s).
    speed: f64,
    /// The tick then.
    fast: u32,
}

impl Facts {
    /// How long the driver takes to respond to somebody near (s): at least, and at most. `None` if it never responds.
    fn latency(&self) -> Option<(f64, f64)> {
        let times = || self.near.iter().flatten().map(|response| response.time);
        times().min_by(f64::total_cmp).zip(times().max_by(f64::total_cmp))
    }
}

struct Inquiry<'a> {
    experiments: Experiments<'a>,
    tried: Vec<(String, bool)>,
}

impl Inquiry<'_> {
    fn facts(&mut self) -> Option<Facts> {
        let it = &mut self.experiments;
        let unseen = it.run(Change::Unseen)?;
        let reaction = Experiments::differs(&it.base, &unseen);
        let full = it.last(Change::BrakesFrom);
        let comfortable = it.last(Change::SlowsFrom);
        let swerve = [true, false].map(|left| it.last(|from| Change::SwervesFrom(from, left)));
        let last = [full, comfortable, swerve.into_iter().flatten().max()];
        let (fast, speed) = it.fast();
        let near = SHIFTS.map(|shift| it.respond(fast + shift, (NEAR, 0.0), 1.0));
        let far = it.respond(fast, (FAR, 0.0), 1.0);
        let pair = it.pair();
        let hidden = pair.frames().rev().position(|frame| !pair.in_sight(&frame));
        let seen = hidden.unwrap_or(pair.len().saturating_sub(1)) as f64 * it.dt();
        let braking = reaction.and_then(|reaction| it.braking(reaction));
        let ticks = (DROVE_OFF / it.dt()) as usize;
        let mut late = pair.frames().rev().take(ticks);
        let stood = late.clone().any(|frame| frame.ego.speed < 0.05);
        let red = late.any(|frame| frame.mode == DrivingMode::RedLight);
        Some(Facts {
            last,
            seen,
            reaction,
            braked: braking.map(|(first, ..)| first),
            released: braking.is_some_and(|(.., released)| released),
            drove_off: stood.then_some(red),
            near,
            far,
            speed,
            fast,
        })
    }

    /// Tries a change and notes it.
    fn turns(&mut self, what: &str, change: Change) -> bool {
        let turns = self.experiments.turns(change);
        self.tried.push((what.to_owned(), turns));
        turns
    }

    /// The first weakness that explains the failure, with its amount.
    fn weakness(&mut self, parts: &DriverParts, facts: &Facts) -> (Weakness, Option<f64>) {
        self.tried.push(("nobody there".into(), false));
        let latency = facts.latency();
        if facts.reaction.is_none() && latency.is_none() && self.ignores() {
            return (Weakness::Ignores, None);
        }
        if let Some(found) = self.parts(parts, latency.map(|latency| latency.0)) {
            return found;
        }
        let full_braking = facts.last[0].map_or(0.0, |tick| self.experiments.before(tick));
        if facts.seen + self.experiments.dt() < full_braking
            && self.turns("sight through obstacles", Change::SeenThrough)
        {
            return (Weakness::Hidden, Some(facts.seen));
        }
        if let Some((least, most)) = latency {
            let flickers = most - least > 1.5 * self.experiments.dt();
            self.tried.push((format!("somebody {NEAR} m ahead, a little later"), flickers));
            if flickers {
                return (Weakness::Dropouts, None);
            }
        }
        if let Some((delay, _)) = latency.filter(|(delay, _)| *delay > PROMPT) {
            let dt = self.experiments.dt();
            let earlier = |time: f64| Change::Earlier((time / dt).round() as u32);
            let turns = COMPENSATED.into_iter().any(|part| self.experiments.turns(earlier(part * delay)));
            self.tried.push((format!("{delay:.2} s earlier"), turns));
            if turns {
                return (Weakness::Delay, Some(delay));
            }
        }
        let near = self.experiments.respond(facts.fast, (BESIDE.0, 0.0), 1.0);
        let releases = near.iter().chain(&facts.far).any(|response| response.releases);
        if facts.released && releases && self.turns("keeps the brake once it brakes", Change::KeepsBraking) {
            return (Weakness::LetsGo, None);
        }
        let responses = near.iter().chain(facts.near.iter().flatten()).chain(&facts.far);
        let hardest = responses.map(|response| response.hardest).fold(0.0, f64::max);
        if latency.is_some() && hardest < WEAK && self.turns("full braking once it brakes", Change::BrakesFully) {
            return (Weakness::WeakBrake, self.hardest());
        }
        if facts.released && self.turns("keeps the brake once it brakes", Change::KeepsBraking) {
            return (Weakness::LetsGo, None);
        }
        if let Some((delay, _)) = latency.filter(|(delay, _)| *delay > LATE) {
            return (Weakness::Delay, Some(delay));
        }
        let found = self.one_side(facts).or_else(|| self.distance(facts)).or_else(|| self.unforeseen(facts));
        if let Some(found) = found {
            return found;
        }
        if self.turns("full braking once it brakes", Change::BrakesFully) {
            return (Weakness::WeakBrake, self.hardest());
        }
        (Weakness::NotFound, None)
    }

    /// What the parts of a driver show that can be exchanged. `latency` is its least response time (s).
    fn parts(&mut self, parts: &DriverParts, latency: Option<f64>) -> Option<(Weakness, Option<f64>)> {
        if let Some(exact) = &parts.exact_sensors {
            let turns = self.experiments.is_turned_by(exact);
            self.tried.push(("exact sensors".into(), turns));
            if turns {
                let turning = |(_, driver): &&(Weakness, _)| self.experiments.is_turned_by(driver);
                let first = parts.sensors.iter().find(turning).map(|(weakness, _)| *weakness);
                return Some((first.unwrap_or(Weakness::Errors), None));
            }
        }
        let turns = self.experiments.is_turned_by(parts.prompt.as_ref()?);
        self.tried.push(("no delay".into(), turns));
        turns.then_some((Weakness::Delay, latency))
    }

    /// Whether the driver gives the commands of an empty road wherever the pedestrian seems to be.
    fn ignores(&mut self) -> bool {
        let changes = [Change::Foretold, Change::Sideways(MAX.1), Change::Nearer(MAX.2), Change::Mirrored];
        let base = self.experiments.base.clone();
        let is_same =
            |change| self.experiments.run(change).is_some_and(|run| Experiments::differs(&base, &run).is_none());
        changes.map(is_same) == [true; 4]
    }

    /// What a driver expects wrongly that sees the pedestrian and brakes too late or not at all.
    fn unforeseen(&mut self, facts: &Facts) -> Option<(Weakness, Option<f64>)> {
        let pair = self.experiments.pair();
        let edge = pair.blueprint.half_width + pair.body.radius / 2.0;
        let watches = [edge, -edge].map(|left| self.experiments.respond(facts.fast, (BESIDE.0, left), 1.0).is_some());
        self.tried.push(("somebody who stands at the edge of its way".into(), watches != [false; 2]));
        let aside = self.experiments.least(MAX.1, Change::Sideways);
        self.tried.push((format!("up to {} m nearer to the middle of its way", MAX.1), aside.is_some()));
        if aside.is_some() && watches == [false; 2] {
            return Some((Weakness::Corridor, aside));
        }
        let velocity = self.turns("the velocity that leads to the touch", Change::TrueVelocity);
        if velocity || self.turns("somebody who stands at the place of the touch", Change::Foretold) || aside.is_some()
        {
            return Some((Weakness::Anticipation, aside));
        }
        let nearer = self.experiments.least(MAX.2, Change::Nearer);
        self.tried.push((format!("up to {} m nearer along its way", MAX.2), nearer.is_some()));
        nearer.map(|nearer| (Weakness::Distance, Some(nearer)))
    }

    /// Whether somebody in its way is noticed too late at this speed: beyond a fixed range, or at a distance that grows with the speed but too little.
    fn distance(&mut self, facts: &Facts) -> Option<(Weakness, Option<f64>)> {
        let gap = facts.far?.gap.filter(|gap| *gap < FAR - SPARE)?;
        let reaction = facts.speed * (facts.latency()?.0 + self.experiments.dt()) + SPARE;
        let needed = |deceleration: f64| reaction + facts.speed * facts.speed / (2.0 * deceleration);
        if gap >= needed(ENOUGH.0) {
            return None;
        }
        let faster = self.experiments.respond(facts.fast, (FAR, 0.0), FASTER).and_then(|faster| faster.gap);
        let is_fixed = faster.is_some_and(|faster| faster <= SAME * gap + SPARE / 2.0);
        let (weakness, needed) =
            if is_fixed { (Weakness::Range, needed(ENOUGH.0)) } else { (Weakness::Distance, needed(ENOUGH.1)) };
        let is_short = gap < needed;
        self.tried.push((format!("somebody in its way: brakes {gap:.1} m ahead, {needed:.1} m are needed"), is_short));
        is_short.then_some((weakness, Some(gap)))
    }

    /// Whether it reacts on one side only.
    fn one_side(&mut self, facts: &Facts) -> Option<(Weakness, Option<f64>)> {
        let (ahead, aside) = BESIDE;
        let [left, right] = [aside, -aside].map(|left| self.experiments.respond(facts.fast, (ahead, left), 1.0));
        let late = |one: Option<Response>, other: Option<Response>| match (one, other) {
            (Some(one), Some(other)) => other.time - one.time > EARLIER,
            (one, other) => one.is_some() && other.is_none(),
        };
        let differs = late(left, right) || late(right, left) || self.reacts_earlier(facts);
        self.tried.push(("from the other side".into(), differs));
        differs.then_some((Weakness::BlindSide, None))
    }

    /// Whether it reacts earlier to a pedestrian from the other side.
    fn reacts_earlier(&mut self, facts: &Facts) -> bool {
        let Some(mirrored) = self.experiments.run(Change::Mirrored) else { return false };
        let Some(unseen) = self.experiments.run(Change::Unseen) else { return false };
        let then = Experiments::differs(&mirrored, &unseen);
        then.is_some_and(|then| {
            facts.reaction.is_none_or(|now| f64::from(now - then.min(now)) * self.experiments.dt() > EARLIER)
        })
    }

    /// The hardest deceleration before the end (m/s²).
    fn hardest(&self) -> Option<f64> {
        let frames = self.experiments.base.trace.vehicle(0);
        let slower = frames.windows(2).map(|pair| (pair[0].state.speed - pair[1].state.speed) / self.experiments.dt());
        slower.max_by(f64::total_cmp).filter(|_| frames.iter().any(|frame| frame.driven.control.brake > BRAKING))
    }

    /// The setting whose value must change least to turn the failure; those of the world come last.
    fn setting(&mut self, settings: &[Setting]) -> Option<TurnedBy> {
        let mut best: Option<(f64, &Setting, f64)> = None;
        for setting in settings {
            let found = self.least_change(setting);
            self.tried.push((format!("other values of `{}`", setting.name), found.is_some()));
            let Some((size, value)) = found else { continue };
            if best.is_none_or(|(least, ..)| size < least) {
                best = Some((size, setting, value));
            }
        }
        let scenario = self.experiments.incident.scenario.clone();
        if scenario.episode.friction.is_some() {
            let mut dry = Scenario::clone(&scenario);
            dry.cast.vehicles[0].blueprint.grip = f64::INFINITY;
            let turns = self.experiments.is_turned_in(Arc::new(dry));
            self.tried.push(("a dry road".into(), turns));
        }
        let (_, setting, value) = best?;
        let seed = self.experiments.incident.seed.child("natural");
        let natural = [setting.value, value].map(|value| {
            let mut scenario = Scenario::clone(&scenario);
            scenario.cast.vehicles[0].policy = (setting.make)(value);
            natural_traffic(&Arc::new(scenario), NATURAL, &seed)
        });
        Some(TurnedBy { name: setting.name.clone(), unit: setting.unit, from: setting.value, to: value, natural })
    }

    /// The least change of a setting that turns the failure: its size, as a logarithm of the ratio, and the value.
    fn least_change(&mut self, setting: &Setting) -> Option<(f64, f64)> {
        let before = setting.value;
        let size = |value: f64| match before == 0.0 {
            true => 1.0 + value.abs(),
            false => libm::log(value / before).abs(),
        };
        let mut best: Option<(f64, f64)> = None;
        for up in [true, false] {
            let steps = if before == 0.0 { FROM_ZERO } else { RATIOS };
            let value = |step: f64| match (before == 0.0, up) {
                (true, true) => step,
                (true, false) => -step,
                (false, true) => before * step,
                (false, false) => before / step,
            };
            let mut fails = before;
            for step in steps {
                let mut helps = value(step).clamp(setting.bounds.0, setting.bounds.1);
                if helps == fails || best.is_some_and(|(least, _)| size(helps) > 4.0 * least) {
                    break;
                }
                if !self.experiments.is_turned_by(&(setting.make)(helps)) {
                    fails = helps;
                    continue;
                }
                for _ in 0..HALVINGS {
                    let middle = rounded((helps + fails) / 2.0, (helps - before).abs());
                    if middle == helps || middle == fails {
                        break;
                    }
                    if self.experiments.is_turned_by(&(setting.make)(middle)) { helps = middle } else { fails = middle }
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

/// A value to about three digits of a change.
fn rounded(value: f64, change: f64) -> f64 {
    let digits = (2.0 - libm::floor(libm::log10(change.max(1e-9)))).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}").parse().unwrap_or(value)
}
