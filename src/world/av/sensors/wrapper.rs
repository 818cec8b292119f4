use std::sync::Arc;

use super::ghost::Ghost;
use super::track::{Belief, Kind, Track, moved};
use super::{ConfusedAs, Prediction, SensorModel};
use crate::av::{Actor, DrivingMode, DrivingPolicy, Fault, Perception};
use crate::sim::{ActorId, Control};
use base::seed::{Seed, Stream};

/// A driver that perceives other actors only through its sensors.
///
/// Actors are distinguished by their ids ([`Actor::id`]); their order in the true perception does not matter.
pub struct SensorWrapper {
    driver: Box<dyn DrivingPolicy>,
    model: Arc<SensorModel>,
    seed: Seed,
    people: Vec<Track>,
    cars: Vec<Track>,
    ghost: Ghost,
    /// The beliefs of the last updates; the update number `n` is at `n` modulo the length.
    history: Vec<Snapshot>,
    updates: u32,
    /// The tick of the episode's start for this driver.
    began: u32,
    pedestrians: Vec<Actor>,
    vehicles: Vec<Actor>,
}

/// The beliefs of an update.
#[derive(Debug, Clone, Default)]
struct Snapshot {
    pedestrians: Vec<Actor>,
    vehicles: Vec<Actor>,
}

impl SensorWrapper {
    /// Puts sensors in front of a driver.
    pub fn new(driver: Box<dyn DrivingPolicy>, model: Arc<SensorModel>) -> Self {
        let seed = Seed::root(0);
        Self {
            driver,
            model,
            seed,
            people: Vec::new(),
            cars: Vec::new(),
            ghost: Ghost::new(seed),
            history: Vec::new(),
            updates: 0,
            began: 0,
            pedestrians: Vec::new(),
            vehicles: Vec::new(),
        }
    }

    /// Updates the sensors if it is time, and sets what reaches the driver now.
    fn look(&mut self, perception: &Perception<'_>) {
        let between = self.model.ticks_between(perception.dt);
        let tick = perception.tick.saturating_sub(self.began);
        if tick / between >= self.updates {
            self.update(perception, f64::from(between) * perception.dt);
        }
        self.pedestrians.clear();
        self.vehicles.clear();
        let Some(measured) = tick.checked_sub(self.model.ticks_late(perception.dt)) else { return };
        let number = measured / between;
        let snapshot = &self.history[number as usize % self.history.len()];
        let age = f64::from(tick - number * between) * perception.dt;
        let age = if self.model.keys.prediction == Prediction::ConstantVelocity { age } else { 0.0 };
        let now = |actor: &Actor| if age > 0.0 { moved(actor, age) } else { *actor };
        self.pedestrians.extend(snapshot.pedestrians.iter().map(now));
        self.vehicles.extend(snapshot.vehicles.iter().map(now));
    }

    fn update(&mut self, perception: &Perception<'_>, dt: f64) {
        let model = &*self.model;
        let (people, cars) = (perception.pedestrians, perception.vehicles);
        let seed = self.seed;
        let place = self.updates as usize % self.history.len();
        let snapshot = &mut self.history[place];
        snapshot.pedestrians.clear();
        snapshot.vehicles.clear();
        let first = self.updates == 0;
        let look_for = |track: &mut Track, kind: Kind, actor: &Actor| -> Option<Belief> {
            if !first {
                track.advance(model, dt);
            }
            track.update(model, kind, actor, miss_rate(model, perception, actor))
        };
        for actor in people {
            let track = track_of(&mut self.people, actor.id, || seed.child("pedestrian"));
            let Some(belief) = look_for(track, Kind::Pedestrian, actor) else { continue };
            if belief.confused {
                let half = model.confused_half();
                snapshot.vehicles.push(Actor { half, height: 0.0, ..belief.actor });
            }
            if !belief.confused || model.keys.confused_as == ConfusedAs::Both {
                snapshot.pedestrians.push(belief.actor);
            }
        }
        for actor in cars {
            let track = track_of(&mut self.cars, actor.id, || seed.child("vehicle"));
            snapshot.vehicles.extend(look_for(track, Kind::Vehicle, actor).map(|belief| belief.actor));
        }
        if model.keys.false_alarms > 0.0 {
            snapshot.pedestrians.extend(self.ghost.update(model, &perception.ego.pose, dt));
        }
        self.updates += 1;
    }
}

/// The present rate at which an actor is missed; `None` if it is outside the field or hidden.
fn miss_rate(model: &SensorModel, perception: &Perception<'_>, actor: &Actor) -> Option<f64> {
    let ego = &perception.ego.pose;
    let (distance, seam) = model.covers(ego, actor.pose.position())?;
    let visible = if model.looks() {
        let eye = model.eye(ego);
        perception.obstacles.visible_share(eye, actor.target(eye), perception.outlines_but(actor))
    } else {
        1.0
    };
    let enough = visible >= model.keys.least_visible && (visible > 0.0 || !model.looks());
    enough.then(|| model.miss_rate(distance, seam))
}

/// The track of an actor; a new one, which needs the seed of all tracks, when the actor has none.
fn track_of(tracks: &mut Vec<Track>, id: ActorId, seed: impl FnOnce() -> Seed) -> &mut Track {
    let known = tracks.iter().position(|track| track.id == id);
    let place = known.unwrap_or_else(|| {
        tracks.push(Track::new(id, &seed()));
        tracks.len() - 1
    });
    &mut tracks[place]
}

impl DrivingPolicy for SensorWrapper {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.seed = Seed::of(&stream).child("sensors");
        self.people.clear();
        self.cars.clear();
        self.ghost = Ghost::new(self.seed);
        self.updates = 0;
        self.began = perception.tick;
        let late = self.model.ticks_late(perception.dt) / self.model.ticks_between(perception.dt);
        let (people, cars) = (perception.pedestrians.len() + 1, perception.vehicles.len());
        self.history.resize_with(late as usize + 2, Snapshot::default);
        let lists = self.history.iter_mut().map(|snapshot| (&mut snapshot.pedestrians, &mut snapshot.vehicles));
        for (pedestrians, vehicles) in lists.chain([(&mut self.pedestrians, &mut self.vehicles)]) {
            pedestrians.clear();
            pedestrians.reserve(people);
            vehicles.clear();
            vehicles.reserve(people + cars);
        }
        self.look(perception);
        let believed = Perception { pedestrians: &self.pedestrians, vehicles: &self.vehicles, ..*perception };
        self.driver.reset(&believed, stream);
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        self.look(perception);
        let believed = Perception { pedestrians: &self.pedestrians, vehicles: &self.vehicles, ..*perception };
        self.driver.prepare(&believed);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.look(perception);
        let believed = Perception { pedestrians: &self.pedestrians, vehicles: &self.vehicles, ..*perception };
        self.driver.drive(&believed)
    }

    fn mode(&self) -> DrivingMode {
        self.driver.mode()
    }

    fn fault(&self) -> Option<Fault> {
        self.driver.fault()
    }

    fn world_driver(&self) -> Option<&str> {
        self.driver.world_driver()
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(Self {
            driver: self.driver.snapshot()?,
            model: self.model.clone(),
            people: self.people.clone(),
            cars: self.cars.clone(),
            ghost: self.ghost.clone(),
            history: self.history.clone(),
            pedestrians: self.pedestrians.clone(),
            vehicles: self.vehicles.clone(),
            ..*self
        }))
    }

    fn reseed(&mut self, stream: Stream) {
        self.seed = Seed::of(&stream).child("sensors");
        let seeds = (self.seed.child("pedestrian"), self.seed.child("vehicle"));
        self.people.iter_mut().for_each(|track| track.reseed(&seeds.0));
        self.cars.iter_mut().for_each(|track| track.reseed(&seeds.1));
        self.ghost.reseed(self.seed);
        self.driver.reseed(stream);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        let driver = self.driver.clone_for_batch()?;
        Some(Box::new(Self::new(driver, self.model.clone())))
    }

    fn batch_size(&self) -> usize {
        self.driver.batch_size()
    }
}
