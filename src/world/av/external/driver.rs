use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rand::Rng;

use super::session::Session;
use super::{Opener, Program, ProgramKeys, Settings};
use crate::av::emergency_brake::{BrakeKeys, Guard};
use crate::av::view::View;
use crate::av::{DrivingMode, DrivingPolicy, Fault, Path, Perception};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// A program of your own that receives what it sees and answers with controls over its standard input and output
    /// (`scenarios/external/README.md`). It is started only where `--allow-external` is given.
    pub struct ExternalKeys = "external" {
        ..program: ProgramKeys,
        /// Episodes that run at the same time, with one message for all of them.
        worlds: usize as whole(1, 1024) = "32",
        /// Largest number of road users in a message: the nearest ones in sight.
        actors: usize as whole(1, 64) = "8",
        /// Number of points of the route ahead in a message, 2 m apart.
        route_points: usize as whole(1, 40) = "20",
        /// Whether the emergency brake of the kind `aeb`, with its defaults, is in front of the program. It sees what the sensors give to the program, along
        /// the same route, and overrides the pedals where it brakes harder.
        aeb: bool = "false",
        /// Named numbers, `["gap=0.5", "width=1"]`, which its greeting tells it and `harden` varies.
        parameters: Option<Vec<String>>,
    }
    .explained("timeout", "Time that it has for the answer to a tick.")
}

impl From<ExternalKeys> for Settings {
    fn from(keys: ExternalKeys) -> Self {
        let ExternalKeys { program, worlds, actors, route_points, .. } = keys;
        Self { timeout: program.timeout, start_timeout: program.start_timeout, worlds, actors, route_points }
    }
}

/// A driver that is a program of its own; see the module.
pub struct External {
    session: Arc<Mutex<Session>>,
    settings: Settings,
    id: u32,
    path: Path,
    view: View,
    guard: Option<Guard>,
    /// The seed of an episode that has not been sent to the program.
    seed: Option<u64>,
    /// The number of the program's start in which the episode started.
    generation: u64,
    /// The index of this tick's request in the session.
    asked: Option<usize>,
    mode: DrivingMode,
    fault: Option<Fault>,
}

impl External {
    /// Makes one. The program is not started before the first tick.
    pub fn new(program: Program, settings: Settings, opener: Arc<dyn Opener>) -> Self {
        Self::within(Arc::new(Mutex::new(Session::new(opener, program, settings))), settings, None)
    }

    /// The same with an emergency brake in front of it.
    pub fn guarded(self, brake: BrakeKeys) -> Self {
        Self { guard: Some(Guard::new(brake)), ..self }
    }

    fn within(session: Arc<Mutex<Session>>, settings: Settings, guard: Option<Guard>) -> Self {
        let id = locked(&session).enter();
        Self {
            session,
            settings,
            id,
            path: Path::default(),
            view: View::default(),
            guard,
            seed: None,
            generation: 0,
            asked: None,
            mode: DrivingMode::Unknown,
            fault: None,
        }
    }

    fn ask(&mut self, perception: &Perception<'_>) -> Result<usize, Fault> {
        self.path.advance(perception);
        self.view.look(perception, &self.path, self.settings.actors, self.settings.route_points);
        if self.path.is_over(self.view.ego.position()) {
            self.view.route.clear();
        }
        let mut session = locked(&self.session);
        let generation = session.ready(perception)?;
        if session.has_lanes() {
            self.view.look_at_lanes(perception, &self.path);
        }
        let seed = self.seed.take();
        if seed.is_some() {
            self.generation = generation;
        } else if self.generation != generation {
            return Err(Fault::Restarted);
        }
        Ok(session.ask(self.id, perception.tick, seed, &self.view))
    }
}

/// A session is consistent between two calls, even if the thread that made them panicked.
fn locked(session: &Mutex<Session>) -> MutexGuard<'_, Session> {
    session.lock().unwrap_or_else(PoisonError::into_inner)
}

impl DrivingPolicy for External {
    fn reset(&mut self, perception: &Perception<'_>, mut stream: Stream) {
        // Numbers in every language represent 53 bits exactly.
        self.seed = Some(stream.next_u64() >> 11);
        self.path.reset(perception, stream);
        self.guard.iter_mut().for_each(Guard::reset);
        self.asked = None;
        self.mode = DrivingMode::Unknown;
        self.fault = None;
        locked(&self.session).forgive();
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        match self.ask(perception) {
            Ok(place) => self.asked = Some(place),
            Err(fault) => self.fault = Some(fault),
        }
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        if self.asked.is_none() && self.fault.is_none() {
            self.prepare(perception);
        }
        let Some(place) = self.asked.take() else { return Control::FULL_BRAKE };
        let decision = locked(&self.session).answer(place);
        match decision {
            Ok(decision) => {
                self.mode = decision.mode;
                let control = decision.control(perception);
                let Some(guard) = &mut self.guard else { return control };
                let (control, mode) = guard.guard(control, &self.path, perception);
                self.mode = mode.unwrap_or(self.mode);
                control
            }
            Err(fault) => {
                self.fault = Some(fault);
                Control::FULL_BRAKE
            }
        }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }

    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(Self::within(self.session.clone(), self.settings, self.guard.clone())))
    }

    fn batch_size(&self) -> usize {
        self.settings.worlds
    }
}
