use super::Encounter;
use super::encounter::{RecordedCar, STANDING};
use road::geometry::{OrientedBox, first_touch};
use world::av::reference_drivers::{DelayedBrake, OwnMotion, ReferenceDriver, Threat};

/// Number of steps of a tick: reference drivers react in hundredths of a second.
const STEPS: u32 = 5;
/// An upper bound of the distance (m) that the rotation of the car moves a corner of it within a step.
const TURNING: f64 = 0.05;

/// The result of a reference driver in an encounter.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trial {
    /// Speed at which the car touched the pedestrian (m/s); `None` if it avoided the touch.
    pub impact_speed: Option<f64>,
    /// Time from the start of the question to that touch; without one, until the car had stopped or passed, or the time limit (s).
    pub time: f64,
    /// Least gap between car and pedestrian until the car stood (m); 0 at a touch.
    pub least_gap: f64,
    /// Whether the car was faster than 0.1 m/s at any time.
    pub moved: bool,
    /// Whether the driver braked.
    pub braked: bool,
    /// Whether it braked to a stop.
    pub stopped: bool,
}

/// The car, driven by the reference driver: how much slower it is than the recorded one, and how far behind.
///
/// Its speed is the lesser of the recorded car's and of the reference driver's own, which starts from the recorded speed at which that driver
/// noticed the pedestrian. So a driver that brakes as early and as hard as the reference driver is the recorded one, to the last bit, and what a
/// driver braked before is not added to what the reference brakes.
#[derive(Debug, Clone, Copy)]
struct Car {
    way: f64,
    speed: f64,
    acceleration: f64,
    /// What it lacks of the recorded car's speed (m/s) and way (m).
    slower: f64,
    behind: f64,
    fastest: f64,
    /// The speed that the reference driver would have without the recorded car's braking (m/s); `None` until it interferes.
    own: Option<f64>,
}

impl Car {
    fn new(recorded: &RecordedCar) -> Self {
        let RecordedCar { way, speed, acceleration } = *recorded;
        Self { way, speed, acceleration, slower: 0.0, behind: 0.0, fastest: speed, own: None }
    }

    /// Brakes (m/s²) for a step (s), at whose end the recorded car is `next`. A driver that interferes for the first time had noticed the
    /// pedestrian at this speed (m/s).
    fn brake(&mut self, braking: f64, noticed_at: f64, next: &RecordedCar, dt: f64) {
        let own = (self.own.unwrap_or(noticed_at) - braking * dt).max(0.0);
        self.own = Some(own);
        let (speed, way) = (self.speed, self.way);
        let before = self.slower;
        self.slower = (next.speed - own).max(0.0);
        self.speed = next.speed - self.slower;
        // A car that stops within the step moves for a part of it.
        let lost = (speed - self.speed) / dt;
        if self.speed <= 0.0 && speed > 0.0 {
            let moving = if braking > lost { speed / braking } else { dt };
            self.way = (way + speed / 2.0 * moving).min(next.way);
            self.behind = next.way - self.way;
        } else {
            self.behind += (before + self.slower) / 2.0 * dt;
            self.way = (next.way - self.behind).max(way);
        }
        self.acceleration = (self.speed - speed) / dt;
    }

    fn follow(&mut self, next: &RecordedCar) {
        (self.way, self.speed, self.acceleration) = (next.way, next.speed, next.acceleration);
        self.fastest = self.fastest.max(self.speed);
    }

    fn has_stopped(&self) -> bool {
        self.own.is_some() && self.speed <= STANDING
    }

    fn trial(&self, impact_speed: Option<f64>, time: f64, least_gap: f64) -> Trial {
        let moved = self.fastest > STANDING;
        let stopped = self.has_stopped();
        Trial { impact_speed, time, least_gap, moved, braked: self.own.is_some(), stopped }
    }
}

/// A car that no reference driver brakes, and what a driver at its brake would notice. All drivers share it until they interfere.
#[derive(Debug, Clone)]
pub(super) struct FreeRun {
    /// Its end.
    pub trial: Trial,
    /// The least gap up to each of its ticks (m).
    least_gaps: Vec<f64>,
}

/// Watches a trial from tick to tick.
pub(super) trait Watch {
    /// The start of a tick.
    fn tick(&mut self, _: &Seen) {}

    /// The driver interferes from this tick on. Up to it the trial is that of the car that no driver brakes.
    fn interferes(&mut self, _: usize) {}

    /// The touch that ends the trial, with the car as it is then.
    fn touch(&mut self, _: &Seen) {}

    /// Whether the trial goes on after the car has stopped or has passed the pedestrian, up to the end of the encounter. A pedestrian that then
    /// runs into its rear ends it without a touch.
    fn is_whole(&self) -> bool {
        false
    }
}

/// The car of a trial.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub outline: OrientedBox,
    /// Its speed (m/s).
    pub speed: f64,
    /// The least gap up to now (m).
    pub least_gap: f64,
}

/// A trial without a watcher.
struct Unwatched;

impl Watch for Unwatched {}

/// Keeps the least gaps of a free run.
struct LeastGaps<'a> {
    gaps: Vec<f64>,
    rest: &'a mut dyn Watch,
}

impl Watch for LeastGaps<'_> {
    fn tick(&mut self, seen: &Seen) {
        self.gaps.push(seen.least_gap);
        self.rest.tick(seen);
    }

    fn touch(&mut self, seen: &Seen) {
        self.rest.touch(seen);
    }

    fn is_whole(&self) -> bool {
        self.rest.is_whole()
    }
}

/// The instant at which a driver notices the pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Notice {
    /// From the start of the question (s).
    pub time: f64,
    /// Whether the car stands then.
    pub stands: bool,
}

/// A driver that never brakes.
struct Never;

impl ReferenceDriver for Never {
    fn begin(&mut self) {}

    fn has_noticed(&self) -> bool {
        false
    }

    fn brake(&mut self, _: &OwnMotion, _: Option<&Threat>, _: f64) -> Option<f64> {
        None
    }
}

impl FreeRun {
    pub(super) fn new(encounter: &mut Encounter<'_>) -> Self {
        Self::watched(encounter, &mut Unwatched)
    }

    /// The same, watched.
    pub(super) fn watched(encounter: &mut Encounter<'_>, watch: &mut dyn Watch) -> Self {
        let mut gaps = LeastGaps { gaps: Vec::new(), rest: watch };
        let trial = Trial::run(encounter, &mut Never, 0, None, &mut gaps);
        Self { trial, least_gaps: gaps.gaps }
    }

    /// When a driver notices the pedestrian; `None` if it does not before the end.
    pub(super) fn noticed(&self, encounter: &Encounter<'_>, driver: &DelayedBrake) -> Option<Notice> {
        let part = 1.0 / f64::from(STEPS);
        let length = 2.0 * encounter.half.x;
        (0..self.least_gaps.len()).find_map(|tick| {
            (0..STEPS).map(|step| f64::from(step) * part).find_map(|share| {
                let car = encounter.car(tick, share);
                let intended = encounter.intended(tick, share);
                let own = OwnMotion {
                    speed: car.speed,
                    acceleration: car.acceleration,
                    intended,
                    length,
                    brake: encounter.brake,
                };
                let threat = encounter.threat(tick, share, car.way)?;
                let notice = Notice { time: (tick as f64 + share) * encounter.dt, stands: own.stands() };
                driver.notices(&own, &threat).then_some(notice)
            })
        })
    }

    /// The trial of a driver that has this notice, if any.
    pub(super) fn braked(&self, encounter: &mut Encounter<'_>, driver: DelayedBrake, notice: Option<Notice>) -> Trial {
        self.braked_watched(encounter, driver, notice, &mut Unwatched)
    }

    /// The same, watched from the tick on in which the driver interferes.
    pub(super) fn braked_watched(
        &self,
        encounter: &mut Encounter<'_>,
        driver: DelayedBrake,
        notice: Option<Notice>,
        watch: &mut dyn Watch,
    ) -> Trial {
        let Some(notice) = notice else { return self.trial };
        // A driver that stands needs no reaction time: it does not drive off.
        let reacted = if notice.stands { driver.profile.wait } else { 0.0 };
        let first = ((notice.time + driver.profile.wait - reacted) / encounter.dt) as usize;
        let Some(least_gap) = self.least_gaps.get(first) else { return self.trial };
        let mut driver = driver.having_noticed(first as f64 * encounter.dt - notice.time + reacted);
        watch.interferes(first);
        Trial::run(encounter, &mut driver, first, Some(*least_gap), watch)
    }
}

impl Trial {
    /// Simulates an encounter with a reference driver.
    pub fn new(encounter: &mut Encounter<'_>, driver: &mut dyn ReferenceDriver) -> Self {
        Self::watched(encounter, driver, &mut Unwatched)
    }

    /// The same, watched.
    pub(super) fn watched(
        encounter: &mut Encounter<'_>,
        driver: &mut dyn ReferenceDriver,
        watch: &mut dyn Watch,
    ) -> Self {
        driver.begin();
        Self::run(encounter, driver, 0, None, watch)
    }

    /// Simulates an encounter from a tick on, up to which the driver has not interfered and the gap was at least this (m).
    fn run<D: ReferenceDriver + ?Sized>(
        encounter: &mut Encounter<'_>,
        driver: &mut D,
        first: usize,
        least_gap: Option<f64>,
        watch: &mut dyn Watch,
    ) -> Self {
        let (tick, part) = (encounter.dt, 1.0 / f64::from(STEPS));
        let dt = tick * part;
        let mut car = Car::new(&encounter.car(first, 0.0));
        let mut passed = 0;
        let mut outline = encounter.outline(car.way, &mut passed);
        let (half, radius) = (encounter.half, encounter.radius);
        let gap = |outline: &OrientedBox, place| (outline.distance_to(place) - radius).max(0.0);
        let far = half.norm() + radius;
        let mut least_gap = least_gap.unwrap_or_else(|| gap(&outline, encounter.steps[first].position));
        let mut number = first;
        while encounter.has_step(number + 1) {
            watch.tick(&Seen { outline, speed: car.speed, least_gap });
            let (from, to) = (encounter.steps[number].position, encounter.steps[number + 1].position);
            let chord = to - from;
            for step in 0..STEPS {
                let share = f64::from(step) * part;
                let time = (number as f64 + share) * tick;
                let next = encounter.car(number, share + part);
                let intended = if car.own.is_some() { 0.0 } else { encounter.intended(number, share) };
                let own = OwnMotion {
                    speed: car.speed,
                    acceleration: car.acceleration,
                    intended,
                    length: 2.0 * half.x,
                    brake: encounter.brake,
                };
                let threat = encounter.threat(number, share, car.way);
                let braking = driver.brake(&own, threat.as_ref(), dt);
                let stood = car.has_stopped();
                if car.own.is_some() || braking.is_some() {
                    let noticed_at = match car.own {
                        Some(_) => 0.0,
                        None => encounter.fastest_since(time - driver.noticed_for(), time),
                    };
                    car.brake(braking.unwrap_or(0.0).min(encounter.brake), noticed_at, &next, dt);
                } else {
                    car.follow(&next);
                }
                let is_over = threat.is_none() || (stood && car.has_stopped());
                if is_over && !watch.is_whole() {
                    return car.trial(None, time, least_gap);
                }
                let before = outline;
                outline = encounter.outline(car.way, &mut passed);
                let (start, end) = (from + chord * share, from + chord * (share + part));
                // The distance of the centres bounds the gap from below; most steps need no more.
                let moved = own.speed * dt + chord.norm() * part + TURNING;
                let reach = far + least_gap.max(moved);
                if (end - outline.pose.position()).norm_squared() > reach * reach {
                    continue;
                }
                let left = gap(&outline, end);
                least_gap = least_gap.min(left);
                if left > moved {
                    continue;
                }
                if let Some(touch) = first_touch(start, end, radius, &before, &outline) {
                    if threat.is_none() {
                        return car.trial(None, time, least_gap);
                    }
                    let impact = own.speed + (car.speed - own.speed) * touch.fraction;
                    watch.touch(&Seen { outline, speed: impact, least_gap: 0.0 });
                    let impact_speed = (impact > STANDING).then_some(impact);
                    return car.trial(impact_speed, time + touch.fraction * dt, 0.0);
                }
            }
            number += 1;
        }
        if watch.is_whole() {
            watch.tick(&Seen { outline, speed: car.speed, least_gap });
        }
        car.trial(None, number as f64 * tick, least_gap)
    }

    /// Whether the car did not touch the pedestrian while it moved.
    pub fn is_avoided(&self) -> bool {
        self.impact_speed.is_none()
    }
}
