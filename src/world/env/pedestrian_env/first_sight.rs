use super::PedestrianEnv;
use crate::av::EYE;
use crate::env::LeftOut;
use crate::geometry::Vector;

/// The road up to the first sight of a pedestrian: a car that leaves it before has a driver that is lost, whatever the pedestrian does.
impl PedestrianEnv {
    /// Starts to watch the road at tick 0, unless the episode is left out already or counts in any case.
    pub(super) fn begin_watch(&mut self) {
        self.episode.alone = self.episode.left_out.is_none() && !self.scenario.episode.count_all;
        if self.episode.alone {
            self.watch_road();
        }
    }

    /// Looks at the road and then for a pedestrian: what ends a tick in which one comes into sight is not a reaction to it yet.
    pub(super) fn watch_road(&mut self) {
        let ego = self.world.ego();
        let here = ego.state.pose.position();
        let (from, room) = self.episode.on_road;
        if (here - from).norm_squared() >= room * room {
            let inside = self.world.town.lane_around(here).map_or(f64::INFINITY, |lane| lane.inside);
            if inside < 0.0 {
                let past_end = self.world.town.is_past_end(here);
                self.episode.left_out = Some(if past_end { LeftOut::RoadEnd } else { LeftOut::OffRoad });
                self.episode.alone = false;
                return;
            }
            self.episode.on_road = (here, inside);
        }
        let eye = ego.state.pose.to_world(Vector::new(ego.blueprint.half_length - EYE, 0.0));
        let obstacles = &self.world.obstacles;
        // A driver from outside gets what its middle sees, a verdict asks for its eye: either counts as sight.
        let is_seen = self.world.pedestrians.iter().any(|pedestrian| {
            let place = pedestrian.state.pose.position();
            !obstacles.blocks_sight(here, place) || obstacles.shows(eye, place, pedestrian.body.radius)
        });
        self.episode.alone = !is_seen;
    }

    /// Looks for the end of the map once a pedestrian is in sight: a car that drives past it is where the scenario has no road, and no verdict
    /// about it means anything. Only our own drivers stop there.
    pub(super) fn watch_end(&mut self) {
        if self.episode.left_out.is_some() || self.scenario.episode.count_all || !self.world.town.has_ends() {
            return;
        }
        let here = self.world.ego().state.pose.position();
        let (from, room) = self.episode.on_road;
        if (here - from).norm_squared() < room * room {
            return;
        }
        let inside = self.world.town.lane_around(here).map_or(f64::INFINITY, |lane| lane.inside);
        if inside < 0.0 && self.world.town.is_past_end(here) {
            self.episode.left_out = Some(LeftOut::RoadEnd);
        }
        self.episode.on_road = (here, inside.abs());
    }
}
