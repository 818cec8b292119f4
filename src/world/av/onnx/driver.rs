use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Model;
use super::engine::{Batch, Engine};
use crate::av::view::View;
use crate::av::{DrivingMode, DrivingPolicy, Fault, Path, Perception};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// A learnt driver: a network in an ONNX file that receives what it sees and gives pedals or acceleration and steer
    /// (`scenarios/external/README.md`).
    pub struct OnnxKeys = "onnx" {
        /// The file.
        model: String as Path,
        /// The output that drives, where the file has several.
        output: Option<String>,
        /// Episodes that run at the same time.
        worlds: usize as whole(1, 1024) = "32",
    }
}

/// A learnt driver; see the module.
pub struct Onnx {
    model: Arc<Model>,
    shared: Arc<Mutex<Shared>>,
    worlds: usize,
    path: Path,
    view: View,
    /// What a recurrent network carries to the next tick.
    memory: Vec<f32>,
    asked: Option<usize>,
    fault: Option<Fault>,
}

/// The network with the requests of a tick. Copies in a batch share them; a snapshot, which other threads may drive at other times, shares the
/// network alone.
struct Shared {
    engine: Arc<Mutex<Engine>>,
    batch: Batch,
    answered: bool,
}

impl Onnx {
    /// Makes one for batches of this number of episodes.
    pub fn new(worlds: usize, model: Arc<Model>) -> Self {
        let network = model.clone();
        let engine = Engine::new(move |numbers, options| network.decide(numbers, options));
        Self::within(model, Shared::new(Arc::new(Mutex::new(engine))), worlds)
    }

    fn within(model: Arc<Model>, shared: Arc<Mutex<Shared>>, worlds: usize) -> Self {
        let (path, view, memory) = (Path::default(), View::default(), vec![0.0; model.carried()]);
        Self { model, shared, worlds, path, view, memory, asked: None, fault: None }
    }
}

impl Shared {
    fn new(engine: Arc<Mutex<Engine>>) -> Arc<Mutex<Self>> {
        Arc::new(Mutex::new(Self { engine, batch: Batch::default(), answered: false }))
    }
}

/// The shared state is consistent between two calls, even if the thread that made them panicked.
fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl DrivingPolicy for Onnx {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.memory.fill(0.0);
        self.asked = None;
        self.fault = None;
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        self.path.advance(perception);
        let (actors, points) = self.model.room();
        self.view.look(perception, &self.path, actors, points);
        let mut shared = locked(&self.shared);
        if std::mem::take(&mut shared.answered) {
            shared.batch.questions.clear();
        }
        shared.batch.questions.push(self.model.encode(&self.view, &self.memory));
        self.asked = Some(shared.batch.questions.len() - 1);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        if self.asked.is_none() {
            self.prepare(perception);
        }
        let place = self.asked.take().unwrap_or_default();
        let mut shared = locked(&self.shared);
        let Shared { engine, batch, answered } = &mut *shared;
        if !*answered {
            locked(engine).answer(batch);
            *answered = true;
        }
        match &batch.answers[place] {
            Ok(numbers) => {
                let (driven, memory) = numbers.split_at(numbers.len() - self.memory.len());
                self.memory.copy_from_slice(memory);
                control(driven, perception)
            }
            Err(fault) => {
                self.fault = Some(*fault);
                Control::FULL_BRAKE
            }
        }
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Unknown
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        let engine = locked(&self.shared).engine.clone();
        let copy = Self::within(self.model.clone(), Shared::new(engine), self.worlds);
        Some(Box::new(Self { path: self.path.clone(), memory: self.memory.clone(), fault: self.fault, ..copy }))
    }

    fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(Self::within(self.model.clone(), self.shared.clone(), self.worlds)))
    }

    fn batch_size(&self) -> usize {
        self.worlds
    }
}

/// The control for a network's two or three numbers.
pub fn control(numbers: &[f32], perception: &Perception<'_>) -> Control {
    match *numbers {
        [throttle, brake, steer] => Control {
            throttle: f64::from(throttle).clamp(0.0, 1.0),
            brake: f64::from(brake).clamp(0.0, 1.0),
            steer: f64::from(steer).clamp(-1.0, 1.0),
        },
        [acceleration, steer] => {
            let steer = f64::from(steer).clamp(-1.0, 1.0);
            Control { steer, ..perception.pedals_or_hold(f64::from(acceleration)) }
        }
        _ => Control::FULL_BRAKE,
    }
}
