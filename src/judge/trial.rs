use super::Encounter;
use crate::av::reference_drivers::{DelayedBrake, OwnMotion, ReferenceDriver, Threat};
use crate::geometry::{OrientedBox, first_touch};

/// Number of steps of a tick: reference drivers react in hundredths of a second.
const STEPS: u32 = 5;
/// An upper bound of the distance (m) that the rotation of the car moves a corner of it within a step.
const TURNING: f64 = 0.05;
/// Below this speed (m/s) the car stands.
pub(super) const STANDING: f64 = 0.1;

/// The result of a reference driver in an encounter.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trial {
    /// Speed at which the car touched the pedestrian (m/s); none when it avoided the touch.
    pub impact_speed: Option<f64>,
    /// Time from the start of the danger to that touch; without one, until the car had stopped or passed, or the time limit (s).
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

/// The car, driven by the reference driver.
#[derive(Debug, Clone, Copy)]
struct Car {
    way: f64,
    speed: f64,
    acceleration: f64,
    fastest: f64,
    interfered: bool,
}

impl Car {
    /// Simulates one step (s) of braking.
    fn brake(&mut self, braking: f64, dt: f64) {
        self.interfered = true;
        let next = (self.speed - braking * dt).max(0.0);
        // A car that stops within the step moves for a part of it.
        let moving = if next == 0.0 && braking > 0.0 { (self.speed / braking).min(dt) } else { dt };
        self.way += (self.speed + next) / 2.0 * moving;
        (self.speed, self.acceleration) = (next, -braking);
    }

    fn has_stopped(&self) -> bool {
        self.interfered && self.speed <= STANDING
    }

    fn trial(&self, impact_speed: Option<f64>, time: f64, least_gap: f64) -> Trial {
        let (moved, stopped) = (self.fastest > STANDING, self.has_stopped());
        Trial { impact_speed, time, least_gap, moved, braked: self.interfered, stopped }
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

/// A driver that never brakes.
struct Never;

impl ReferenceDriver for Never {
    fn begin(&mut self) {}

    fn brake(&mut self, _: &OwnMotion, _: Option<&Threat>, _: f64) -> Option<f64> {
        None
    }
}

impl FreeRun {
    pub(super) fn new(encounter: &mut Encounter<'_>) -> Self {
        let mut least_gaps = Vec::new();
        let trial = Trial::run(encounter, &mut Never, 0, None, &mut |gap| least_gaps.push(gap));
        Self { trial, least_gaps }
    }

    /// The time (s) from the start of the danger at which a driver notices the pedestrian; none when it does not before the end.
    pub(super) fn noticed(&self, encounter: &Encounter<'_>, driver: &DelayedBrake) -> Option<f64> {
        let part = 1.0 / f64::from(STEPS);
        (0..self.least_gaps.len()).find_map(|tick| {
            let (speed, length) = (encounter.pace_at(tick), 2.0 * encounter.half.x);
            (0..STEPS).map(|step| f64::from(step) * part).find_map(|share| {
                let intended = encounter.intended(tick, share);
                let own = OwnMotion { speed, acceleration: encounter.acceleration(tick), intended, length };
                let threat = encounter.threat(tick, share, encounter.way_at(tick, share))?;
                driver.notices(&own, &threat).then_some((tick as f64 + share) * encounter.dt)
            })
        })
    }

    /// The trial of a driver that noticed the pedestrian at this time (s), if it did.
    pub(super) fn braked(&self, encounter: &mut Encounter<'_>, driver: DelayedBrake, noticed: Option<f64>) -> Trial {
        let Some(noticed) = noticed else { return self.trial };
        let first = ((noticed + driver.profile.wait) / encounter.dt) as usize;
        let Some(least_gap) = self.least_gaps.get(first) else { return self.trial };
        let mut driver = driver.having_noticed(first as f64 * encounter.dt - noticed);
        Trial::run(encounter, &mut driver, first, Some(*least_gap), &mut |_| ())
    }
}

impl Trial {
    /// Simulates an encounter with a reference driver.
    pub fn new(encounter: &mut Encounter<'_>, driver: &mut dyn ReferenceDriver) -> Self {
        driver.begin();
        Self::run(encounter, driver, 0, None, &mut |_| ())
    }

    /// Simulates an encounter from a tick on, up to which the driver has not interfered and the gap was at least this (m). `ticked` gets the
    /// least gap up to each tick.
    fn run<D: ReferenceDriver + ?Sized>(
        encounter: &mut Encounter<'_>,
        driver: &mut D,
        first: usize,
        least_gap: Option<f64>,
        ticked: &mut dyn FnMut(f64),
    ) -> Self {
        let (tick, part) = (encounter.dt, 1.0 / f64::from(STEPS));
        let dt = tick * part;
        let speed = encounter.pace_at(first);
        let way = encounter.way_at(first, 0.0);
        let mut car = Car { way, speed, acceleration: 0.0, fastest: speed, interfered: false };
        let mut outline = encounter.outline(way);
        let (half, radius) = (encounter.half, encounter.radius);
        let gap = |outline: &OrientedBox, place| (outline.distance_to(place) - radius).max(0.0);
        let far = half.norm() + radius;
        let mut least_gap = least_gap.unwrap_or_else(|| gap(&outline, encounter.steps[first].position));
        let mut number = first;
        while encounter.has_step(number + 1) {
            ticked(least_gap);
            let (from, to) = (encounter.steps[number].position, encounter.steps[number + 1].position);
            let chord = to - from;
            for step in 0..STEPS {
                let share = f64::from(step) * part;
                let time = (number as f64 + share) * tick;
                let intended = if car.interfered { 0.0 } else { encounter.intended(number, share) };
                let acceleration = if car.interfered { car.acceleration } else { encounter.acceleration(number) };
                let own = OwnMotion { speed: car.speed, acceleration, intended, length: 2.0 * half.x };
                let threat = encounter.threat(number, share, car.way);
                let braking = driver.brake(&own, threat.as_ref(), dt);
                let stood = car.has_stopped();
                if car.interfered || braking.is_some() {
                    car.brake(braking.unwrap_or(0.0).min(encounter.grip), dt);
                } else {
                    // As in the simulator: the car keeps the tick's first speed until the tick's end.
                    car.way = encounter.way_at(number, share + part);
                    if step + 1 == STEPS {
                        car.speed = encounter.pace_at(number + 1);
                        car.fastest = car.fastest.max(car.speed);
                    }
                }
                if threat.is_none() || (stood && car.has_stopped()) {
                    return car.trial(None, time, least_gap);
                }
                let before = outline;
                outline = encounter.outline(car.way);
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
                    let impact = own.speed + (car.speed - own.speed) * touch.fraction;
                    let impact_speed = (impact > STANDING).then_some(impact);
                    return car.trial(impact_speed, time + touch.fraction * dt, 0.0);
                }
            }
            number += 1;
        }
        car.trial(None, number as f64 * tick, least_gap)
    }

    /// Whether the car did not touch the pedestrian while it moved.
    pub fn is_avoided(&self) -> bool {
        self.impact_speed.is_none()
    }
}
