use std::sync::Arc;

use super::altered::BRAKING;
use super::experiments::Experiments;
use super::profile::Profile;
use super::{Change, Incident};
use crate::av::{DrivingMode, Weakness};
use crate::env::{DriverParts, PolicyMaker, Scenario, Setting};
use crate::hardening::{Traffic, natural_traffic};

/// Response times above this (s) count as a delay: two ticks of most drivers are none.
const PROMPT: f64 = 0.15;
/// A driver that brakes less hard than this (m/s²) for somebody near brakes weakly: what UN Regulation 152 demands, and what the careful human of UN
/// Regulation 157 does.
const WEAK: (f64, f64) = (5.0, 7.59);
/// Response times that differ by more than this (s) show that the driver loses somebody.
const FLICKER: f64 = 0.2;
/// Multiples of a delay by which pedestrians are seen earlier: the driver's plan is late, too.
const COMPENSATED: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// A response time above this (s) is a weakness by itself.
const LATE: f64 = 0.4;
/// Decelerations that must be enough for somebody far ahead (m/s²): beyond a fixed range (that of AASHTO's stopping sight distance), and at a distance that
/// grows with the speed.
const ENOUGH: (f64, f64) = (3.4, 5.0);
/// The ratio of distances of reaction, at one and a half times the speed, below which they do not grow with it.
const SAME: f64 = 1.1;
/// A driver that sees less than this share of its half width on one side does not see that side.
const BLIND: f64 = 0.75;
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
/// Maximum number of settings whose cost is compared.
const MAX_COSTED: usize = 3;
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
    /// What of a driver was made perfect, one at a time, and whether that turns it.
    pub faculties: [(&'static str, bool); 4],
    /// The smallest change of a setting that turns it; one that costs no faults in natural crossings comes first.
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
    let faculties = inquiry.faculties(parts, &facts);
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
        faculties,
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
    profile: Profile,
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
        let profile = Profile::new(it)?;
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
            profile,
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
        let Profile { latency, deceleration, releases, loses, .. } = facts.profile;
        let dt = self.experiments.dt();
        if facts.reaction.is_none() && latency.is_none() && self.ignores() {
            return (Weakness::Ignores, None);
        }
        if let Some(found) = self.parts(parts, latency.map(|latency| latency.0)) {
            return found;
        }
        let full_braking = facts.last[0].map_or(0.0, |tick| self.experiments.before(tick));
        if facts.seen + dt < full_braking && self.turns("sight through obstacles", Change::SeenThrough) {
            return (Weakness::Hidden, Some(facts.seen));
        }
        if let Some((least, most)) = latency {
            let flickers = least <= PROMPT && (loses || most - least > FLICKER);
            self.tried.push((format!("somebody near, a little later: reacts in {least:.2} to {most:.2} s"), flickers));
            if flickers {
                return (Weakness::Dropouts, None);
            }
        }
        if let Some((delay, _)) = latency.filter(|(delay, _)| *delay > PROMPT) {
            let earlier = |time: f64| Change::Earlier((time / dt).round() as u32);
            let turns = COMPENSATED.into_iter().any(|part| self.experiments.turns(earlier(part * delay)));
            self.tried.push((format!("{delay:.2} s earlier"), turns));
            if turns || delay > LATE {
                return (Weakness::Delay, Some(delay));
            }
        }
        self.tried.push((format!("somebody near: brakes with {deceleration:.1} m/s²"), deceleration < WEAK.1));
        if let Some(found) = self.beside(facts) {
            return found;
        }
        if (facts.released || facts.reaction.is_none())
            && releases
            && self.turns("keeps the brake once it brakes", Change::KeepsBraking)
        {
            return (Weakness::LetsGo, None);
        }
        let brake = (WEAK.0 / deceleration.max(0.1), WEAK.1 / deceleration.max(0.1));
        let (distance, missing) = self.distance(facts);
        let is_weak = if missing > 1.0 { brake.0 > missing } else { brake.1 > 1.0 };
        if latency.is_some() && is_weak && self.turns("full braking once it brakes", Change::BrakesFully) {
            return (Weakness::WeakBrake, self.hardest());
        }
        if let Some(found) = distance.or_else(|| self.unforeseen()) {
            return found;
        }
        if self.turns("full braking once it brakes", Change::BrakesFully) {
            return (Weakness::WeakBrake, self.hardest());
        }
        if self.reacts_earlier(facts) {
            return (Weakness::BlindSide, None);
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

    /// Whether perfect perception, perfect prediction, a perfect brake, and no delay turn the failure.
    fn faculties(&mut self, parts: &DriverParts, facts: &Facts) -> [(&'static str, bool); 4] {
        let it = &mut self.experiments;
        let sees = parts.exact_sensors.as_ref().is_some_and(|exact| it.is_turned_by(exact));
        let perception = sees || it.turns(Change::SeenThrough);
        let prediction = [Change::TrueVelocity, Change::Foretold].into_iter().any(|change| it.turns(change));
        let brake = [Change::BrakesFully, Change::KeepsBraking].into_iter().any(|change| it.turns(change));
        let late = facts.profile.latency.map_or(0, |(least, _)| (least / it.dt()).round() as u32);
        let at_once = parts.prompt.as_ref().is_some_and(|prompt| it.is_turned_by(prompt));
        let prompt = at_once || late > 0 && it.turns(Change::Earlier(late));
        [
            ("perfect perception", perception),
            ("perfect prediction", prediction),
            ("a perfect brake", brake),
            ("no delay", prompt),
        ]
    }

    /// Whether the driver gives the commands of an empty road wherever the pedestrian seems to be.
    fn ignores(&mut self) -> bool {
        let changes = [Change::Foretold, Change::Sideways(MAX.1), Change::Nearer(MAX.2), Change::Mirrored];
        let base = self.experiments.base.clone();
        let is_same =
            |change| self.experiments.run(change).is_some_and(|run| Experiments::differs(&base, &run).is_none());
        changes.map(is_same) == [true; 4]
    }

    /// Whether it does not watch one side, or too little of both.
    fn beside(&mut self, facts: &Facts) -> Option<(Weakness, Option<f64>)> {
        let pair = self.experiments.pair();
        let (width, edge) = (pair.blueprint.half_width, pair.blueprint.half_width + pair.body.radius / 2.0);
        let [left, right] = facts.profile.stands;
        let watches = |side: f64, other: f64| side >= BLIND * width || other < width;
        self.tried.push((
            format!("somebody beside its axis: reacts up to {left:.1} m to the left and {right:.1} m to the right"),
            left.min(right) < edge,
        ));
        if !watches(left, right) || !watches(right, left) {
            return Some((Weakness::BlindSide, None));
        }
        if left.max(right) >= edge {
            return None;
        }
        let aside = self.experiments.least(MAX.1, Change::Sideways);
        self.tried.push((format!("up to {} m nearer to the middle of its way", MAX.1), aside.is_some()));
        aside.map(|aside| (Weakness::Corridor, Some(aside)))
    }

    /// What a driver expects wrongly that sees the pedestrian and brakes too late or not at all.
    fn unforeseen(&mut self) -> Option<(Weakness, Option<f64>)> {
        let velocity = self.turns("the velocity that leads to the touch", Change::TrueVelocity);
        if velocity || self.turns("somebody who stands at the place of the touch", Change::Foretold) {
            return Some((Weakness::Anticipation, None));
        }
        let aside = self.experiments.least(MAX.1, Change::Sideways);
        self.tried.push((format!("up to {} m nearer to the middle of its way", MAX.1), aside.is_some()));
        if aside.is_some() {
            return Some((Weakness::Anticipation, aside));
        }
        let nearer = self.experiments.least(MAX.2, Change::Nearer);
        self.tried.push((format!("up to {} m nearer along its way", MAX.2), nearer.is_some()));
        nearer.map(|nearer| (Weakness::Distance, Some(nearer)))
    }

    /// Whether somebody in its way is noticed too late at this speed: beyond a fixed range, or at a distance that grows with the speed but too little.
    /// With the ratio of the distance that is needed to that at which it notices somebody.
    fn distance(&mut self, facts: &Facts) -> (Option<(Weakness, Option<f64>)>, f64) {
        let Profile { speed, reach: [reach, faster], gap, latency, .. } = facts.profile;
        let reaction = speed * (latency.map_or(0.0, |latency| latency.0) + self.experiments.dt()) + SPARE;
        let needed = |deceleration: f64| reaction + speed * speed / (2.0 * deceleration);
        let is_fixed = faster <= SAME * reach + SPARE / 2.0;
        let ratio = needed(ENOUGH.0) / reach.max(0.1);
        self.tried.push((
            format!("somebody in its way: notices {reach:.1} m ahead, {:.1} m are needed", needed(ENOUGH.0)),
            is_fixed && ratio > 1.0,
        ));
        if is_fixed && ratio > 1.0 {
            return (Some((Weakness::Range, Some(reach))), ratio);
        }
        let Some(gap) = gap else { return (None, 0.0) };
        let needed = needed(ENOUGH.1);
        self.tried
            .push((format!("somebody in its way: brakes {gap:.1} m ahead, {needed:.1} m are needed"), gap < needed));
        ((gap < needed).then_some((Weakness::Distance, Some(gap))), 0.0)
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

    /// The setting whose value must change least to turn the failure, among those that cost no faults in natural crossings, or else among all.
    fn setting(&mut self, settings: &[Setting]) -> Option<TurnedBy> {
        let mut found: Vec<(f64, &Setting, f64)> = Vec::new();
        for setting in settings {
            let least = self.least_change(setting);
            self.tried.push((format!("other values of `{}`", setting.name), least.is_some()));
            found.extend(least.map(|(size, value)| (size, setting, value)));
        }
        let scenario = self.experiments.incident.scenario.clone();
        if scenario.episode.friction.is_some() {
            let mut dry = Scenario::clone(&scenario);
            dry.cast.vehicles[0].blueprint.grip = f64::INFINITY;
            let turns = self.experiments.is_turned_in(Arc::new(dry));
            self.tried.push(("a dry road".into(), turns));
        }
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        found.truncate(MAX_COSTED);
        let seed = self.experiments.incident.seed.child("natural");
        let traffic = |policy: PolicyMaker| {
            let mut scenario = Scenario::clone(&scenario);
            scenario.cast.vehicles[0].policy = policy;
            natural_traffic(&Arc::new(scenario), NATURAL, &seed)
        };
        let (_, first, _) = *found.first()?;
        let before = traffic((first.make)(first.value));
        let turned = |(_, setting, value): (f64, &Setting, f64)| TurnedBy {
            name: setting.name.clone(),
            unit: setting.unit,
            from: setting.value,
            to: value,
            natural: [before, traffic((setting.make)(value))],
        };
        found.into_iter().map(turned).min_by_key(|turned| turned.natural[1].faults.saturating_sub(before.faults))
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
