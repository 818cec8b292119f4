use super::Encounter;
use crate::av::reference_drivers::{OwnMotion, ReferenceDriver};
use crate::geometry::first_touch;

/// Steps that a tick is driven in: reference drivers react in hundredths of a second.
const STEPS: u32 = 5;
/// Slower than this (m/s) the car stands.
pub(super) const STANDING: f64 = 0.1;

/// How a reference driver fared in an encounter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Speed at which the car touched the pedestrian (m/s); none when it avoided that.
    pub impact_speed: Option<f64>,
    /// Time from the beginning of the danger to that touch, or to when the driver had stopped or time was up (s).
    pub time: f64,
    /// Least gap between car and pedestrian until the car stood (m); 0 at a touch.
    pub least_gap: f64,
}

impl Trial {
    /// Puts a driver into the seat.
    pub fn new(encounter: &Encounter, driver: &mut dyn ReferenceDriver) -> Self {
        driver.begin();
        let dt = encounter.dt / f64::from(STEPS);
        let (mut way, mut speed, mut acceleration) = (encounter.start, encounter.pace[0], 0.0);
        let mut interfered = false;
        let mut outline = encounter.outline(way);
        let mut least_gap = (outline.distance_to(encounter.steps[0].position) - encounter.radius).max(0.0);
        for (tick, pair) in encounter.steps.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            let aim = *encounter.pace.get(tick + 1).unwrap_or(&speed);
            let chord = to.position - from.position;
            for step in 0..STEPS {
                let share = f64::from(step) / f64::from(STEPS);
                let own = OwnMotion { speed, acceleration, length: 2.0 * encounter.half.x };
                let threat = encounter.threat(from, to, share, way);
                let braking = driver.brake(&own, threat.as_ref(), dt);
                interfered |= braking.is_some();
                let next = match braking {
                    Some(braking) => (speed - braking * dt).max(0.0),
                    None if interfered => speed,
                    // As the simulator moves a car: with the tick's first speed, to the next one at its end.
                    None if step + 1 == STEPS => speed.max(aim),
                    None => speed,
                };
                acceleration = (next - speed) / dt;
                // A car that stops within the step does not use all of it.
                let moving = braking.filter(|_| next == 0.0).map_or(dt, |braking| (speed / braking.max(1e-9)).min(dt));
                let before = (way, outline, speed);
                way += if interfered { (speed + next) / 2.0 * moving } else { speed * dt };
                speed = next;
                let (start, end) =
                    (from.position + chord * share, from.position + chord * (share + 1.0 / f64::from(STEPS)));
                if before.2 <= STANDING && speed <= STANDING && interfered {
                    let time = (tick as f64 + share) * encounter.dt;
                    return Self { impact_speed: None, time, least_gap };
                }
                outline = encounter.outline(way);
                if let Some(touch) = first_touch(start, end, encounter.radius, &before.1, &outline) {
                    let impact = before.2 + (speed - before.2) * touch.fraction;
                    let time = (tick as f64 + share) * encounter.dt + touch.fraction * dt;
                    return Self { impact_speed: (impact > STANDING).then_some(impact), time, least_gap: 0.0 };
                }
                least_gap = least_gap.min((outline.distance_to(end) - encounter.radius).max(0.0));
            }
        }
        Self { impact_speed: None, time: (encounter.steps.len() - 1) as f64 * encounter.dt, least_gap }
    }

    /// Whether the car touched nobody while it moved.
    pub fn is_avoided(&self) -> bool {
        self.impact_speed.is_none()
    }
}
