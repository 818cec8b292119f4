use super::Spawn;
use base::choice;
use base::signature::Distribution;
use road::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use world::sim::{Pedestrian, PedestrianBody, PedestrianState, Vehicle, VehicleBlueprint, VehicleState, WalkCommand};

/// A car below this speed has stopped (m/s).
const STOPPED: f64 = 0.1;
/// The tolerances of a target at the meeting: its place (m), and its speed (m/s), 0.2 km/h.
///
/// # Source
/// 49 CFR 571.127, S8.3.5; Euro NCAP, CPNA: 5 ± 0.2 km/h.
const KEPT: (f64, f64) = (0.15, 0.2 / 3.6);
/// A target along the path walks this far to the left of its stated line (m). A test track holds the line within 0.05 m, and no target is
/// exactly dead ahead of a car. In a simulation it would be, and CARLA's agent does not see what is
/// (`ported::behavior_agent`).
const OFF_LINE: f64 = 0.01;

/// The walk of a pedestrian target in a test with a car: a straight line, on which it would meet the car's front at a stated share of the
/// car's width if the car kept its speed.
///
/// The driver holds the test speed before the episode starts. The release of the target is computed once, from the place and the speed that
/// the car has at the start. Afterwards the target neither waits nor speeds up for the car. Its first command states its speed, and by its
/// heading the direction of the line: a turned line still leads through the meeting. Later commands of the episode have no effect.
///
/// Episodes take the cases in turn: episode *k* is case *k* mod n. A test is over when the car has stopped, when the target has left its path,
/// or, along the path, when the car is slower than the target.
///
/// # Source
/// Euro NCAP, *Crash Avoidance Frontal Collisions* 1.1 (2025), 5.2, and *AEB/LSS VRU Test Protocol* 4.5.1 (2024); 49 CFR 571.127, S8. The
/// geometry is that of the OpenSCENARIO files in `vectorgrp/OSC-NCAP-scenarios` (ee7aa11).
#[derive(Debug, Clone, PartialEq)]
pub struct TargetWalk {
    /// The middle of the car's front when both meet, and the direction of the car.
    pub meeting: Pose,
    /// The side from which it comes.
    pub from: TargetSide,
    /// The cases: test speed and overlap.
    pub cases: Vec<TestCase>,
    /// Its speed if nothing else is commanded (m/s); 0 for a target that stands.
    pub speed: f64,
    /// The distance of its start from the line on which the middle of the car drives (m); not used along the path.
    pub distance: f64,
    /// The share of its way that it starts from; 1 for the whole way.
    pub approach: Distribution,
    /// The way within which it reaches its speed at a constant acceleration (m).
    pub reach: f64,
    /// The time that the car takes from the start to the meeting (s).
    pub headway: f64,
    /// The box that the target of the protocol fills.
    pub target: TargetBox,
    /// Whether parked cars hide the start of the target from the car at its own start.
    pub hidden: bool,
    /// How its results are judged.
    pub criterion: TestCriterion,
}

choice! {
    /// How a protocol judges the impact speed of a test.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum TestCriterion {
        /// Passed without contact.
        NoCollision = "no_collision",
        /// The colours of Euro NCAP.
        EuroNcap = "euro_ncap",
        /// The greatest impact speeds of UN R152 for M1 and N1 in running order.
        UnR152 = "un_r152",
    }
}

impl TestCriterion {
    /// The greatest impact speed that passes at a test speed (m/s). Euro NCAP gives points instead: it passes a result that has points.
    ///
    /// # Source
    /// UN R152, 02 series, 5.2.2.4: the limits of M1 and of N1 in running order are the same.
    pub fn limit(self, test_speed: f64) -> f64 {
        let kmh = test_speed * 3.6;
        match self {
            Self::NoCollision => 0.0,
            Self::EuroNcap => euro_ncap_bands(test_speed).map_or(0.0, |[_, _, brown]| brown),
            Self::UnR152 => R152.iter().find(|(up_to, _)| kmh <= up_to + 0.01).map_or(0.0, |(_, limit)| limit / 3.6),
        }
    }
}

/// The greatest impact speeds of Euro NCAP's yellow, orange and brown at a test speed (m/s); green is none. `None` at a speed without colours.
///
/// # Source
/// Euro NCAP's calculator of ratings of 2026, `euroncap-rating-2026` 5.3.0, `crash_avoidance/matrix_processing.py`; at 60 km/h also Crash Avoidance Frontal
/// Collisions 1.1, 5.2.
pub fn euro_ncap_bands(test_speed: f64) -> Option<[f64; 3]> {
    let kmh = test_speed * 3.6;
    let is_it = |(at, _): &&(f64, [f64; 3])| (kmh - at).abs() < 0.01 || *at == 50.0 && kmh > *at;
    EURO_NCAP.iter().find(is_it).map(|(_, limits)| limits.map(|limit| limit / 3.6))
}

/// Test speeds, the last one for faster ones, too, and the bands there (km/h).
const EURO_NCAP: [(f64, [f64; 3]); 5] = [
    (10.0, [0.0, 0.0, 0.0]),
    (20.0, [0.0, 0.0, 0.0]),
    (30.0, [0.0, 0.0, 10.0]),
    (40.0, [0.0, 10.0, 20.0]),
    (50.0, [10.0, 20.0, 30.0]),
];

/// Greatest impact speeds of UN R152 in running order: up to this test speed, this speed (km/h).
const R152: [(f64, f64); 5] = [(42.0, 0.0), (45.0, 15.0), (50.0, 25.0), (55.0, 30.0), (60.0, 35.0)];

choice! {
    /// The side from which a target comes to the path of the car.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum TargetSide {
        /// From the right of the car.
        Right = "right",
        /// From the left of the car.
        Left = "left",
        /// It walks in the direction of the car, in its path.
        Along = "along",
    }
}

/// A case of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestCase {
    /// The speed that the driver is to hold before the encounter (m/s).
    pub test_speed: f64,
    /// The place on the car's front that is to meet the target's impact point, as a share of the car's width: from the side from which
    /// the target comes, or from the right along the path.
    pub overlap: f64,
}

/// The box of a pedestrian target, which has a marked impact point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetBox {
    /// Half of its extent in walking direction (m).
    pub half_length: f64,
    /// Half of its extent across (m).
    pub half_width: f64,
    /// The distance from its middle back to its impact point (m).
    pub impact_point: f64,
}

/// A walk that has been fixed at the start of an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Release {
    /// Where the target stands until then, looking in walking direction.
    pub start: Pose,
    /// The tick in which it starts to walk.
    tick: u32,
    speed: f64,
    /// Acceleration (m/s²); infinite for at once.
    acceleration: f64,
}

impl TargetBox {
    /// The adult target: 0.6 m long, 0.5 m wide, impact point 0.36 m behind its front.
    pub const ADULT: Self = Self { half_length: 0.3, half_width: 0.25, impact_point: 0.06 };
    /// The child target: 0.711 m long, 0.298 m wide, impact point 0.396 m behind its front.
    pub const CHILD: Self = Self { half_length: 0.3555, half_width: 0.149, impact_point: 0.0405 };
}

impl TargetWalk {
    pub fn case(&self, episode: u64) -> &TestCase {
        &self.cases[(episode % self.cases.len() as u64) as usize]
    }

    /// The command that the protocol states, if the line is not turned.
    pub fn command(&self) -> WalkCommand {
        WalkCommand { heading: self.heading(), speed: self.speed }
    }

    /// The walking direction (rad).
    fn heading(&self) -> f64 {
        let turn = match self.from {
            TargetSide::Right => std::f64::consts::FRAC_PI_2,
            TargetSide::Left => -std::f64::consts::FRAC_PI_2,
            TargetSide::Along => 0.0,
        };
        wrap_angle(self.meeting.yaw + turn)
    }

    /// The pose of the car at the start of a case, if it has half of this length (m).
    pub fn car(&self, case: &TestCase, half_length: f64) -> Pose {
        let place = self.meeting.to_world(Vector::new(-half_length - self.headway * case.test_speed, 0.0));
        Pose::new(place.x, place.y, self.meeting.yaw)
    }

    /// Whether the middle of the target can be seen from this car in a case, both at their starts.
    pub fn is_in_sight(&self, obstacles: &Obstacles, car: &VehicleBlueprint) -> bool {
        let is_seen = |number: u64, case: &TestCase| {
            let pose = self.car(case, car.half_length);
            let state = VehicleState { pose, speed: case.test_speed, ..VehicleState::default() };
            let target = self.release(number, 1.0, &state, car, self.command(), 1e-3).start;
            obstacles.shows(state.eye(car), (target.position(), 0.0), std::iter::empty())
        };
        (0..).zip(&self.cases).any(|(number, case)| is_seen(number, case))
    }

    /// The first case in which a body that is commanded this speed (m/s) is not where and as fast as stated when it would meet a car that keeps
    /// its speed, with ticks of this length (s): its number, how far it is from the place (m), and its speed (m/s). A body that starts too
    /// slowly misses it, and one that something stops on its way.
    pub fn missed(
        &self,
        speed: f64,
        body: &PedestrianBody,
        car: &VehicleBlueprint,
        obstacles: &Obstacles,
        dt: f64,
    ) -> Option<(usize, f64, f64)> {
        let command = WalkCommand { speed, ..self.command() };
        let walked = |number: usize, case: &TestCase| {
            let pose = self.car(case, car.half_length);
            let state = VehicleState { pose, speed: case.test_speed, ..VehicleState::default() };
            let release = self.release(number as u64, 1.0, &state, car, command, dt);
            let ticks = (self.headway / dt).round() as u32;
            let start = PedestrianState::standing(release.start);
            let end = (0..ticks).fold(start, |at, tick| at.step(release.command(tick, dt), body, obstacles, dt));
            let apart = (end.pose.position() - self.meeting_of_target(case, car).0).norm();
            (apart > KEPT.0 || (end.speed() - speed).abs() > KEPT.1).then(|| (number, apart, end.speed()))
        };
        self.cases.iter().enumerate().find_map(|(number, case)| walked(number, case))
    }

    /// The start of an episode, up to what the driver makes of it.
    pub(crate) fn spawn(&self, episode: u64, approach: f64, car: &VehicleBlueprint) -> Spawn {
        let case = self.case(episode);
        let ego = self.car(case, car.half_length);
        let state = VehicleState { pose: ego, speed: case.test_speed, ..VehicleState::default() };
        let pedestrian = self.release(episode, approach, &state, car, self.command(), 1.0).start;
        Spawn { ego, ego_speed: case.test_speed, pedestrian }
    }

    /// Where the middle of the target is when it meets the car, and its way up to there (m).
    fn meeting_of_target(&self, case: &TestCase, car: &VehicleBlueprint) -> (Point, f64) {
        let (half, target) = (car.half_width, &self.target);
        // To the left of the middle of the car.
        let aside = (2.0 * case.overlap - 1.0) * half;
        let past = target.impact_point;
        let (place, way) = match self.from {
            TargetSide::Right => (Vector::new(target.half_width, aside + past), self.distance + aside + past),
            TargetSide::Left => (Vector::new(target.half_width, -aside - past), self.distance + aside + past),
            TargetSide::Along => (Vector::new(target.half_length, aside + OFF_LINE), f64::INFINITY),
        };
        (self.meeting.to_world(place), way)
    }

    /// Whether a test without contact is over: the car has stopped, it has passed the target, the target has crossed its path, or, along the
    /// path, the car is slower than the target.
    ///
    /// # Source
    /// 49 CFR 571.127, S8.3.6, S8.4.4 and S8.5.4. Euro NCAP ends its tests in the same way.
    pub(crate) fn is_over(&self, car: &Vehicle, target: &Pedestrian) -> bool {
        let place = car.state.pose.to_local(target.state.pose.position());
        let aside = car.blueprint.half_width + target.body.radius;
        let passed = place.x < -car.blueprint.half_length - target.body.radius;
        passed
            || match self.from {
                TargetSide::Right => car.state.speed < STOPPED || place.y > aside,
                TargetSide::Left => car.state.speed < STOPPED || place.y < -aside,
                TargetSide::Along => car.state.speed < target.state.speed().max(STOPPED),
            }
    }

    /// The impact speed that a protocol judges, for a car that hits at `speed` (m/s) a target with this command; 0 for a car that has stopped.
    ///
    /// Across the path the target's own speed counts as 0, along the path it is subtracted.
    pub fn judged_speed(&self, speed: f64, target: WalkCommand) -> f64 {
        match self.from {
            TargetSide::Along if target.speed > 0.0 => {
                (speed - target.speed * libm::cos(target.heading - self.meeting.yaw)).max(0.0)
            }
            _ if speed > STOPPED => speed,
            _ => 0.0,
        }
    }

    /// Fixes the walk of an episode for a car in this state and a first command, with ticks of this length (s).
    ///
    /// The start is moved by at most half a tick's way along the line, so that the target is released with a tick. Where the car comes
    /// sooner than the target would, the target starts as much nearer.
    pub(crate) fn release(
        &self,
        episode: u64,
        approach: f64,
        car: &VehicleState,
        blueprint: &VehicleBlueprint,
        command: WalkCommand,
        dt: f64,
    ) -> Release {
        let (place, way) = self.meeting_of_target(self.case(episode), blueprint);
        let gap = -self.meeting.to_local(car.pose.position()).x - blueprint.half_length;
        let time = if car.speed > 1e-3 { gap.max(0.0) / car.speed } else { self.headway };
        let speed = command.speed;
        let acceleration = if self.reach > 0.0 { speed * speed / (2.0 * self.reach) } else { f64::INFINITY };
        let wanted = way * approach;
        let needed = match self.from {
            TargetSide::Along => time,
            _ if speed <= 0.0 => 0.0,
            // It needs v / (2 a) longer than at its full speed: reach / v.
            _ if wanted >= self.reach => (wanted + self.reach) / speed,
            _ => (2.0 * wanted / acceleration).sqrt(),
        };
        let tick = ((time - needed) / dt).round().max(0.0) as u32;
        let left = (time - f64::from(tick) * dt).max(0.0);
        let rise = if speed > 0.0 && acceleration.is_finite() { speed / acceleration } else { 0.0 };
        let walked = if left < rise { 0.5 * acceleration * left * left } else { speed * (left - 0.5 * rise) };
        let (sin, cos) = libm::sincos(command.heading);
        let start = place - Vector::new(cos, sin) * walked;
        Release { start: Pose::new(start.x, start.y, wrap_angle(command.heading)), tick, speed, acceleration }
    }
}

impl Release {
    /// The command of the target in a tick of this length (s): its mean speed within that tick.
    pub(crate) fn command(&self, tick: u32, dt: f64) -> WalkCommand {
        let since = f64::from(tick) - f64::from(self.tick) + 0.5;
        let speed = if since < 0.0 { 0.0 } else { self.speed.min(self.acceleration * since * dt) };
        WalkCommand { heading: self.start.yaw, speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(from: TargetSide, speed: f64) -> TargetWalk {
        let case = |test_speed: f64, overlap| TestCase { test_speed: test_speed / 3.6, overlap };
        TargetWalk {
            meeting: Pose::new(10.0, -1.75, 0.3),
            from,
            cases: vec![case(10.0, 0.25), case(50.0, 0.5), case(60.0, 0.75)],
            speed,
            distance: 4.0,
            approach: Distribution::Constant(1.0),
            reach: 1.0,
            headway: 6.0,
            target: TargetBox::ADULT,
            hidden: false,
            criterion: TestCriterion::NoCollision,
        }
    }

    /// The middle of the target in the frame of the meeting when a car that keeps its speed is there.
    fn met(walk: &TargetWalk, episode: u64, command: WalkCommand, dt: f64) -> Vector {
        let car = VehicleBlueprint::model3();
        let case = walk.case(episode);
        let state =
            VehicleState { pose: walk.car(case, car.half_length), speed: case.test_speed, ..VehicleState::default() };
        let release = walk.release(episode, 1.0, &state, &car, command, dt);
        let ticks = (walk.headway / dt).round() as u32;
        let walked: f64 = (0..ticks).map(|tick| release.command(tick, dt).speed * dt).sum();
        let place = release.start.position() + release.start.forward() * walked;
        walk.meeting.to_local(place)
    }

    #[test]
    fn a_target_meets_the_stated_share_of_the_width() {
        let half = VehicleBlueprint::model3().half_width;
        for (from, side) in [(TargetSide::Right, -1.0), (TargetSide::Left, 1.0)] {
            let walk = walk(from, 5.0 / 3.6);
            for (episode, share) in [(0, 0.25), (1, 0.5), (2, 0.75), (3, 0.25)] {
                let middle = met(&walk, episode, walk.command(), 0.05);
                let impact_point = middle.y + side * TargetBox::ADULT.impact_point;
                let overlap = 0.5 + impact_point * -side / (2.0 * half);
                assert!((overlap - share).abs() < 0.001, "{from:?} {share}: {overlap}");
                assert!((middle.x - TargetBox::ADULT.half_width).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_turned_or_slower_line_leads_through_the_same_meeting() {
        let walk = walk(TargetSide::Right, 5.0 / 3.6);
        let nominal = met(&walk, 1, walk.command(), 0.05);
        for (turn, speed) in [(0.3, 8.0 / 3.6), (-0.3, 4.0 / 3.6)] {
            let command = WalkCommand { heading: walk.command().heading + turn, speed };
            assert!((met(&walk, 1, command, 0.05) - nominal).norm() < 0.003, "{turn}");
        }
    }

    #[test]
    fn a_target_along_the_path_walks_ahead_of_the_car_and_a_standing_one_stands() {
        for speed in [5.0 / 3.6, 0.0] {
            let walk = walk(TargetSide::Along, speed);
            let middle = met(&walk, 0, walk.command(), 0.05);
            assert!((middle.x - TargetBox::ADULT.half_length).abs() < 0.003, "{middle}");
            let right = VehicleBlueprint::model3().half_width;
            assert!((middle.y + 0.5 * right - OFF_LINE).abs() < 1e-9, "a quarter of the width from the right");
        }
    }
}
