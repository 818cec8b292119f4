use super::model::correlation;
use super::{Drift, Luck, SensorModel};
use crate::av::Actor;
use crate::sim::ActorId;
use base::seed::Seed;
use road::geometry::{Pose, Vector};

/// The knowledge and beliefs about one actor.
#[derive(Debug, Clone)]
pub struct Track {
    /// The actor that it follows.
    pub id: ActorId,
    miss: Luck,
    confusion: Luck,
    drift: Drift,
    last: Option<Belief>,
}

/// An actor as the sensors report it.
#[derive(Debug, Clone, Copy)]
pub struct Belief {
    pub actor: Actor,
    /// Whether a pedestrian is mistaken for a vehicle.
    pub confused: bool,
    /// Time since it was detected (s).
    age: f64,
}

/// The kind of actor that a track follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Pedestrian,
    Vehicle,
}

impl Track {
    /// Starts before any detection of the actor. All draws come from `seed` and the actor's number.
    pub fn new(id: ActorId, seed: &Seed) -> Self {
        let seed = seed.index(id.number() as u64);
        Self {
            id,
            miss: Luck::new(seed.child("miss").stream()),
            confusion: Luck::new(seed.child("confusion").stream()),
            drift: Drift::new(seed.child("noise").stream()),
            last: None,
        }
    }

    /// Draws from below another seed from now on; what it knows stays.
    pub fn reseed(&mut self, seed: &Seed) {
        let seed = seed.index(self.id.number() as u64);
        self.miss.reseed(seed.child("miss").stream());
        self.confusion.reseed(seed.child("confusion").stream());
        self.drift.reseed(seed.child("noise").stream());
    }

    /// Advances by the time `dt` (s) to the next update.
    pub fn advance(&mut self, model: &SensorModel, dt: f64) {
        self.miss.advance(correlation(dt, model.keys.miss_correlation));
        self.confusion.advance(correlation(dt, model.keys.confusion_correlation));
        if model.is_noisy() {
            self.drift.advance(correlation(dt, model.keys.noise_correlation));
        }
        if let Some(last) = &mut self.last {
            last.age += dt;
            last.actor = moved(&last.actor, dt);
        }
    }

    /// Updates the detection of the actor; `rate` is that of misses, `None` if it cannot be detected at all.
    pub fn update(&mut self, model: &SensorModel, kind: Kind, actor: &Actor, rate: Option<f64>) -> Option<Belief> {
        if rate.is_some_and(|rate| !self.miss.fails(rate)) {
            let confused = kind == Kind::Pedestrian && self.confusion.fails(model.keys.confusion);
            self.last = Some(Belief { actor: self.measure(model, kind, actor), confused, age: 0.0 });
        } else if self.last.is_some_and(|last| last.age > model.keys.memory) {
            self.last = None;
        }
        self.last
    }

    fn measure(&self, model: &SensorModel, kind: Kind, actor: &Actor) -> Actor {
        let mut seen = *actor;
        if kind == Kind::Pedestrian && model.keys.speed_pull > 0.0 {
            let ahead = actor.velocity.try_normalize(1e-6).unwrap_or_else(|| actor.pose.forward());
            seen.velocity = ahead
                * (actor.speed() * (1.0 - model.keys.speed_pull) + model.keys.walking_speed * model.keys.speed_pull);
        }
        if model.is_noisy() {
            let [east, north, v_east, v_north, turn, size] = *self.drift.errors();
            seen.pose = Pose::new(
                actor.pose.x + model.keys.position_noise * east,
                actor.pose.y + model.keys.position_noise * north,
                actor.pose.yaw + model.keys.heading_noise * turn,
            );
            seen.velocity += Vector::new(v_east, v_north) * model.keys.velocity_noise;
            seen.half *= libm::exp(model.keys.size_noise * size);
        }
        seen
    }
}

/// An actor moved on by its velocity for a time (s).
pub fn moved(actor: &Actor, time: f64) -> Actor {
    let place = actor.pose.position() + actor.velocity * time;
    Actor { pose: Pose { x: place.x, y: place.y, ..actor.pose }, ..*actor }
}
