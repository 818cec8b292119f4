use rand::RngExt;
use std::f64::consts::{FRAC_PI_3, PI};

use super::SensorModel;
use super::track::moved;
use crate::av::Actor;
use crate::sim::PedestrianBody;
use base::seed::{Seed, Stream};
use road::geometry::{Point, Pose, Vector};

/// Least and greatest distance of a false alarm from the ego (m), and greatest angle from its heading (rad): an assumption.
const DISTANCE: (f64, f64) = (5.0, 30.0);
const BEARING: f64 = FRAC_PI_3;

/// A false alarm: a pedestrian that does not exist, at most one at a time, at rest or walking straight.
#[derive(Debug, Clone)]
pub struct Ghost {
    actor: Option<Actor>,
    stream: Stream,
}

impl Ghost {
    /// Starts without one.
    pub fn new(seed: Seed) -> Self {
        Self { actor: None, stream: seed.child("false_alarms").stream() }
    }

    /// Draws from below another seed from now on.
    pub fn reseed(&mut self, seed: Seed) {
        self.stream = seed.child("false_alarms").stream();
    }

    /// Advances by the time `dt` (s) to the next update of an ego at this pose.
    pub fn update(&mut self, model: &SensorModel, ego: &Pose, dt: f64) -> Option<Actor> {
        let [change, distance, bearing, heading]: [f64; 4] = self.stream.random();
        self.actor = match self.actor {
            Some(_) if change < dt / model.keys.false_alarm_length => None,
            Some(actor) => Some(moved(&actor, dt)),
            None if change < dt * model.keys.false_alarms => {
                let distance = DISTANCE.0 + distance * (DISTANCE.1 - DISTANCE.0);
                let (sin, cos) = libm::sincos(BEARING * (2.0 * bearing - 1.0));
                let place = ego.to_world(Vector::new(distance * cos, distance * sin));
                Some(walker(place, PI * (2.0 * heading - 1.0), model.keys.walking_speed))
            }
            None => None,
        };
        self.actor.filter(|actor| model.covers(ego, actor.pose.position()).is_some())
    }
}

fn walker(place: Point, heading: f64, speed: f64) -> Actor {
    let body = PedestrianBody::adult();
    let pose = Pose::new(place.x, place.y, heading);
    let half = Vector::new(body.radius, body.radius);
    let velocity = pose.forward() * speed;
    Actor { id: Actor::FALSE_ALARM, pose, velocity, half, height: body.half_height }
}
