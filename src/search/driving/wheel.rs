use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use base::seed::Stream;
use episode::PolicyMaker;
use learn::Inputs;
use world::av::onnx::{Input, control};
use world::av::view::View;
use world::av::{DrivingMode, DrivingPolicy, Path, Perception};
use world::sim::Control;

/// The bounds of a network's acceleration (m/s²) and steer.
pub const ACTION_BOUNDS: [(f64, f64); 2] = [(-8.0, 3.0), (-1.0, 1.0)];
/// A learner's action times these is acceleration and steer: powers of two, so that nothing is rounded.
pub const ACTION_SCALES: [f64; 2] = [4.0, 0.25];

/// The road users and the points of the route that a learnt driver sees.
const ACTORS: usize = 4;
const POINTS: usize = 16;
/// Below this speed a car stands (m/s), and what it does then, in place of the brake that holds it (m/s²).
const STANDING: f64 = 0.05;
const HOLDING: f64 = -1.0;

/// The inputs in their order.
const SEEN: [Input; 3] = [Input::Ego, Input::Actors(ACTORS), Input::Route(POINTS)];
/// Divisors of the numbers of the ego, an actor and a point of the route, and how much larger those are that tell large numbers apart.
const EGO: [f64; 4] = [4.0, 8.0, 1.0, 8.0];
const ACTOR: [f64; 8] = [1.0, 6.0, 2.0, 0.5, 2.0, 1.0, 2.0, 1.0];
const POINT: [f64; 3] = [8.0, 1.0, 0.25];
const FAR: f64 = 5.0;

/// The inputs of a learnt driver's network and their scaling.
pub fn inputs() -> Inputs {
    let repeated = |row: &[f64], rows: usize| row.repeat(rows);
    let near = [EGO.to_vec(), repeated(&ACTOR, ACTORS), repeated(&POINT, POINTS)].concat();
    let far = near.iter().map(|divisor| FAR * divisor).collect();
    let shape = |input: Input| {
        let (shape, rank) = input.shape();
        shape[1..rank].to_vec()
    };
    let shapes = ["ego", "actors", "route"].iter().zip(SEEN).map(|(name, input)| ((*name).to_owned(), shape(input)));
    Inputs { shapes: shapes.collect(), divisors: vec![near, far] }
}

/// What a learner and the driver of its car share.
#[derive(Default)]
pub(super) struct Wheel {
    /// Acceleration and steer of the next tick, as a network gives them.
    pub action: [f32; 2],
    /// The numbers of a network's inputs for the present state.
    pub numbers: Vec<f32>,
    pub view: View,
    path: Path,
    /// The driver that shows what it would do.
    pub teacher: Option<Box<dyn DrivingPolicy>>,
    /// What the teacher would do now.
    pub shown: [f64; 2],
}

impl Wheel {
    fn look(&mut self, perception: &Perception<'_>) {
        self.path.advance(perception);
        self.view.look(perception, &self.path, ACTORS, POINTS);
        self.numbers.clear();
        self.numbers.extend(SEEN.iter().flat_map(|input| input.numbers(&self.view)));
        if let Some(teacher) = &mut self.teacher {
            teacher.prepare(perception);
            let control = teacher.drive(perception);
            let speed = perception.ego.speed();
            let demanded = perception.blueprint.acceleration(control, speed);
            let acceleration = if speed < STANDING && demanded <= 0.0 { HOLDING } else { demanded };
            let chosen = [acceleration, control.steer];
            self.shown = std::array::from_fn(|i| chosen[i].clamp(ACTION_BOUNDS[i].0, ACTION_BOUNDS[i].1));
        }
    }
}

/// A driver whose wheel and pedals a learner holds.
#[derive(Clone, Default)]
pub(super) struct Seat(Arc<Mutex<Wheel>>);

impl Seat {
    /// The shared state is consistent between two calls, even if the thread that made them panicked.
    pub fn wheel(&self) -> MutexGuard<'_, Wheel> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes drivers with this seat.
    pub fn policy(&self) -> PolicyMaker {
        let seat = self.clone();
        Arc::new(move || Box::new(seat.clone()))
    }
}

impl DrivingPolicy for Seat {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        let wheel = &mut *self.wheel();
        wheel.path.reset(perception, stream.clone());
        if let Some(teacher) = &mut wheel.teacher {
            teacher.reset(perception, stream);
        }
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        self.wheel().look(perception);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        control(&self.wheel().action, perception)
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Unknown
    }
}
