use super::frame::EgoPoint;
use road::geometry::Pose;
use world::av::Actor;

/// Walkers farther away are not on the map of hazards (m).
const MAP_REACH: f64 = 15.0;
/// The margin around a walker on that map, in addition to half of the ego's length (m).
const MAP_MARGIN: f64 = 1.0;
/// The margin behind a vehicle on that map, in addition to the ego's length (m).
const BEHIND_VEHICLES: f64 = 4.0;
/// The expert brakes for walkers with a smaller gap, half sizes subtracted (m).
const EXPERT_GAP: f64 = 6.0;
/// Walkers count within this distance of the lane point under the ego (m).
const NEAR_LANE: f64 = 10.0;
/// Minimum look-ahead of the expert (m); otherwise it is a third of the limit in km/h.
const MIN_LOOK_AHEAD: f64 = 12.0;
/// Half of the expert's cone (rad).
const EXPERT_CONE: f64 = 60.0 * std::f64::consts::PI / 180.0;

/// A walker in the terms of the rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WalkerView {
    /// Where it is.
    pub place: EgoPoint,
    /// Half of its width (m).
    pub half: f64,
    /// Whether the lane nearest to it is a sidewalk.
    pub on_sidewalk: bool,
    /// Whether the driving lane nearest to it is the ego's, now or a little further on.
    pub in_lane: bool,
    /// Its distance from the lane point under the ego (m).
    pub from_lane_point: f64,
}

/// The rules that labelled LAV's training data with *brake*: a map of hazards, and the expert's full brake.
///
/// The classifier that learned these labels is LAV's only channel for pedestrians.
///
/// # Source
/// `dotchen/LAV`, branch `data-collect`: the map's `brake_label`, and its cautious `BehaviorAgent`, which ignores lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrakeRules {
    /// Half of the ego's length (m).
    pub ego_half_length: f64,
    /// The ego's speed limit (m/s).
    pub speed_limit: f64,
}

impl BrakeRules {
    /// Whether either rule brakes for a walker.
    pub fn brake(&self, walker: &WalkerView) -> bool {
        self.on_map(walker) || self.by_expert(walker)
    }

    /// The map of hazards: the ego's centre is in the walker's disc, which is shifted back by half of the ego's length, and
    /// the walker is within a wedge that narrows with the distance.
    pub fn on_map(&self, walker: &WalkerView) -> bool {
        let (distance, ahead) = (self.distance(walker), -walker.place.back);
        let wedge = (162.0 / (distance.clamp(1.5, 10.5) + 0.3)).to_radians();
        let radius = walker.half + self.ego_half_length + MAP_MARGIN;
        let centre = EgoPoint::new(walker.place.right, self.ego_half_length - ahead);
        !walker.on_sidewalk
            && distance < MAP_REACH
            && bearing(walker.place).abs() < wedge
            && centre.distance(EgoPoint::default()) < radius
    }

    /// The expert's full brake: the walker is in the ego's lane, in the cone and near. One exactly dead ahead is missed.
    pub fn by_expert(&self, walker: &WalkerView) -> bool {
        let distance = self.distance(walker);
        let bearing = bearing(walker.place).abs();
        !walker.on_sidewalk
            && walker.in_lane
            && walker.from_lane_point < NEAR_LANE
            && distance < MIN_LOOK_AHEAD.max(self.speed_limit * 3.6 / 3.0)
            && bearing > 0.0
            && bearing < EXPERT_CONE
            && distance - walker.half - self.ego_half_length < EXPERT_GAP
    }

    /// The maximum distance of a walker for which a rule brakes (m).
    pub fn reach(&self, half: f64) -> f64 {
        let on_map = 2.0 * self.ego_half_length + half + MAP_MARGIN;
        on_map.max(half + self.ego_half_length + EXPERT_GAP)
    }

    /// Whether the ego's centre is in a vehicle's box, which reaches back by the ego's length and four metres.
    pub fn behind_vehicle(&self, ego: &Pose, vehicle: &Actor) -> bool {
        let local = vehicle.pose.to_local(ego.position());
        let reach = vehicle.half.x + (2.0 * self.ego_half_length + BEHIND_VEHICLES);
        local.y.abs() < vehicle.half.y && local.x < vehicle.half.x && local.x > -reach
    }

    /// Whether a red light's line at this distance ahead of the ego's centre (m) is a hazard; the distance is that of a walker. LAV's
    /// own distance is not known.
    pub fn at_line(&self, ahead: f64) -> bool {
        ahead > 0.0 && ahead < 2.0 * self.ego_half_length + MAP_MARGIN
    }

    fn distance(&self, walker: &WalkerView) -> f64 {
        walker.place.distance(EgoPoint::default())
    }
}

/// The bearing of a place (rad), positive to the right.
pub(super) fn bearing(place: EgoPoint) -> f64 {
    libm::atan2(place.right, -place.back)
}
