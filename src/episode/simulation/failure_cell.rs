use super::requirement_watch::Moment;
use crate::{Frame, Outcome, Pair, Scene};
use base::choice;
use road::geometry::{Vector, wrap_angle};
use world::av::DrivingMode;
use world::sim::{Contact, VehicleBlueprint};

/// Width of a class of impact speeds (m/s), and of walking speeds (m/s).
const IMPACT: f64 = 2.0;
const PACE: f64 = 0.5;
/// The last class of a speed is open.
const LAST: u8 = 7;

choice! {
    /// Where on the ego a pedestrian touched it.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
    pub enum Zone {
        /// The left third of the front.
        FrontLeft = "front_left",
        /// The middle third of the front.
        FrontMiddle = "front_middle",
        /// The right third of the front.
        FrontRight = "front_right",
        /// The left side, ahead of the middle of the car.
        LeftAhead = "left_ahead",
        /// The left side, behind the middle of the car.
        LeftBehind = "left_behind",
        /// The right side, ahead of the middle of the car.
        RightAhead = "right_ahead",
        /// The right side, behind the middle of the car.
        RightBehind = "right_behind",
        Rear = "rear",
    }
}

choice! {
    /// The direction of a pedestrian's motion relative to the ego's heading, in sectors of 45°.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
    pub enum Course {
        /// It stood.
        Standing = "standing",
        /// With the ego.
        Along = "along",
        /// With the ego and to its left.
        AlongLeft = "along_left",
        /// Across, to the ego's left.
        Left = "left",
        /// Towards the ego and to its left.
        AgainstLeft = "against_left",
        /// Towards the ego.
        Against = "against",
        /// Towards the ego and to its right.
        AgainstRight = "against_right",
        /// Across, to the ego's right.
        Right = "right",
        /// With the ego and to its right.
        AlongRight = "along_right",
    }
}

/// The class of a failure in a grid over behaviours: two failures in one cell count as the same finding.
///
/// A search for *distinct* failures fills cells, as the archive of a quality-diversity method does. The cell says how the two met, not where
/// in the town.
///
/// # Source
/// Mouret and Clune, *Illuminating search spaces by mapping elites*, arXiv 1504.04909.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct FailureCell {
    /// The place on the car.
    pub zone: Zone,
    /// The direction in which the pedestrian walked.
    pub course: Course,
    /// Class of the impact speed: number of steps of 2 m/s below it.
    pub impact: u8,
    /// Class of the walking speed: number of steps of 0.5 m/s below it.
    pub pace: u8,
    /// The driver's action at the touch.
    pub mode: DrivingMode,
    /// The pedestrian's role in the cast, by the number of its first member.
    #[serde(default, skip_serializing_if = "is_first")]
    pub role: u8,
}

fn is_first(role: &u8) -> bool {
    *role == 0
}

impl FailureCell {
    /// The cell of the touch that ended an episode, or of the moment that violates its goal; `None` if the ego and a pedestrian did not touch, or the
    /// goal is not violated, and if the episode does not count.
    pub(super) fn new(scene: &Scene<'_>, outcome: &Outcome, moment: Option<&Moment>) -> Option<Self> {
        if !outcome.counts() {
            return None;
        }
        let ego = scene.world.ego();
        if scene.scenario.criterion.requirement().is_some() {
            let moment = moment?;
            let met = ((moment.place.x, moment.place.y), moment.speed);
            let role = scene.scenario.cast.role(moment.pedestrian);
            return Some(Self::of(met, (&ego.blueprint, moment.yaw), moment.velocity, moment.mode, role));
        }
        let contact = scene.hit()?;
        let number = contact.pedestrian_at_ego()?;
        let (walker, role) = (&scene.world.pedestrians[number].state, scene.scenario.cast.role(number));
        let car = (&ego.blueprint, ego.state.pose.yaw);
        Some(Self::of(met(contact), car, walker.velocity, outcome.last_mode, role))
    }

    /// The cell of the touch that ended a traced episode with this mode of the driver, or of the frame that violates its goal; `None` if the two did not
    /// touch, or the goal is not violated.
    pub fn of_pair(pair: &Pair<'_>, mode: DrivingMode) -> Option<Self> {
        let role = pair.scenario.cast.role(pair.pedestrian_number());
        if let Some(goal) = pair.scenario.criterion.requirement() {
            let degree = pair.degrees().get(goal).filter(|degree| degree.is_violated())?;
            let Frame { ego, pedestrian, mode, .. } = pair.frame(degree.sample as usize);
            let place = ego.pose.to_local(pedestrian.pose.position());
            let met = ((place.x, place.y), ego.speed);
            return Some(Self::of(met, (pair.blueprint, ego.pose.yaw), pedestrian.velocity, mode, role));
        }
        let (contact, last) = (pair.contact?, pair.last()?);
        Some(Self::of(met(contact), (pair.blueprint, last.ego.pose.yaw), last.pedestrian.velocity, mode, role))
    }

    /// The cell of a pedestrian at this place, ahead and to the left of the middle of the ego (m), of this velocity (m/s), and of the ego of this speed
    /// (m/s) and heading (rad).
    fn of(
        ((ahead, aside), impact_speed): ((f64, f64), f64),
        (car, yaw): (&VehicleBlueprint, f64),
        velocity: Vector,
        mode: DrivingMode,
        role: u8,
    ) -> Self {
        let (half_length, half_width) = (car.half_length, car.half_width);
        let side = |front, behind| if ahead > 0.0 { front } else { behind };
        let zone = if ahead > half_length - (aside.abs() - half_width).max(0.0) {
            match aside / half_width {
                share if share > 1.0 / 3.0 => Zone::FrontLeft,
                share if share < -1.0 / 3.0 => Zone::FrontRight,
                _ => Zone::FrontMiddle,
            }
        } else if ahead < -half_length {
            Zone::Rear
        } else if aside > 0.0 {
            side(Zone::LeftAhead, Zone::LeftBehind)
        } else {
            side(Zone::RightAhead, Zone::RightBehind)
        };
        let (heading, speed) = (libm::atan2(velocity.y, velocity.x), velocity.norm());
        let class = |speed: f64, width: f64| ((speed / width) as u8).min(LAST);
        Self {
            zone,
            course: Course::new(speed, wrap_angle(heading - yaw)),
            impact: class(impact_speed, IMPACT),
            pace: class(speed, PACE),
            mode,
            role,
        }
    }
}

/// Where two touched, and the speed of the ego.
fn met(contact: &Contact) -> ((f64, f64), f64) {
    ((contact.ahead, contact.aside), contact.impact_speed)
}

impl Course {
    /// The course for a speed (m/s) and a direction from the ego's heading, positive to the left (rad).
    fn new(speed: f64, direction: f64) -> Self {
        const STANDING: f64 = 0.1;
        const SECTORS: [Course; 8] = [
            Course::Along,
            Course::AlongLeft,
            Course::Left,
            Course::AgainstLeft,
            Course::Against,
            Course::AgainstRight,
            Course::Right,
            Course::AlongRight,
        ];
        if speed < STANDING {
            return Self::Standing;
        }
        let sector = (direction / std::f64::consts::FRAC_PI_4).round() as i32;
        SECTORS[sector.rem_euclid(8) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn courses_are_sectors_about_the_egos_heading() {
        for (degrees, wanted) in [
            (0.0, Course::Along),
            (22.0, Course::Along),
            (23.0, Course::AlongLeft),
            (90.0, Course::Left),
            (-90.0, Course::Right),
            (180.0, Course::Against),
            (-179.0, Course::Against),
            (-140.0, Course::AgainstRight),
        ] {
            assert_eq!(Course::new(1.0, degrees * PI / 180.0), wanted, "{degrees}");
        }
        assert_eq!(Course::new(0.05, 1.0), Course::Standing);
    }
}
