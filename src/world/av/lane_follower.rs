use super::crosswalks::{self, CrosswalkKeys};
use super::give_way::GiveWayMemory;
use super::route_trace::RouteTrace;
use super::{DrivingMode, Path, Perception, lane_keeping};
use crate::sim::{Control, LightColour};
use base::keys;
use base::seed::Stream;
use road::geometry::wrap_angle;

keys! {
    /// What drivers with a lane follower inside take.
    #[derive(Copy)]
    pub struct LaneKeys {
        /// Share of the speed limit that it wants to drive (assumed).
        limit_share: f64 as share() = "0.9",
    }
}

/// Lateral acceleration in bends, and deceleration before bends and red lights (m/s²).
const COMFORT: f64 = 2.0;
/// Greatest acceleration (m/s²).
const PUSH: f64 = 1.5;
/// Range of the search for red lights (m).
const LIGHTS: f64 = 40.0;

/// Keeps the lane, slows down before bends, stops at red lights and heeds stop and yield signs: the driver inside the guarded drivers. It ignores other road users, except
/// that it can yield to pedestrians at crosswalks.
#[derive(Debug, Clone)]
pub struct LaneFollower {
    lane: LaneKeys,
    at_crosswalks: CrosswalkKeys,
    path: Path,
    signs: GiveWayMemory,
    /// The way ahead.
    pub trace: RouteTrace,
}

/// The driver's intention.
#[derive(Debug, Clone, Copy)]
pub struct Intent {
    /// Acceleration (m/s²).
    pub acceleration: f64,
    /// Steering wheel, as in [`Control`].
    pub steer: f64,
    /// The speed it aims at (m/s).
    pub wanted: f64,
    /// The manoeuvre of the intention.
    pub mode: DrivingMode,
}

impl LaneFollower {
    pub fn new(lane: LaneKeys, at_crosswalks: CrosswalkKeys) -> Self {
        Self {
            lane,
            at_crosswalks,
            path: Path::default(),
            signs: GiveWayMemory::default(),
            trace: RouteTrace::default(),
        }
    }

    /// The speed limit at which it drives this speed (m/s).
    pub fn speed_limit_for(&self, speed: f64) -> f64 {
        speed / self.lane.limit_share
    }

    /// Starts an episode.
    pub fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.signs = GiveWayMemory::default();
    }

    /// Draws from another stream from now on.
    pub fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }

    /// Looks along the lane and returns its intention.
    pub fn intend(&mut self, perception: &Perception<'_>) -> Intent {
        self.path.advance(perception);
        self.trace.follow(&self.path, perception);
        let speed = perception.ego.speed();
        let limit = lane_keeping::speed_for_limits(&self.path, perception, self.lane.limit_share, COMFORT);
        let bends = lane_keeping::speed_for_bends(&self.path, limit, COMFORT, COMFORT);
        let light = self.red_light(perception);
        let crosswalk = self.at_crosswalks.yields().then(|| crosswalks::gap(perception, &self.path)).flatten();
        let before = |stop: Option<f64>| stop.map_or(bends, |gap| bends.min((2.0 * COMFORT * gap).sqrt()));
        let demand = self.signs.next(perception, &self.path);
        let sign = demand.map_or(bends, |sign| bends.min(sign.allowed(COMFORT)));
        let lower = lane_keeping::lower_limit(&self.path, perception, self.lane.limit_share, COMFORT);
        let demands = demand.into_iter().chain(lower).map(|demand| demand.acceleration(speed, COMFORT));
        let wanted = before(light).min(before(crosswalk)).min(sign);
        let mode = if wanted < before(light).min(sign) {
            DrivingMode::Yield
        } else if wanted < before(light) {
            DrivingMode::GiveWay
        } else if wanted < bends {
            DrivingMode::RedLight
        } else if bends < 0.1 {
            DrivingMode::Arrived
        } else if bends < limit - 0.1 {
            DrivingMode::Turn
        } else {
            DrivingMode::Cruise
        };
        // A car that stopped beyond the line would be on the crosswalk.
        let stop = crosswalk.filter(|_| mode == DrivingMode::Yield).map(|gap| -speed * speed / (2.0 * gap).max(0.1));
        let tracked = demands.fold((wanted - speed) / 0.5, f64::min);
        let acceleration = stop.map_or(tracked, |stop| tracked.min(stop)).clamp(-2.0 * COMFORT, PUSH);
        Intent { acceleration, steer: lane_keeping::steer(&self.path, perception), wanted, mode }
    }

    /// The distance from the bumper to the stop at the first red light (m).
    fn red_light(&self, perception: &Perception<'_>) -> Option<f64> {
        let here = perception.ego.pose.position();
        let red = perception.lights.iter().filter(|light| light.colour == LightColour::Red);
        let gaps = red.filter_map(|light| {
            let line = light.trigger.position();
            if (line - here).norm_squared() > LIGHTS * LIGHTS {
                return None;
            }
            let found = self.trace.locate_point(line, &light.trigger.forward())?;
            // Lights of other lanes are beside the line or face another way.
            let same_way = wrap_angle(libm::atan2(found.velocity.y, found.velocity.x)).abs() < 1.0;
            let ahead = found.place.x > 0.0 && found.place.y.abs() < 1.0;
            (same_way && ahead).then(|| (found.place.x - perception.ego.half.x - 1.0).max(0.0))
        });
        gaps.min_by(f64::total_cmp)
    }
}

impl Intent {
    /// Pedals and wheel for this acceleration (m/s²); at rest the car is held unless it should move.
    pub fn control(&self, acceleration: f64, perception: &Perception<'_>) -> Control {
        let speed = perception.ego.speed();
        let pedals = perception.blueprint.pedals_for(acceleration, speed);
        let holds = speed < 0.05 && (acceleration <= 0.0 || self.wanted < 0.1);
        Control { throttle: pedals.throttle, brake: if holds { 1.0 } else { pedals.brake }, steer: self.steer }
    }
}
