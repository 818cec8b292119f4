use super::experiments::Experiments;
use super::profile::Profile;
use super::sentence::faculty;
use super::setting::Variable;
use super::shown::{Facts, MAX, Repair, Shown};
use super::violated::violated_part;
use super::{Cause, Change, FACULTIES, Incident, MAX_RUNS_OF_PROGRAM, Questions, RunLimit};
use episode::{Criterion, DriverParts};
use world::av::{DrivingMode, Weakness};

/// A driver that ignores people presses its brake no harder in this time before the touch (s).
const KEPT: f64 = 1.0;
/// The time before a touch in which a car that drove off stood (s).
const DROVE_OFF: f64 = 6.0;
/// Runs in which a driver that draws draws other numbers.
const DRAWS: u64 = 5;

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
            cause.without = it.without(cause.drove_off == Some(true));
        }
    }
    let end = if incident.criterion == Criterion::Collision { "the collision" } else { "the end of the episode" };
    let violated = it.violated();
    Some(Cause { end, violated, tried: it.tried, runs: it.runs, is_cut: it.is_cut, fault: it.fault, ..cause })
}

/// A weakness that explains the failure.
struct Found {
    weakness: Weakness,
    amount: Option<f64>,
    /// Whether its repair alone avoids it.
    turns: bool,
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
        let found = self.found(parts, facts);
        let (weakness, amount) = found.first().map_or((Weakness::NotFound, None), |it| (it.weakness, it.amount));
        let enough: Vec<Weakness> = found.iter().filter(|it| it.turns).map(|it| it.weakness).collect();
        let mut faculties = self.faculties(parts, facts).to_vec();
        faculties.retain(|(what, turns)| *turns || enough.iter().all(|weakness| faculty(*weakness) != Some(*what)));
        let is_of_side = found.iter().any(|it| it.weakness == Weakness::BlindSide);
        let side = is_of_side.then(|| self.sides(facts).0);
        let Facts { last, seen, reaction, braked, drove_off, .. } = *facts;
        let before = |tick: u32| self.before(tick);
        let mut cause = Cause {
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
        };
        cause.draws = self.draws();
        let is_chance = cause.draws.is_some_and(|[avoided, all]| 2 * avoided > all);
        if is_chance && !matches!(weakness, Weakness::Ignores | Weakness::Dropouts) {
            (cause.weakness, cause.amount, cause.enough) = (Weakness::NotFound, None, Vec::new());
        }
        cause
    }

    /// In how many of how many runs in which the driver draws other numbers it avoids the failure; `None` if it draws nothing.
    fn draws(&mut self) -> Option<[u32; 2]> {
        let first = self.run(Change::Redrawn(0))?;
        Experiments::differs(&self.base, &first)?;
        let avoided = (0..DRAWS).filter(|index| self.turns(Change::Redrawn(*index))).count();
        Some([avoided as u32, DRAWS as u32])
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
        let braking = reaction.and_then(|reaction| it.braking(reaction, &unseen));
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

    /// The weaknesses that the driver shows and of which the repair alone avoids the failure, at most two, in the order of the rules. What no run can repair, such
    /// as a driver that loses people, counts if it is shown, and only as the first.
    fn found(&mut self, parts: &DriverParts, facts: &Facts) -> Vec<Found> {
        self.note("nobody there", false);
        let gives_way = facts.profile.gives_way;
        self.note("somebody near: brakes harder, or leaves its way", !gives_way);
        if !gives_way && if facts.reaction.is_some() { self.keeps_brake(KEPT) } else { self.ignores() } {
            return vec![Found { weakness: Weakness::Ignores, amount: None, turns: false }];
        }
        let mut found: Vec<Found> = self.parts(parts, facts).into_iter().collect();
        for shown in self.shown(facts) {
            if found.len() == 2 || found.iter().any(|it| it.weakness == shown.weakness) {
                continue;
            }
            let repaired = match &shown.repair {
                Repair::Unknown => None,
                Repair::AnyOf(changes) => changes.iter().any(|change| self.turns(*change)).then_some(shown.amount),
                Repair::Least(maximum, change) => self.least(*maximum, change).map(Some),
            };
            self.note(shown.what, repaired.is_some() || matches!(shown.repair, Repair::Unknown));
            let Shown { weakness, amount, .. } = shown;
            match repaired {
                Some(amount) => found.push(Found { weakness, amount, turns: true }),
                None if found.is_empty() && shown.is_certain => found.push(Found { weakness, amount, turns: false }),
                None => {}
            }
        }
        found
    }

    /// What the parts of a driver show that can be exchanged.
    fn parts(&mut self, parts: &DriverParts, facts: &Facts) -> Option<Found> {
        let found = |weakness, amount| Found { weakness, amount, turns: true };
        if let Some(exact) = &parts.exact_sensors {
            let turns = self.is_turned_by(exact);
            self.note("exact sensors", turns);
            if turns {
                let turning = |(_, driver): &&(Weakness, _)| self.is_turned_by(driver);
                let first = parts.sensors.iter().find(turning).map(|(weakness, _)| *weakness);
                return Some(found(first.unwrap_or(Weakness::Errors), None));
            }
        }
        let turns = self.is_turned_by(parts.prompt.as_ref()?);
        self.note("no delay", turns);
        turns.then(|| found(Weakness::Delay, facts.profile.latency.map(|latency| latency.0)))
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
        let changes = [Change::Foretold, Change::Sideways(MAX.0), Change::Nearer(MAX.1), Change::Mirrored];
        let base = self.base.clone();
        let is_same = |change| self.run(change).is_some_and(|run| Experiments::differs(&base, &run).is_none());
        changes.map(is_same) == [true; 4]
    }
}
