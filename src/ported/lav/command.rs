use road::RoadOption;
use road::geometry::Point;
use world::av::Path;

/// The command of the route, in the order of LAV's branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Command {
    /// To the left at a junction.
    Left,
    /// To the right at a junction.
    Right,
    /// Straight on at a junction.
    Straight,
    /// Along the lane.
    #[default]
    LaneFollow,
    /// To the lane on the left; our routes have none.
    ChangeLeft,
    /// To the lane on the right; our routes have none.
    ChangeRight,
}

/// Distances at which the command changes (m): when it leaves lane following, and otherwise.
const CHANGE_WITHIN: (f64, f64) = (4.5, 3.0);

impl Command {
    /// All of them, in order.
    pub const ALL: [Self; 6] =
        [Self::Left, Self::Right, Self::Straight, Self::LaneFollow, Self::ChangeLeft, Self::ChangeRight];

    /// Its index in [`Command::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// The command after this one: the route's next one once its first point is near enough.
    pub(super) fn follow(self, path: &Path, here: Point) -> Self {
        let within = if self == Self::LaneFollow { CHANGE_WITHIN.0 } else { CHANGE_WITHIN.1 };
        path.points()
            .map(|point| (Self::of(point.option), point.pose.position()))
            .take_while(|(_, place)| (place - here).norm_squared() < within * within)
            .map(|(command, _)| command)
            .find(|command| *command != self)
            .unwrap_or(self)
    }

    fn of(option: RoadOption) -> Self {
        match option {
            RoadOption::Left => Self::Left,
            RoadOption::Right => Self::Right,
            RoadOption::Straight => Self::Straight,
            RoadOption::LaneFollow => Self::LaneFollow,
        }
    }
}
