use base::signature::Distribution;
use road::geometry::{Point, Pose, Vector, wrap_angle};
use world::sim::WalkCommand;

/// The path of a pedestrian, given by points and the times at which it is there.
///
/// The first command of an episode states a pace and a direction. The command of [`GivenPath::command`] leads along the path as it is given.
/// A command at twice that speed halves all times, and a command in another direction turns the path about its first point. Later commands of
/// the episode have no effect. The path does not depend on the car.
///
/// In each tick the pedestrian heads for the place on the path where it is to be at the end of the tick, never faster than on the fastest
/// piece. A body that reaches every velocity within a tick is there exactly; another body cuts corners and lags behind.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenPath {
    /// The points, two at least, with their times from the departure (s). Times do not decrease, and grow where the place changes.
    pub points: Vec<PathPoint>,
    /// The time that the pedestrian stands at the first point before it departs (s).
    pub delay: Distribution,
}

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    pub place: Point,
    /// The time from the departure (s).
    pub time: f64,
}

/// What the first command of an episode makes of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pacing {
    /// The time of the departure (s).
    departure: f64,
    /// The speed as a multiple of the stated one.
    pace: f64,
    /// The angle by which the path is turned about its first point (rad).
    turn: f64,
}

impl GivenPath {
    /// The pose at the first point, looking along the path.
    pub fn start(&self) -> Pose {
        let place = self.points[0].place;
        Pose::new(place.x, place.y, self.command().heading)
    }

    /// The command that leads along the path as it is given: direction and speed of its first piece with a length.
    pub fn command(&self) -> WalkCommand {
        let pieces = self.points.windows(2).map(|ends| (ends[1].place - ends[0].place, ends[1].time - ends[0].time));
        let (way, time) = pieces.into_iter().find(|(way, _)| way.norm() > 0.0).expect("checked: the path has a length");
        WalkCommand { heading: libm::atan2(way.y, way.x), speed: way.norm() / time }
    }

    /// The greatest speed on a piece (m/s).
    fn greatest_speed(&self) -> f64 {
        let pieces = self.points.windows(2).filter(|ends| ends[1].time > ends[0].time);
        let speed = |ends: &[PathPoint]| (ends[1].place - ends[0].place).norm() / (ends[1].time - ends[0].time);
        pieces.map(speed).fold(0.0, f64::max)
    }

    /// Where the path as it is given leads at a time from the departure (s).
    pub fn place(&self, time: f64) -> Point {
        let next = self.points.partition_point(|point| point.time <= time);
        match (self.points[..next].last(), self.points.get(next)) {
            (Some(before), Some(after)) => {
                let share = (time - before.time) / (after.time - before.time);
                before.place + (after.place - before.place) * share
            }
            (Some(last), None) => last.place,
            (None, _) => self.points[0].place,
        }
    }

    /// What a first command makes of the path, with a departure at a time of the episode (s).
    pub(crate) fn pacing(&self, command: WalkCommand, departure: f64) -> Pacing {
        let stated = self.command();
        Pacing { departure, pace: command.speed / stated.speed, turn: wrap_angle(command.heading - stated.heading) }
    }

    /// The command of the pedestrian with a pose in a tick of this length (s).
    pub(crate) fn tick_command(&self, pacing: &Pacing, pose: &Pose, tick: u32, dt: f64) -> WalkCommand {
        let time = (f64::from(tick + 1) * dt - pacing.departure) * pacing.pace;
        let first = self.points[0].place;
        let (sin, cos) = libm::sincos(pacing.turn);
        let way = self.place(time) - first;
        let wanted = first + Vector::new(cos * way.x - sin * way.y, sin * way.x + cos * way.y);
        let step = wanted - pose.position();
        if step.norm() < 1e-9 {
            return WalkCommand { heading: pose.yaw, speed: 0.0 };
        }
        let speed = (step.norm() / dt).min(self.greatest_speed() * pacing.pace);
        WalkCommand { heading: libm::atan2(step.y, step.x), speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use road::geometry::Obstacles;
    use world::sim::{PedestrianBody, PedestrianState};

    fn path() -> GivenPath {
        let point = |x, y, time| PathPoint { place: Point::new(x, y), time };
        // Two metres east at 1 m/s, a stop of 1 s, three metres north at 1.5 m/s.
        let points = vec![point(1.0, 0.0, 0.0), point(3.0, 0.0, 2.0), point(3.0, 0.0, 3.0), point(3.0, 3.0, 5.0)];
        GivenPath { points, delay: Distribution::Constant(0.0) }
    }

    fn walked(command: WalkCommand, departure: f64, body: PedestrianBody, ticks: u32) -> Pose {
        let (path, free) = (path(), Obstacles::new(&[]));
        let pacing = path.pacing(command, departure);
        let start = PedestrianState::standing(path.start());
        let step = |state: PedestrianState, tick| {
            state.step(path.tick_command(&pacing, &state.pose, tick, 0.05), &body, &free, 0.05)
        };
        (0..ticks).fold(start, step).pose
    }

    #[test]
    fn a_nimble_body_is_where_the_path_is_at_every_time() {
        let (nominal, body) = (path().command(), PedestrianBody::adult().nimble());
        assert_eq!((nominal.heading, nominal.speed), (0.0, 1.0));
        for (seconds, x, y) in [(0.5, 1.0, 0.0), (1.5, 2.0, 0.0), (3.0, 3.0, 0.0), (4.5, 3.0, 1.5), (9.0, 3.0, 3.0)] {
            let ticks = (seconds / 0.05_f64).round() as u32;
            let pose = walked(nominal, 0.5, body, ticks);
            assert!((pose.position() - Point::new(x, y)).norm() < 1e-6, "{seconds} s: {pose:?}");
        }
    }

    #[test]
    fn the_first_command_states_pace_and_direction() {
        let body = PedestrianBody::adult().nimble();
        let turned = WalkCommand { heading: std::f64::consts::FRAC_PI_2, speed: 2.0 };
        let pose = walked(turned, 0.0, body, 40);
        // After 2 s at twice the pace: two metres north of the first point, and 1.5 m west of there.
        assert!((pose.position() - Point::new(-0.5, 2.0)).norm() < 1e-6, "{pose:?}");
        let standing = walked(WalkCommand { heading: 0.0, speed: 0.0 }, 0.0, body, 40);
        assert!((standing.position() - Point::new(1.0, 0.0)).norm() < 1e-9);
    }

    #[test]
    fn a_slow_body_lags_and_never_runs() {
        let (path, free, body) = (path(), Obstacles::new(&[]), PedestrianBody::adult());
        let pacing = path.pacing(path.command(), 0.0);
        let mut state = PedestrianState::standing(path.start());
        for tick in 0..200 {
            state = state.step(path.tick_command(&pacing, &state.pose, tick, 0.05), &body, &free, 0.05);
            assert!(state.speed() <= 1.5 + 1e-9, "{}", state.speed());
        }
        assert!((state.pose.position() - Point::new(3.0, 3.0)).norm() < 0.05, "it arrives: {:?}", state.pose);
    }
}
