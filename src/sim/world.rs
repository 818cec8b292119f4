use std::sync::Arc;

use super::{
    Contact, Control, LightClock, LightCycle, PedestrianBody, PedestrianState, VehicleBlueprint, VehicleState,
    WalkCommand,
};
use crate::geometry::{Obstacles, Pose, first_touch};
use crate::road::Town;

/// Limit that a vehicle begins with (m/s).
///
/// # Source
/// CARLA `Vehicle/WheeledVehicleAIController.h`: 30 km/h until the first sign.
const FIRST_LIMIT: f64 = 30.0 / 3.6;

/// How a world begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    /// Pose of the ego.
    pub ego: Pose,
    /// Speed of the ego (m/s).
    pub ego_speed: f64,
    /// Pose of the pedestrian, who stands.
    pub pedestrian: Pose,
    /// How far the traffic lights are in their cycles (s).
    pub light_phase: f64,
}

/// A town with a car and a pedestrian in it.
#[derive(Debug, Clone)]
pub struct World {
    /// The roads.
    pub town: Arc<Town>,
    /// What blocks the pedestrian and sight.
    pub obstacles: Arc<Obstacles>,
    /// The model of the ego.
    pub blueprint: VehicleBlueprint,
    /// The body of the pedestrian.
    pub body: PedestrianBody,
    /// The car under test.
    pub ego: VehicleState,
    /// The pedestrian.
    pub pedestrian: PedestrianState,
    /// Ticks since the beginning.
    pub ticks: u32,
    /// Length of a tick (s).
    pub dt: f64,
    /// The limit that holds for the ego (m/s).
    pub speed_limit: f64,
    /// The cycle of the traffic lights; none where they are switched off.
    pub lights: Option<LightCycle>,
    light_phase: f64,
}

impl World {
    /// Makes a world whose actors stand at the origin; [`World::begin`] places them.
    pub fn new(
        town: Arc<Town>,
        obstacles: Arc<Obstacles>,
        blueprint: VehicleBlueprint,
        body: PedestrianBody,
        lights: Option<LightCycle>,
        dt: f64,
    ) -> Self {
        Self {
            town,
            obstacles,
            blueprint,
            body,
            ego: VehicleState::default(),
            pedestrian: PedestrianState::default(),
            ticks: 0,
            dt,
            speed_limit: FIRST_LIMIT,
            lights,
            light_phase: 0.0,
        }
    }

    /// Places the actors and starts the clock.
    pub fn begin(&mut self, scene: &Scene) {
        self.ego = VehicleState { pose: scene.ego, speed: scene.ego_speed, age: 0.0 };
        self.pedestrian = PedestrianState::standing(scene.pedestrian);
        self.ticks = 0;
        self.speed_limit = FIRST_LIMIT;
        self.light_phase = scene.light_phase;
        self.obey_signs();
    }

    /// Time since the beginning (s).
    pub fn elapsed(&self) -> f64 {
        f64::from(self.ticks) * self.dt
    }

    /// The clock of the traffic lights; none where they are switched off.
    pub fn light_clock(&self) -> Option<LightClock> {
        self.lights.map(|cycle| cycle.clock(self.light_phase + self.elapsed()))
    }

    /// The traffic light in whose trigger box the ego stands.
    pub fn affecting_light(&self) -> Option<usize> {
        self.lights?;
        let reach = self.blueprint.half_length + 3.0;
        let outline = self.ego.outline(&self.blueprint);
        self.town.traffic_lights.iter().position(|light| {
            let offset = light.trigger.pose.position() - self.ego.pose.position();
            offset.norm_squared() < reach * reach && light.trigger.overlaps(&outline)
        })
    }

    /// Distance from the pedestrian's disc to the ego's box (m); 0 when they touch.
    pub fn gap(&self) -> f64 {
        let outline = self.ego.outline(&self.blueprint);
        (outline.distance_to(self.pedestrian.pose.position()) - self.body.radius).max(0.0)
    }

    /// Moves both actors by one tick and finds their first touch.
    ///
    /// After a touch the actors stand where the tick ends; the touch itself is in the [`Contact`].
    pub fn tick(&mut self, control: Control, command: WalkCommand) -> Option<Contact> {
        let (ego, pedestrian) = (self.ego, self.pedestrian);
        self.ego = ego.step(control, &self.blueprint, self.dt);
        self.pedestrian = pedestrian.step(command, &self.body, &self.obstacles, self.dt);
        self.ticks += 1;
        self.obey_signs();
        let (from, to) = (pedestrian.pose.position(), self.pedestrian.pose.position());
        let (start, end) = (ego.outline(&self.blueprint), self.ego.outline(&self.blueprint));
        // Far apart nothing needs to be computed: neither moves more than a few metres in a tick.
        let reach = self.blueprint.half_length + self.blueprint.half_width + self.body.radius + 2.0;
        let moved = (ego.speed + pedestrian.speed() + self.pedestrian.speed()) * self.dt;
        let apart = (to - end.pose.position()).norm_squared();
        if apart > (reach + moved) * (reach + moved) {
            return None;
        }
        first_touch(from, to, self.body.radius, &start, &end).map(|touch| Contact {
            fraction: touch.fraction,
            bearing: libm::atan2(touch.local.y, touch.local.x),
            ahead: touch.local.x,
            aside: touch.local.y,
            impact_speed: ego.speed + (self.ego.speed - ego.speed) * touch.fraction,
        })
    }

    fn obey_signs(&mut self) {
        let reach = self.blueprint.half_length + 4.0;
        for sign in &self.town.speed_signs {
            let offset = sign.trigger.pose.position() - self.ego.pose.position();
            if offset.norm_squared() < reach * reach && sign.trigger.overlaps(&self.ego.outline(&self.blueprint)) {
                self.speed_limit = sign.limit;
            }
        }
    }
}
