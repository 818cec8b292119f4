use super::Encounter;
use crate::av::reference_drivers::{OwnMotion, ReferenceDriver};
use crate::geometry::{OrientedBox, first_touch};

/// Number of steps of a tick: reference drivers react in hundredths of a second.
const STEPS: u32 = 5;
/// An upper bound of the distance (m) that the rotation of the car moves a corner of it within a step.
const TURNING: f64 = 0.05;
/// Below this speed (m/s) the car stands.
pub(super) const STANDING: f64 = 0.1;

/// The result of a reference driver in an encounter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Speed at which the car touched the pedestrian (m/s); none when it avoided the touch.
    pub impact_speed: Option<f64>,
    /// Time from the start of the danger to that touch; without one, until the car had stopped or passed, or the time limit (s).
    pub time: f64,
    /// Least gap between car and pedestrian until the car stood (m); 0 at a touch.
    pub least_gap: f64,
}

/// The car, driven by the reference driver.
#[derive(Debug, Clone, Copy)]
struct Car {
    way: f64,
    speed: f64,
    acceleration: f64,
    interfered: bool,
}

impl Car {
    /// Simulates one step of a tick of `tick` (s): with the driver's braking, or towards the recorded speed at the end of the tick.
    fn advance(&mut self, braking: Option<f64>, pace: Option<f64>, dt: f64, tick: f64) {
        self.interfered |= braking.is_some();
        let braking = braking.unwrap_or(0.0);
        if !self.interfered {
            // As in the simulator: the car keeps the tick's first speed until the tick's end.
            self.way += self.speed * dt;
            if let Some(pace) = pace {
                self.acceleration = (pace - self.speed).max(0.0) / tick;
                self.speed = self.speed.max(pace);
            }
            return;
        }
        let next = (self.speed - braking * dt).max(0.0);
        // A car that stops within the step moves for a part of it.
        let moving = if next == 0.0 && braking > 0.0 { (self.speed / braking).min(dt) } else { dt };
        self.way += (self.speed + next) / 2.0 * moving;
        (self.speed, self.acceleration) = (next, -braking);
    }

    fn has_stopped(&self) -> bool {
        self.interfered && self.speed <= STANDING
    }
}

impl Trial {
    /// Simulates an encounter with a reference driver.
    pub fn new(encounter: &Encounter, driver: &mut dyn ReferenceDriver) -> Self {
        driver.begin();
        let (tick, part) = (encounter.dt, 1.0 / f64::from(STEPS));
        let dt = tick * part;
        let mut car = Car { way: encounter.start, speed: encounter.pace[0], acceleration: 0.0, interfered: false };
        let mut outline = encounter.outline(car.way);
        let gap = |outline: &OrientedBox, place| (outline.distance_to(place) - encounter.radius).max(0.0);
        let far = encounter.half.norm() + encounter.radius;
        let mut least_gap = gap(&outline, encounter.steps[0].position);
        for (number, pair) in encounter.steps.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            let chord = to.position - from.position;
            for step in 0..STEPS {
                let share = f64::from(step) * part;
                let time = (number as f64 + share) * tick;
                let own =
                    OwnMotion { speed: car.speed, acceleration: car.acceleration, length: 2.0 * encounter.half.x };
                let threat = encounter.threat(from, to, share, car.way);
                let braking = driver.brake(&own, threat.as_ref(), dt);
                let pace = encounter.pace.get(number + 1).filter(|_| step + 1 == STEPS);
                let stood = car.has_stopped();
                car.advance(braking, pace.copied(), dt, tick);
                if threat.is_none() || (stood && car.has_stopped()) {
                    return Self { impact_speed: None, time, least_gap };
                }
                let before = outline;
                outline = encounter.outline(car.way);
                let (start, end) = (from.position + chord * share, from.position + chord * (share + part));
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
                if let Some(touch) = first_touch(start, end, encounter.radius, &before, &outline) {
                    let impact = own.speed + (car.speed - own.speed) * touch.fraction;
                    let impact_speed = (impact > STANDING).then_some(impact);
                    return Self { impact_speed, time: time + touch.fraction * dt, least_gap: 0.0 };
                }
            }
        }
        Self { impact_speed: None, time: (encounter.steps.len() - 1) as f64 * tick, least_gap }
    }

    /// Whether the car did not touch the pedestrian while it moved.
    pub fn is_avoided(&self) -> bool {
        self.impact_speed.is_none()
    }
}
