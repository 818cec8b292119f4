use crate::LeftOut;
use road::geometry::Point;
use world::sim::{ActorId, World};

/// Watches whether the car is on the road: one that leaves it before a pedestrian is in sight has a driver that is lost, whatever the pedestrian
/// does, and beyond the end of the map no verdict means anything.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoadWatch {
    /// Whether every episode counts.
    count_all: bool,
    /// Why the episode is left out; `None` if it counts.
    pub(super) left_out: Option<LeftOut>,
    /// Whether no pedestrian has been in sight yet, and the road is watched.
    alone: bool,
    /// Where the car was when the map was last looked up, and how far it can go from there without crossing the road's edge (m).
    checked: (Point, f64),
}

impl RoadWatch {
    /// Before an episode.
    pub(super) fn new(count_all: bool) -> Self {
        Self { count_all, left_out: None, alone: false, checked: (Point::origin(), 0.0) }
    }

    /// The driver did not reach its start.
    pub(super) fn miss_start(&mut self) {
        self.left_out = Some(LeftOut::RunUp).filter(|_| !self.count_all);
    }

    /// Tick 0.
    pub(super) fn begin(&mut self, world: &World) {
        self.alone = self.left_out.is_none() && !self.count_all;
        if self.alone {
            self.look(world);
        }
    }

    #[inline]
    pub(super) fn tick(&mut self, world: &World) {
        if self.alone {
            self.look(world);
        } else {
            self.look_for_end(world);
        }
    }

    /// Looks at the road and then for a pedestrian: what ends a tick in which one comes into sight is not a reaction to it yet.
    fn look(&mut self, world: &World) {
        let ego = world.ego();
        let here = ego.state.pose.position();
        if self.is_due(here) {
            let inside = inside(world);
            if inside < 0.0 {
                let past_end = world.town.is_past_end(world.ego().state.place());
                self.left_out = Some(if past_end { LeftOut::RoadEnd } else { LeftOut::OffRoad });
                self.alone = false;
                return;
            }
            self.checked = (here, inside);
        }
        let mut pedestrians = (0..world.pedestrians.len() as u8).map(ActorId::Pedestrian);
        self.alone = !pedestrians.any(|pedestrian| world.sees(ActorId::EGO, pedestrian));
    }

    /// Looks for the end of the map once a pedestrian is in sight: a car that drives past it is where the scenario has no road. Only our own
    /// drivers stop there.
    fn look_for_end(&mut self, world: &World) {
        if self.left_out.is_some() || self.count_all || !world.town.has_ends() {
            return;
        }
        let here = world.ego().state.pose.position();
        if !self.is_due(here) {
            return;
        }
        let inside = inside(world);
        if inside < 0.0 && world.town.is_past_end(world.ego().state.place()) {
            self.left_out = Some(LeftOut::RoadEnd);
        }
        self.checked = (here, inside.abs());
    }

    fn is_due(&self, here: Point) -> bool {
        let (from, room) = self.checked;
        (here - from).norm_squared() >= room * room
    }
}

/// How far the ego is inside the road (m); negative outside.
fn inside(world: &World) -> f64 {
    world.town.lane_around(world.ego().state.place()).map_or(f64::INFINITY, |lane| lane.inside)
}
