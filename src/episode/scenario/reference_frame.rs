use base::choice;
use road::geometry::{Point, Pose};

choice! {
    /// The direction from which the angles of a state or an action are measured. The paper says only "the pedestrian's frame".
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ReferenceFrame {
        /// The pedestrian's present heading, which turns with every command.
        Heading = "heading",
        /// The pedestrian's heading at the start of the episode.
        Initial = "initial",
        /// The line from the pedestrian to the ego.
        LineOfSight = "line_of_sight",
        /// The world's `+x`.
        World = "world",
        /// The direction in which the pedestrian would meet the middle of the ego's bumper at the speed that it chooses, if the ego kept its
        /// velocity. Only actions have it: what a trained pedestrian chooses is a correction of an intercepting pedestrian.
        Meeting = "meeting",
        /// The line from the pedestrian to its `destination`, or straight across the way of the car as it was at the start. Only actions have it: what
        /// a pedestrian chooses is a correction of its walk.
        Destination = "destination",
    }
}

impl ReferenceFrame {
    /// The direction of angle 0, for people.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Heading => "the pedestrian's present heading",
            Self::Initial => "the pedestrian's heading at the start of the episode",
            Self::LineOfSight => "the line from the pedestrian to the middle of the car",
            Self::World => "the world's x axis, which points east",
            Self::Destination => {
                "the line from the pedestrian to its `destination`; without one, straight across the way of the car at the start"
            }
            Self::Meeting => {
                "the direction in which the pedestrian meets the middle of the car's bumper at the chosen speed, if the car keeps its velocity"
            }
        }
    }

    /// The direction from which angles are measured, in the world (rad), for a pedestrian that had this heading (rad) at the start.
    pub(crate) fn origin(self, pedestrian: &Pose, initial_heading: f64, ego: Point) -> f64 {
        match self {
            Self::Heading => pedestrian.yaw,
            Self::Initial => initial_heading,
            Self::LineOfSight => libm::atan2(ego.y - pedestrian.y, ego.x - pedestrian.x),
            Self::World => 0.0,
            Self::Meeting | Self::Destination => unreachable!("checked: only actions are measured from there"),
        }
    }
}

choice! {
    /// Whether a controller gets natural units or numbers of order one.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Scaling {
        /// Radians, metres, metres per second.
        Natural = "natural",
        /// States divided by (π, 30 m, π, 8 m/s); actions in [−1, 1] over their whole range.
        Unit = "unit",
    }
}
