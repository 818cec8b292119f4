/// Probable mistakes of CARLA's agent. Each can be switched off; all are on by default, as in CARLA.
///
/// Where a release does not have one of them, its switch does nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quirks {
    /// Q1: distances are measured from the bumper, and half the ego's length is nevertheless subtracted again before they are
    /// compared. Off: it is not subtracted again, so the agent brakes half a car later.
    pub half_length_twice: bool,
    /// Q2: an obstacle outside the ego's lane, by the nearest centre line, is invisible. Off: every obstacle within reach
    /// and in the cone counts.
    pub lane_blind: bool,
    /// Q3: in junctions the route polygon is a zig-zag and the obstacle's a bow-tie, both with holes. Off: a corridor
    /// and a box.
    pub zigzag: bool,
    /// Q4: without a walker near by, the walker step tests all vehicles with its wider cone. Off: it finds nothing.
    pub vehicles_for_walkers: bool,
    /// Q5: the first obstacle found counts. Off: the nearest one.
    pub first_hit: bool,
    /// Q6: an emergency stop straightens the wheels and freezes the planner. Off: the planner steers on.
    pub frozen_stop: bool,
    /// Q7: an obstacle exactly dead ahead is not seen. Off: it is.
    pub blind_dead_ahead: bool,
    /// Q8: an emergency stop uses half of the brake. Off: all of it.
    pub weak_brake: bool,
    /// Q10: an obstacle is measured at its back, which is the far side when it faces the car. Off: at its centre.
    pub rear_point: bool,
}

impl Quirks {
    /// As CARLA drives.
    pub const ALL: Self = Self::uniform(true);
    /// As its authors probably meant it to drive.
    pub const NONE: Self = Self::uniform(false);

    const fn uniform(on: bool) -> Self {
        Self {
            half_length_twice: on,
            lane_blind: on,
            zigzag: on,
            vehicles_for_walkers: on,
            first_hit: on,
            frozen_stop: on,
            blind_dead_ahead: on,
            weak_brake: on,
            rear_point: on,
        }
    }
}

impl Default for Quirks {
    fn default() -> Self {
        Self::ALL
    }
}
