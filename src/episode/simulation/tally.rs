use crate::{Spawn, StateHashes};
use road::geometry::Pose;
use world::sim::{ActorStart, World};

/// The hash of an episode's states, and how near ego and pedestrians came.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally {
    pub(super) digest: u64,
    pub(super) state_hashes: StateHashes,
    pub(super) least_gap: f64,
}

impl Tally {
    /// Before an episode.
    pub(super) fn new() -> Self {
        Self { digest: 0, state_hashes: StateHashes::default(), least_gap: f64::INFINITY }
    }

    /// Tick 0.
    pub(super) fn begin(&mut self, world: &World) {
        for pedestrian in 0..world.pedestrians.len() {
            self.least_gap = self.least_gap.min(world.gap(0, pedestrian));
        }
    }

    /// Adds a tick: vehicles first, in the order of their numbers.
    #[inline]
    pub(super) fn tick(&mut self, world: &World) {
        let mut digest = self.digest;
        for vehicle in &world.vehicles {
            let Pose { x, y, yaw } = vehicle.state.pose;
            for value in [x, y, yaw, vehicle.state.speed] {
                digest = mix(digest, value.to_bits());
            }
        }
        let ego = world.ego();
        let (middle, size) = (ego.state.pose.position(), ego.blueprint.half_length + ego.blueprint.half_width);
        for (number, pedestrian) in world.pedestrians.iter().enumerate() {
            let place = pedestrian.state.pose.position();
            for value in [place.x, place.y] {
                digest = mix(digest, value.to_bits());
            }
            // The distance of the centres bounds the gap from below; most ticks need no more.
            let reach = self.least_gap + size + pedestrian.body.reach();
            if (middle - place).norm_squared() < reach * reach {
                self.least_gap = self.least_gap.min(world.gap(0, number));
            }
        }
        self.digest = digest;
    }

    /// Ends a decision.
    pub(super) fn settle(&mut self) {
        self.state_hashes.mark(self.digest);
    }
}

/// Adds a start to a hash.
pub(super) fn hashed(digest: u64, spawn: &Spawn) -> u64 {
    let Spawn { ego, ego_speed, pedestrian } = spawn;
    let values = [ego.x, ego.y, ego.yaw, *ego_speed, pedestrian.x, pedestrian.y, pedestrian.yaw];
    values.iter().fold(digest, |digest, value| mix(digest, value.to_bits()))
}

/// Adds the start of another actor to a hash.
pub(super) fn hashed_start(digest: u64, start: &ActorStart) -> u64 {
    let Pose { x, y, yaw } = start.pose;
    [x, y, yaw, start.speed].iter().fold(digest, |digest, value| mix(digest, value.to_bits()))
}

/// One round of a multiply-rotate hash.
fn mix(digest: u64, word: u64) -> u64 {
    (digest.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95)
}
