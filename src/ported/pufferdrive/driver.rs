use std::sync::Arc;

use super::{Network, Observation, RoadMap, observation::CAR, polylines};
use base::seed::{Seed, Stream};
use base::{choice, keys};
use rand::RngExt;
use road::geometry::Point;
use world::av::{Actor, DrivingMode, DrivingPolicy, Perception};
use world::sim::{Control, VehicleBlueprint};

/// Pieces of the road that it sees. The network takes 200; with as many as in its training it drives better.
const PIECES: usize = 128;
/// A goal is reached within this distance (m), at most at this speed (m/s).
const REACHED: (f64, f64) = (2.0, 10.0);
const ACCELERATIONS: [f64; 7] = [-4.0, -2.667, -1.333, 0.0, 1.333, 2.667, 4.0];
const ANGLES: [f64; 13] = [-1.0, -0.833, -0.667, -0.5, -0.333, -0.167, 0.0, 0.167, 0.333, 0.5, 0.667, 0.833, 1.0];

choice! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Pedestrians {
        Shown = "shown",
        Hidden = "hidden",
        AsCars = "as_cars",
        ToWheel = "to_wheel",
        ToPedals = "to_pedals",
    }
}

keys! {
    /// PufferDrive's demo policy, a network that learnt by self-play in Town01 and Town02. It sees through walls.
    pub struct PufferDriveKeys = "pufferdrive" {
        /// The file of its weights, `puffer_drive_weights_carla_town12.bin`.
        weights: String as Path,
        /// Whether it takes the most probable action. Its demo draws one.
        greedy: bool = "false",
        /// How it sees pedestrians: in their size, not at all, in the size of its car; or in their size with its wheel or its pedals alone, while a
        /// network that does not see them moves the others.
        pedestrians: Pedestrians = "shown",
    }
    .made_for(0.05)
    .surrogate(
        "Exact: its network, what it observes, its actions and goals: points of any lane near 30 m ahead. Assumed: its world. The pieces of road are cut \
         from the town's lanes, and it cannot reverse. It learnt among 32 cars of 3.15 m × 1.40 m and never met anybody on foot: a pedestrian is a \
         small box to it. So its rates show what such a policy does where it was not trained.",
    )
}

/// PufferDrive's demo policy. Its state is zero at the start of an episode and is not reset in it, as in the demo.
#[derive(Debug, Clone)]
pub struct PufferDrive {
    network: Arc<Network>,
    keys: PufferDriveKeys,
    map: Arc<RoadMap>,
    goal: Point,
    observation: Observation,
    /// The states of the network that sees pedestrians and of the one that does not.
    states: Box<[[[f32; 256]; 2]; 2]>,
    draws: Stream,
    action: (f64, f64),
    /// Ticks until the next decision, which is held for 0.1 s.
    wait: u32,
}

impl PufferDrive {
    /// Makes one without a map until [`DrivingPolicy::reset`].
    pub fn new(network: Arc<Network>, keys: PufferDriveKeys) -> Self {
        let (map, observation, draws) = (RoadMap::new(&[]).into(), Observation::default(), Seed::root(0).stream());
        let (goal, states) = (Point::origin(), Box::new([[[0.0; 256]; 2]; 2]));
        Self { network, keys, map, goal, observation, states, draws, action: (0.0, 0.0), wait: 0 }
    }

    /// Chooses an action by a number from 0 to 1.
    fn choose(&mut self, seen: &Perception<'_>, view: Pedestrians, draw: f64) -> usize {
        let car = |actor: &Actor| Actor { half: CAR, ..*actor };
        let pedestrians = seen.pedestrians.iter().filter(|_| view != Pedestrians::Hidden);
        let pedestrians = pedestrians.map(|actor| if view == Pedestrians::AsCars { car(actor) } else { *actor });
        let others = seen.vehicles.iter().map(car).chain(pedestrians);
        self.observation.look(&seen.ego, self.goal, others, (&self.map, PIECES));
        let state = &mut self.states[usize::from(view == Pedestrians::Hidden)];
        let logits = self.network.step(&self.observation, state).map(f64::from);
        let best = logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sharpness = if self.keys.greedy { 1e9 } else { 1.0 };
        let weights = logits.map(|logit| libm::exp((logit - best) * sharpness));
        let mut left = draw * weights.iter().sum::<f64>();
        let is_chosen = |weight: &f64| {
            left -= weight;
            left < 0.0
        };
        weights.iter().position(is_chosen).unwrap_or_default()
    }
}

/// The acceleration (m/s²) and the steering angle (rad), positive to the left, of an action, 0 to 90.
pub fn action(number: usize) -> (f64, f64) {
    (ACCELERATIONS[number / ANGLES.len()], ANGLES[number % ANGLES.len()])
}

/// Pedals and wheel with which a car at a speed (m/s) does an action as its own car, which turns by its length; it does not reverse.
pub fn control((acceleration, angle): (f64, f64), blueprint: &VehicleBlueprint, speed: f64) -> Control {
    let tan = libm::tan(angle);
    let curvature = libm::cos(libm::tanh(tan / 2.0)) * tan / (2.0 * CAR.x);
    let slip = libm::asin((curvature * blueprint.wheelbase / 2.0).clamp(-0.99, 0.99));
    let steer = blueprint.steer_for(libm::atan(2.0 * libm::tan(slip)), speed);
    Control { steer, ..blueprint.pedals_for(acceleration, speed) }
}

impl DrivingPolicy for PufferDrive {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.map = perception.town.derived(|town| RoadMap::new(&polylines(town)));
        self.goal = self.map.next_goal(&perception.ego.pose);
        (*self.states, self.draws, self.wait) = ([[[0.0; 256]; 2]; 2], stream, 0);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let ego = &perception.ego;
        if self.wait == 0 {
            if (self.goal - ego.pose.position()).norm() < REACHED.0 && ego.speed() <= REACHED.1 {
                self.goal = self.map.next_goal(&ego.pose);
            }
            self.wait = (0.1 / perception.dt).round().max(1.0) as u32;
            let (view, draw) = (self.keys.pedestrians, self.draws.random());
            let seeing = self.choose(perception, view, draw);
            let mut blind = || action(self.choose(perception, Pedestrians::Hidden, draw));
            self.action = match view {
                Pedestrians::ToWheel => (blind().0, action(seeing).1),
                Pedestrians::ToPedals => (action(seeing).0, blind().1),
                Pedestrians::Shown | Pedestrians::Hidden | Pedestrians::AsCars => action(seeing),
            };
        }
        self.wait -= 1;
        control(self.action, perception.blueprint, ego.speed())
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Unknown
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.draws = stream;
    }
}
