use std::f64::consts::PI;

use crate::{Destination, ReferenceFrame, Scaling};
use road::geometry::wrap_angle;
use world::sim::WalkCommand;

/// Converts the numbers of an action to a command of a pedestrian: heading, then speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionSpec {
    /// Least and greatest speed that can be chosen (m/s).
    pub speed: (f64, f64),
    /// Least and greatest heading that can be chosen, from the direction of the frame (rad).
    pub heading: (f64, f64),
    /// The direction from which the chosen heading is measured.
    pub frame: ReferenceFrame,
    /// Where it walks to in the frame of that name; without a place it crosses the road.
    pub destination: Option<Destination>,
    /// The units of the action.
    pub scaling: Scaling,
}

impl ActionSpec {
    /// The numbers of an action.
    pub const DIM: usize = 2;

    pub const ANY_HEADING: (f64, f64) = (-PI, PI);

    /// Whether every heading can be chosen.
    pub fn is_any_heading(&self) -> bool {
        self.heading == Self::ANY_HEADING
    }

    /// The middle of the headings, and half of their extent (rad).
    fn headings(&self) -> (f64, f64) {
        let (low, high) = self.heading;
        ((low + high) / 2.0, ((high - low) / 2.0).max(f64::MIN_POSITIVE))
    }

    /// The bounds of an action: heading, then speed.
    pub fn bounds(&self) -> [(f64, f64); Self::DIM] {
        match self.scaling {
            Scaling::Natural => [self.heading, self.speed],
            Scaling::Unit => [(-1.0, 1.0); Self::DIM],
        }
    }

    /// Converts an action, within its bounds, to a command in the world. `origin` is the direction of heading 0 in the world (rad) at a
    /// chosen speed (m/s).
    pub fn command(&self, action: [f64; Self::DIM], origin: impl FnOnce(f64) -> f64) -> WalkCommand {
        let (low, high) = self.speed;
        let (middle, half) = self.headings();
        let (angle, speed) = match self.scaling {
            Scaling::Natural => (action[0], action[1]),
            Scaling::Unit => (middle + action[0] * half, low + (action[1] + 1.0) / 2.0 * (high - low)),
        };
        let speed = speed.clamp(low, high);
        let angle = if self.is_any_heading() { angle } else { angle.clamp(self.heading.0, self.heading.1) };
        WalkCommand { heading: wrap_angle(origin(speed) + angle), speed }
    }

    /// The action for a command in the world; the inverse of [`ActionSpec::command`].
    pub fn action_for(&self, command: WalkCommand, origin: impl FnOnce(f64) -> f64) -> [f64; Self::DIM] {
        let (low, high) = self.speed;
        let (middle, half) = self.headings();
        let angle = wrap_angle(command.heading - origin(command.speed));
        match self.scaling {
            Scaling::Natural => [angle, command.speed],
            Scaling::Unit => {
                [(angle - middle) / half, (command.speed - low) / (high - low).max(f64::MIN_POSITIVE) * 2.0 - 1.0]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use road::geometry::{Point, Pose};

    #[test]
    fn commands_and_actions_are_inverse_in_every_frame() {
        let (pose, ego) = (Pose::new(3.0, 4.0, 2.5), Point::new(-5.0, 1.0));
        use ReferenceFrame::{Heading, Initial, LineOfSight, World};
        for frame in [Heading, Initial, LineOfSight, World] {
            for scaling in [Scaling::Natural, Scaling::Unit] {
                let spec = ActionSpec {
                    speed: (0.0, 3.5),
                    heading: ActionSpec::ANY_HEADING,
                    frame,
                    destination: None,
                    scaling,
                };
                let command = WalkCommand { heading: -1.2, speed: 2.0 };
                let origin = |_: f64| frame.origin(&pose, 0.3, ego);
                let action = spec.action_for(command, origin);
                let back = spec.command(action, origin);
                assert!((back.heading - command.heading).abs() < 1e-12 && (back.speed - command.speed).abs() < 1e-12);
                for (number, (low, high)) in action.into_iter().zip(spec.bounds()) {
                    assert!(number >= low && number <= high);
                }
            }
        }
    }

    #[test]
    fn a_limited_heading_is_never_left() {
        let natural = ActionSpec {
            speed: (0.8, 2.2),
            heading: (-0.35, 0.25),
            frame: ReferenceFrame::Initial,
            destination: None,
            scaling: Scaling::Natural,
        };
        for (number, scaling) in [(5.0, Scaling::Natural), (1.0, Scaling::Unit)] {
            let spec = ActionSpec { scaling, ..natural.clone() };
            let headings = [-number, number].map(|number| spec.command([number, 0.0], |_| 1.0).heading - 1.0);
            assert!((headings[0] + 0.35).abs() < 1e-12 && (headings[1] - 0.25).abs() < 1e-12, "{headings:?}");
        }
    }
}
