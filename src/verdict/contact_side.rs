use episode::Pair;
use road::geometry::Vector;

use super::PedestrianMotion;
use super::encounter::STANDING;
use base::choice;

choice! {
    /// The part of the car that touched the pedestrian, by the place of the pedestrian's middle in the frame of the car.
    ///
    /// It is a fact beside the verdict. The paper's front sector (`front`) is another one: it reaches along the flanks.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum ContactSide {
        /// In front of the line of the bumper.
        Front = "front",
        /// Beside the car, behind the line of the bumper.
        Side = "side",
        /// Behind the line of the rear.
        Rear = "rear",
    }
}

impl ContactSide {
    /// The same side of a car whose front was taken for its rear.
    pub(super) fn turned_round(self) -> Self {
        match self {
            Self::Front => Self::Rear,
            Self::Side => Self::Side,
            Self::Rear => Self::Front,
        }
    }

    /// The side on which a point is, `ahead` and to the left (`aside`) of the middle of a car with these half extents (m).
    pub(super) fn new(ahead: f64, aside: f64, half: Vector) -> Self {
        if ahead < -half.x {
            Self::Rear
        } else if ahead < half.x && aside.abs() > half.y {
            Self::Side
        } else {
            Self::Front
        }
    }
}

/// A steady pedestrian that is touched at most this far behind the bumper (m), and at most this time (s) after the bumper has passed, did not walk into
/// the flank. It kept its velocity in the last three seconds, and a little later the front would have hit it: the driver crossed its way. Our choice: the
/// gate's margin beside the path, and its time to spare, so that a car that has slowed down is not blamed for it.
const CORNER: (f64, f64) = (0.5, 0.1);

/// The side of the recorded touch, and whether the pedestrian walked into the flank or ran into the rear, after the front had passed it.
pub(super) fn touched(pair: &Pair<'_>, motion: &PedestrianMotion) -> Option<(ContactSide, bool)> {
    let (contact, last, blueprint) = (pair.contact?, pair.last()?, pair.blueprint);
    let side = ContactSide::new(contact.ahead, contact.aside, Vector::new(blueprint.half_length, blueprint.half_width));
    let closes = |direction: Vector| last.pedestrian.velocity.dot(&direction) > STANDING;
    // The way from the pedestrian to the nearest corner or edge of the rear.
    let beside = contact.aside - contact.aside.clamp(-blueprint.half_width, blueprint.half_width);
    let (forward, left) = (last.ego.pose.forward(), last.ego.pose.left());
    let to_rear = forward * (-blueprint.half_length - contact.ahead) - left * beside;
    let behind = blueprint.half_length - contact.ahead;
    let at_corner = behind <= CORNER.0.min(contact.impact_speed * CORNER.1);
    let walked = match side {
        ContactSide::Front => false,
        ContactSide::Side => closes(-left * contact.aside.signum()) && !(at_corner && motion.is_steady()),
        // A car that reverses meets with its rear as with its front.
        ContactSide::Rear if last.ego.speed < 0.0 => closes(forward),
        ContactSide::Rear => closes(to_rear.try_normalize(1e-9).unwrap_or(forward)),
    };
    Some((side, walked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touch_is_at_the_side_once_the_bumper_has_passed_the_middle_of_the_pedestrian() {
        let half = Vector::new(2.2, 0.9);
        for (ahead, aside, side) in [
            (2.4, 0.0, ContactSide::Front),
            (2.21, 1.1, ContactSide::Front),
            (2.19, 1.1, ContactSide::Side),
            (-2.19, -1.1, ContactSide::Side),
            (-2.21, -1.1, ContactSide::Rear),
            (-2.4, 0.0, ContactSide::Rear),
        ] {
            assert_eq!(ContactSide::new(ahead, aside, half), side, "{ahead}, {aside}");
        }
    }
}
