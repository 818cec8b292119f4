use std::f64::consts::PI;

use super::{Observation, ObservedSpeed};
use crate::geometry::{Point, Pose, wrap_angle};
use crate::sim::{PedestrianBody, WalkCommand};

/// Where the angles of a state or an action are measured from. The paper says "the pedestrian's frame" and no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// The pedestrian's present heading, which turns with every command.
    Heading,
    /// The pedestrian's heading when the episode began.
    Initial,
    /// The line from the pedestrian to the ego.
    LineOfSight,
    /// The world's `+x`.
    World,
}

/// Whether the learner sees natural units or numbers of order one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// Radians, metres, metres per second.
    Natural,
    /// States divided by (π, 30 m, π, 8 m/s); actions in [−1, 1] over their whole range.
    Unit,
}

/// Where the pedestrian looks when an episode begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstHeading {
    /// Anywhere.
    Random,
    /// At the ego.
    TowardsEgo,
}

/// The pedestrian that attacks: its body, and how its states and actions are to be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Adversary {
    /// Size and gait.
    pub body: PedestrianBody,
    /// Least and greatest speed it can choose (m/s).
    pub speed: (f64, f64),
    /// Where the angles of the state are measured from.
    pub observation_frame: Frame,
    /// Where the chosen heading is measured from.
    pub action_frame: Frame,
    /// The units of the state.
    pub observation_scaling: Scaling,
    /// The units of the action.
    pub action_scaling: Scaling,
    /// What the fourth number of the state is.
    pub observed_speed: ObservedSpeed,
    /// Where it looks at first.
    pub first_heading: FirstHeading,
}

impl Adversary {
    /// The bounds of the learner's action: heading, then speed.
    pub fn action_bounds(&self) -> [(f64, f64); 2] {
        match self.action_scaling {
            Scaling::Natural => [(-PI, PI), self.speed],
            Scaling::Unit => [(-1.0, 1.0); 2],
        }
    }

    /// Turns a learner's action, within its bounds, into a command in the world.
    pub fn command(&self, action: [f64; 2], pedestrian: &Pose, initial_heading: f64, ego: Point) -> WalkCommand {
        let (low, high) = self.speed;
        let (angle, speed) = match self.action_scaling {
            Scaling::Natural => (action[0], action[1]),
            Scaling::Unit => (action[0] * PI, low + (action[1] + 1.0) / 2.0 * (high - low)),
        };
        let origin = origin(self.action_frame, pedestrian, initial_heading, ego);
        WalkCommand { heading: wrap_angle(origin + angle), speed: speed.clamp(low, high) }
    }

    /// The learner's action for a command in the world; the inverse of [`Adversary::command`].
    pub fn action_for(&self, command: WalkCommand, pedestrian: &Pose, initial_heading: f64, ego: Point) -> [f64; 2] {
        let (low, high) = self.speed;
        let angle = wrap_angle(command.heading - origin(self.action_frame, pedestrian, initial_heading, ego));
        match self.action_scaling {
            Scaling::Natural => [angle, command.speed],
            Scaling::Unit => [angle / PI, (command.speed - low) / (high - low).max(f64::MIN_POSITIVE) * 2.0 - 1.0],
        }
    }

    /// What the learner is given for an observation in the pedestrian's heading frame.
    pub fn encode(&self, seen: &Observation, pedestrian: &Pose, initial_heading: f64, ego: Point) -> [f64; 4] {
        let turn = wrap_angle(pedestrian.yaw - origin(self.observation_frame, pedestrian, initial_heading, ego));
        // On the line of sight the bearing is always 0; the pedestrian's own heading takes its place.
        let first = match self.observation_frame {
            Frame::LineOfSight => turn,
            _ => wrap_angle(seen.bearing + turn),
        };
        let state = [first, seen.distance, wrap_angle(seen.relative_heading + turn), seen.speed];
        match self.observation_scaling {
            Scaling::Natural => state,
            Scaling::Unit => [state[0] / PI, state[1] / 30.0, state[2] / PI, state[3] / 8.0],
        }
    }
}

fn origin(frame: Frame, pedestrian: &Pose, initial_heading: f64, ego: Point) -> f64 {
    match frame {
        Frame::Heading => pedestrian.yaw,
        Frame::Initial => initial_heading,
        Frame::LineOfSight => libm::atan2(ego.y - pedestrian.y, ego.x - pedestrian.x),
        Frame::World => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adversary(frame: Frame, scaling: Scaling) -> Adversary {
        Adversary {
            body: PedestrianBody::adult(),
            speed: (0.0, 3.5),
            observation_frame: frame,
            action_frame: frame,
            observation_scaling: scaling,
            action_scaling: scaling,
            observed_speed: ObservedSpeed::Ego,
            first_heading: FirstHeading::Random,
        }
    }

    #[test]
    fn commands_and_actions_are_inverse_in_every_frame() {
        let (pose, ego) = (Pose::new(3.0, 4.0, 2.5), Point::new(-5.0, 1.0));
        for frame in [Frame::Heading, Frame::Initial, Frame::LineOfSight, Frame::World] {
            for scaling in [Scaling::Natural, Scaling::Unit] {
                let adversary = adversary(frame, scaling);
                let command = WalkCommand { heading: -1.2, speed: 2.0 };
                let action = adversary.action_for(command, &pose, 0.3, ego);
                let back = adversary.command(action, &pose, 0.3, ego);
                assert!((back.heading - command.heading).abs() < 1e-12 && (back.speed - command.speed).abs() < 1e-12);
                let bounds = adversary.action_bounds();
                assert!((0..2).all(|i| action[i] >= bounds[i].0 && action[i] <= bounds[i].1));
            }
        }
    }

    #[test]
    fn walking_at_the_bearing_of_the_state_leads_to_the_ego() {
        let (pose, ego) = (Pose::new(3.0, 4.0, 2.5), Pose::new(-5.0, 1.0, 0.2));
        for frame in [Frame::Heading, Frame::Initial, Frame::World] {
            let adversary = adversary(frame, Scaling::Natural);
            let seen = Observation::new(&pose, 0.0, &ego, 5.0, ObservedSpeed::Ego);
            let state = adversary.encode(&seen, &pose, 0.3, ego.position());
            let command = adversary.command([state[0], 1.0], &pose, 0.3, ego.position());
            let towards = libm::atan2(ego.y - pose.y, ego.x - pose.x);
            assert!(wrap_angle(command.heading - towards).abs() < 1e-12, "{frame:?}");
        }
    }
}
