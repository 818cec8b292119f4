use super::altered::BRAKING;
use super::experiments::{Experiments, PARTS};
use super::profile::Profile;
use super::sentence::faculty;
use super::setting::Variable;
use super::violated::violated_part;
use super::{Change, Incident};
use crate::Traffic;
use episode::{Criterion, DriverParts};
use world::av::{DrivingMode, Fault, Weakness};

/// Response times above this (s) count as a delay: two ticks of most drivers are none.
const PROMPT: f64 = 0.15;
/// A driver that brakes less hard than this (m/s²) for somebody near brakes weakly: what UN Regulation 152 demands, and what the careful human of UN
/// Regulation 157 does.
const WEAK: (f64, f64) = (5.0, 7.59);
/// A driver that ignores people presses its brake no harder in this time before the touch (s).
const KEPT: f64 = 1.0;
/// Response times that differ by more than this (s) show that the driver loses somebody.
const FLICKER: f64 = 0.2;
/// Multiples of a delay by which pedestrians are seen earlier: the driver's plan is late, too.
const COMPENSATED: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// A response time above this (s) is a weakness by itself.
const LATE: f64 = 0.4;
/// Decelerations that must be enough for somebody far ahead (m/s²): beyond a fixed range (that of AASHTO's stopping sight distance), and at a distance that
/// grows with the speed.
const ENOUGH: (f64, f64) = (3.4, 5.0);
/// A driver that sees less than this share of its half width on one side does not see that side.
const BLIND: f64 = 0.75;
/// Distance that is left before somebody who is not hit (m).
pub(super) const SPARE: f64 = 1.0;
/// Maximum amounts that are tried: how much earlier (s), farther to the middle, and nearer (m).
const MAX: (f64, f64, f64) = (3.0, 6.0, 30.0);
/// Maximum number of episodes of an explanation where the caller sets none.
pub const MAX_RUNS: u32 = 600;
/// The same for a program, of whose failures several are explained.
pub const MAX_RUNS_OF_PROGRAM: u32 = 200;
/// The time before a touch in which a car that drove off stood (s).
const DROVE_OFF: f64 = 6.0;
/// A driver that reacts earlier by this to a pedestrian from the other side (s) sees one side only.
const EARLIER: f64 = 0.5;
/// What of a driver is made perfect.
pub(super) const FACULTIES: [&str; 4] = ["perfect perception", "perfect prediction", "a perfect brake", "no delay"];

/// Why a driver failed, by runs with one thing changed. Times are before the touch, or before the end of the episode that violates a requirement (s).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cause {
    pub weakness: Weakness,
    /// Of [`Weakness`]: how much of it, such as the delay (s) or by how much the corridor is too narrow (m).
    pub amount: Option<f64>,
    /// The side of the car that the driver does not watch enough, if a [`Weakness::BlindSide`] is named: `left` or `right`.
    pub side: Option<&'static str>,
    /// Weaknesses of which the repair of each alone avoids the failure, as runs show: the named one, and the next in the order of the rules.
    pub enough: Vec<Weakness>,
    /// What times are before: `the collision`, or `the end of the episode` of a violation.
    pub end: &'static str,
    /// Which requirement is violated, when and by how much; `None` of a collision.
    pub violated: Option<String>,
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
    /// What of a driver was made perfect, one at a time, and whether that turns it. One that does not is left out if a stronger repair of the same is enough.
    pub faculties: Vec<(&'static str, bool)>,
    /// The smallest change of a setting of the driver or of its sensors that turns it, as all larger ones that were tried do; one that costs no faults in
    /// natural crossings comes first.
    pub setting: Option<TurnedBy>,
    /// The same of the world: a lower speed limit, a road with more friction.
    pub world: Option<TurnedBy>,
    /// What turns it if it is not there: the traffic lights, or an obstacle that hides the pedestrian.
    pub without: Option<String>,
    /// What was tried, each with whether it turns the failure.
    pub tried: Vec<(String, bool)>,
    /// The number of episodes that it took.
    pub runs: u32,
    /// Whether more runs were wanted than the limit allows. What was not asked by then is left out, and the weakness is
    /// [`Weakness::NotFound`] if the cause depends on that.
    pub is_cut: bool,
    /// Why there were no more runs before the limit: the driver failed as a program in one, which is no evidence.
    pub fault: Option<Fault>,
}

/// What is asked about a failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Questions {
    /// The weakness, and what would have helped when.
    Weakness,
    /// The settings too; `None` for a driver that cannot be copied, such as a program, which drives its run-up in each of about a hundred runs.
    OfCopied,
    /// The settings too, of every driver. Those of the world are left out for one that cannot be copied.
    All,
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

/// How many episodes an explanation may take.
#[derive(Clone, Copy)]
pub struct RunLimit<'a> {
    pub max_runs: u32,
    /// Called before each episode after the first, which repeats the failure.
    pub ran: &'a dyn Fn(),
}

impl Default for RunLimit<'_> {
    fn default() -> Self {
        Self { max_runs: MAX_RUNS, ran: &|| () }
    }
}

/// Finds out why one of several incidents happened: if its driver cannot be copied, such as a program, in few episodes and without settings.
pub fn explain_any(incident: &Incident) -> Option<Cause> {
    let of_program = RunLimit { max_runs: MAX_RUNS_OF_PROGRAM, ..RunLimit::default() };
    let copied = explain(incident, Questions::OfCopied, RunLimit::default());
    copied.or_else(|| explain(incident, Questions::Weakness, of_program))
}

/// Finds out why an incident happened; `None` if it is not a failure when it is repeated.
pub fn explain(incident: &Incident, questions: Questions, limit: RunLimit<'_>) -> Option<Cause> {
    let incident = &incident.lasting();
    let parts = &incident.scenario.cast.ego().parts;
    let mut it = Experiments::new(incident, questions != Questions::OfCopied, limit)?;
    let mut cause = match it.facts() {
        Some(facts) => it.cause(parts, &facts),
        None if it.is_cut => Cause::default(),
        None => return None,
    };
    if it.is_cut {
        // What was found up to here depends on runs that are missing.
        cause = Cause::default();
    } else if questions > Questions::Weakness {
        cause.setting = it.setting(&Variable::of_driver(&parts.settings, &incident.scenario));
        if it.is_copied() {
            cause.world = it.setting(&Variable::of_world(&it));
            cause.without = it.without();
        }
    }
    let end = if incident.criterion == Criterion::Collision { "the collision" } else { "the end of the episode" };
    let violated = it.violated();
    Some(Cause { end, violated, tried: it.tried, runs: it.runs, is_cut: it.is_cut, fault: it.fault, ..cause })
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

impl Experiments<'_> {
    /// As `` `slow_pass` 3.2 s after the start by 0.31 m/s; `ego_speed < 3 m/s` decides``; `None` of a collision.
    fn violated(&self) -> Option<String> {
        let place = self.incident.criterion.requirement()?;
        let (named, degree) = (self.incident.scenario.requirements.get(place)?, self.base.trace.degrees().get(place)?);
        let instant = degree.instant(self.dt()).min(self.base.outcome.duration);
        Some(format!("`{}` {instant:.1} s after the start{}", named.name, violated_part(named, degree)))
    }

    /// The cause without settings.
    fn cause(&mut self, parts: &DriverParts, facts: &Facts) -> Cause {
        let (weakness, amount) = self.weakness(parts, facts);
        let mut faculties = self.faculties(parts, facts).to_vec();
        let enough = self.enough(weakness, facts);
        faculties.retain(|(what, turns)| *turns || enough.iter().all(|weakness| faculty(*weakness) != Some(*what)));
        let is_of_side = weakness == Weakness::BlindSide || enough.contains(&Weakness::BlindSide);
        let side = is_of_side.then(|| self.sides(facts).0);
        let Facts { last, seen, reaction, braked, drove_off, .. } = *facts;
        let before = |tick: u32| self.before(tick);
        Cause {
            weakness,
            amount,
            side,
            enough,
            last: last.map(|tick| tick.map(before)),
            seen,
            reacted: reaction.map(before),
            braked: braked.map(before),
            drove_off,
            faculties,
            ..Cause::default()
        }
    }

    fn facts(&mut self) -> Option<Facts> {
        let it = self;
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
    fn tries(&mut self, what: &str, change: Change) -> bool {
        let turns = self.turns(change);
        self.note(what, turns)
    }

    /// The first weakness that explains the failure, with its amount.
    fn weakness(&mut self, parts: &DriverParts, facts: &Facts) -> (Weakness, Option<f64>) {
        self.note("nobody there", false);
        let Profile { latency, deceleration, releases, loses, gives_way, .. } = facts.profile;
        let dt = self.dt();
        self.note("somebody near: brakes harder, or leaves its way", !gives_way);
        if !gives_way && if facts.reaction.is_some() { self.keeps_brake(KEPT) } else { self.ignores() } {
            return (Weakness::Ignores, None);
        }
        if let Some(found) = self.parts(parts, latency.map(|latency| latency.0)) {
            return found;
        }
        let full_braking = facts.last[0].map_or(0.0, |tick| self.before(tick));
        if facts.seen + dt < full_braking && self.tries("sight through obstacles", Change::SeenThrough) {
            return (Weakness::Hidden, Some(facts.seen));
        }
        if let Some((least, most)) = latency {
            let flickers = least <= PROMPT && (loses || most - least > FLICKER);
            self.note(format!("somebody near, a little later: reacts in {least:.2} to {most:.2} s"), flickers);
            if flickers {
                return (Weakness::Dropouts, None);
            }
        }
        if let Some((delay, _)) = latency.filter(|(delay, _)| *delay > PROMPT) {
            let earlier = |time: f64| Change::Earlier((time / dt).round() as u32);
            let turns = COMPENSATED.into_iter().any(|part| self.turns(earlier(part * delay)));
            self.note(format!("{delay:.2} s earlier"), turns);
            if turns || delay > LATE {
                return (Weakness::Delay, Some(delay));
            }
        }
        self.note(format!("somebody near: brakes with {deceleration:.1} m/s²"), deceleration < WEAK.1);
        if let Some(found) = self.beside(facts) {
            return found;
        }
        if (facts.released || facts.reaction.is_none())
            && releases
            && self.tries("keeps the brake once it brakes", Change::KeepsBraking)
        {
            return (Weakness::LetsGo, None);
        }
        let brake = (WEAK.0 / deceleration.max(0.1), WEAK.1 / deceleration.max(0.1));
        let (distance, missing) = self.distance(facts);
        let is_weak = if missing > 1.0 { brake.0 > missing } else { brake.1 > 1.0 };
        if latency.is_some() && is_weak && self.tries("full braking once it brakes", Change::BrakesFully) {
            return (Weakness::WeakBrake, self.hardest());
        }
        if let Some(found) = distance.or_else(|| self.unforeseen()) {
            return found;
        }
        if self.tries("full braking once it brakes", Change::BrakesFully) {
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
            let turns = self.is_turned_by(exact);
            self.note("exact sensors", turns);
            if turns {
                let turning = |(_, driver): &&(Weakness, _)| self.is_turned_by(driver);
                let first = parts.sensors.iter().find(turning).map(|(weakness, _)| *weakness);
                return Some((first.unwrap_or(Weakness::Errors), None));
            }
        }
        let turns = self.is_turned_by(parts.prompt.as_ref()?);
        self.note("no delay", turns);
        turns.then_some((Weakness::Delay, latency))
    }

    /// The named weakness, if a run shows that its repair alone avoids the failure, and the next one in the order of the rules whose repair alone does,
    /// too. A third would tell little: most failures are avoided by several repairs.
    fn enough(&mut self, named: Weakness, facts: &Facts) -> Vec<Weakness> {
        if matches!(named, Weakness::Ignores | Weakness::NotFound) {
            return Vec::new();
        }
        let parts = ["exact sensors", "no delay"];
        let is_shown = self.tried.iter().any(|(what, turns)| *turns && parts.contains(&what.as_str()));
        let (own, others): (Vec<_>, Vec<_>) =
            self.repairs(named, facts).into_iter().partition(|repair| repair.0 == named);
        let mut turns = |changes: &[Change]| changes.iter().any(|change| self.turns(*change));
        let named = (is_shown || own.iter().any(|(.., changes)| turns(changes))).then_some(named);
        let next = others.iter().find(|(_, shows, changes)| *shows && turns(changes));
        named.into_iter().chain(next.map(|(weakness, ..)| *weakness)).collect()
    }

    /// What repairs each weakness, in the order of the rules, with whether it counts beside the named one: the driver shows it.
    fn repairs(&self, named: Weakness, facts: &Facts) -> [(Weakness, bool, Vec<Change>); 10] {
        let Facts { seen, last, released, reaction, profile, .. } = facts;
        let full_braking = last[0].map_or(0.0, |tick| self.before(tick));
        let delay = profile.latency.map_or(0.0, |latency| latency.0);
        let earlier = COMPENSATED.map(|part| Change::Earlier((part * delay / self.dt()).round() as u32));
        let (_, side, other, edge) = self.sides(facts);
        let is_narrow = side < edge && edge <= other;
        let [fixed, growing] = self.needed(profile);
        let [reach, _] = profile.reach;
        let is_short = profile.is_fixed() && reach < fixed;
        let nearer = profile.gap.map(|gap| growing - gap);
        let is_unforeseen = named == Weakness::Anticipation;
        let lets_go = profile.releases && (*released || reaction.is_none());
        [
            (Weakness::Hidden, seen + self.dt() < full_braking, vec![Change::SeenThrough]),
            (Weakness::Delay, delay > PROMPT, earlier.into()),
            (Weakness::BlindSide, is_narrow, vec![Change::Mirrored]),
            (Weakness::Corridor, side.max(other) < edge, PARTS.map(|part| Change::Sideways(part * MAX.1)).into()),
            (Weakness::LetsGo, lets_go, vec![Change::KeepsBraking]),
            (Weakness::WeakBrake, profile.deceleration < WEAK.1, vec![Change::BrakesFully]),
            (Weakness::Range, is_short, vec![Change::Nearer(fixed - reach)]),
            (Weakness::Distance, !is_short && nearer > Some(0.0), nearer.map(Change::Nearer).into_iter().collect()),
            (Weakness::Anticipation, true, vec![Change::TrueVelocity, Change::Foretold]),
            (Weakness::Distance, is_unforeseen, PARTS.map(|part| Change::Nearer(part * MAX.2)).into()),
        ]
    }

    /// The narrower side from which the pedestrian came while full braking helped; how far beside its axis the driver reacts to somebody there, how far on
    /// the other side, and how far it must (m).
    fn sides(&self, facts: &Facts) -> (&'static str, f64, f64, f64) {
        let pair = self.pair();
        let seen = pair.frames().take(facts.last[0].map_or(usize::MAX, |tick| tick as usize + 1));
        let left = seen.map(|frame| frame.ego.pose.to_local(frame.pedestrian.pose.position()).y);
        let was = [1.0, -1.0].map(|side| left.clone().any(|left| side * left > 0.0));
        let [left, right] = facts.profile.stands;
        let edge = pair.blueprint.half_width + pair.body.radius / 2.0;
        let is_left = was[0] && (left <= right || !was[1]);
        if is_left { ("left", left, right, edge) } else { ("right", right, left, edge) }
    }

    /// How far ahead somebody in its way must be noticed if that is at a fixed range, and braked for if the distance grows with the speed (m).
    fn needed(&self, profile: &Profile) -> [f64; 2] {
        let Profile { speed, latency, .. } = profile;
        let reaction = speed * (latency.map_or(0.0, |latency| latency.0) + self.dt()) + SPARE;
        [ENOUGH.0, ENOUGH.1].map(|deceleration| reaction + speed * speed / (2.0 * deceleration))
    }

    /// Whether perfect perception, perfect prediction, a perfect brake, and no delay turn the failure, one at a time.
    fn faculties(&mut self, parts: &DriverParts, facts: &Facts) -> [(&'static str, bool); 4] {
        let late = facts.profile.latency.map_or(0, |(least, _)| (least / self.dt()).round() as u32);
        let parts = [&parts.exact_sensors, &None, &None, &parts.prompt];
        let changes = [
            vec![Change::SeenThrough],
            vec![Change::TrueVelocity, Change::Foretold],
            vec![Change::BrakesFully, Change::KeepsBraking],
            (late > 0).then_some(Change::Earlier(late)).into_iter().collect(),
        ];
        let mut each = FACULTIES.into_iter().zip(changes).zip(parts).map(|((what, changes), part)| {
            let is_turned = part.as_ref().is_some_and(|part| self.is_turned_by(part));
            (what, is_turned || changes.iter().any(|change| self.turns(*change)))
        });
        std::array::from_fn(|_| each.next().expect("there are four"))
    }

    /// Whether the driver gives the commands of an empty road wherever the pedestrian seems to be.
    fn ignores(&mut self) -> bool {
        let changes = [Change::Foretold, Change::Sideways(MAX.1), Change::Nearer(MAX.2), Change::Mirrored];
        let base = self.base.clone();
        let is_same = |change| self.run(change).is_some_and(|run| Experiments::differs(&base, &run).is_none());
        changes.map(is_same) == [true; 4]
    }

    /// Whether it does not watch the side of the pedestrian, or too little of both.
    fn beside(&mut self, facts: &Facts) -> Option<(Weakness, Option<f64>)> {
        let [left, right] = facts.profile.stands;
        let (_, side, other, edge) = self.sides(facts);
        self.note(
            format!("somebody beside its axis: reacts up to {left:.1} m to the left and {right:.1} m to the right"),
            left.min(right) < edge,
        );
        let width = self.pair().blueprint.half_width;
        let is_blind = side < BLIND * width && other >= width;
        let is_narrow = side < edge && edge <= other;
        if is_blind || is_narrow && self.tries("the same one from the other side", Change::Mirrored) {
            return Some((Weakness::BlindSide, Some(side)));
        }
        if side.max(other) >= edge {
            return None;
        }
        let aside = self.least(MAX.1, Change::Sideways);
        self.note(format!("up to {} m nearer to the middle of its way", MAX.1), aside.is_some());
        aside.map(|aside| (Weakness::Corridor, Some(aside)))
    }

    /// What a driver expects wrongly that sees the pedestrian and brakes too late or not at all.
    fn unforeseen(&mut self) -> Option<(Weakness, Option<f64>)> {
        let velocity = self.tries("the velocity that leads to the touch", Change::TrueVelocity);
        if velocity || self.tries("somebody who stands at the place of the touch", Change::Foretold) {
            return Some((Weakness::Anticipation, None));
        }
        let aside = self.least(MAX.1, Change::Sideways);
        self.note(format!("up to {} m nearer to the middle of its way", MAX.1), aside.is_some());
        if aside.is_some() {
            return Some((Weakness::Anticipation, aside));
        }
        let nearer = self.least(MAX.2, Change::Nearer);
        self.note(format!("up to {} m nearer along its way", MAX.2), nearer.is_some());
        nearer.map(|_| (Weakness::Distance, None))
    }

    /// Whether somebody in its way is noticed too late at this speed: beyond a fixed range, or at a distance that grows with the speed but too little.
    /// With the ratio of the distance that is needed to that at which it notices somebody.
    fn distance(&mut self, facts: &Facts) -> (Option<(Weakness, Option<f64>)>, f64) {
        let Profile { reach: [reach, _], gap, .. } = facts.profile;
        let [fixed, growing] = self.needed(&facts.profile);
        let ratio = fixed / reach.max(0.1);
        let is_short = facts.profile.is_fixed() && ratio > 1.0;
        self.note(format!("somebody in its way: notices {reach:.1} m ahead, {fixed:.1} m are needed"), is_short);
        if is_short {
            return (Some((Weakness::Range, Some(reach))), ratio);
        }
        let Some(gap) = gap else { return (None, 0.0) };
        self.note(format!("somebody in its way: brakes {gap:.1} m ahead, {growing:.1} m are needed"), gap < growing);
        ((gap < growing).then_some((Weakness::Distance, Some(gap))), 0.0)
    }

    /// Whether it reacts earlier to a pedestrian from the other side.
    fn reacts_earlier(&mut self, facts: &Facts) -> bool {
        let Some(mirrored) = self.run(Change::Mirrored) else { return false };
        let Some(unseen) = self.run(Change::Unseen) else { return false };
        let then = Experiments::differs(&mirrored, &unseen);
        then.is_some_and(|then| facts.reaction.is_none_or(|now| f64::from(now - then.min(now)) * self.dt() > EARLIER))
    }

    /// The hardest deceleration before the end (m/s²).
    fn hardest(&self) -> Option<f64> {
        let frames = self.base.trace.vehicle(0);
        let slower = frames.windows(2).map(|pair| (pair[0].state.speed - pair[1].state.speed) / self.dt());
        slower.max_by(f64::total_cmp).filter(|_| frames.iter().any(|frame| frame.driven.control.brake > BRAKING))
    }
}
