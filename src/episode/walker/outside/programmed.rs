use std::sync::{Arc, Mutex, PoisonError};

use rand::Rng;

use super::carry_out;
use super::message::{GREETING, Hello, read_action, read_greeting, write_request};
use crate::Scene;
use crate::walker::WalkPolicy;
use base::keys;
use base::seed::Stream;
use world::av::Fault;
use world::av::external::{Opener, Peer, Program, ProgramKeys};
use world::sim::WalkCommand;

keys! {
    /// A program of your own that receives states and answers with actions over its standard input and output
    /// (`scenarios/external/README.md`). It is started only where `--allow-external` is given.
    pub struct ProgrammedKeys = "external" {
        ..program: ProgramKeys,
    }
    .explained("timeout", "Time that it has for the answer to a decision.")
}

/// A controller that is a separate program: at every decision it gets the state and gives an action.
pub struct Programmed {
    session: Arc<Mutex<Session>>,
    id: u32,
    /// The seed of an episode that has not been sent to the program.
    seed: Option<u64>,
    /// The number of the program's start in which the episode started.
    generation: u64,
    state: Vec<f64>,
    action: Vec<f64>,
    fault: Option<Fault>,
}

/// A running program, for the episodes of one evaluation.
struct Session {
    peer: Peer,
    /// Time for an answer (s).
    timeout: f64,
    worlds: u32,
    request: Vec<u8>,
    answer: Vec<u8>,
}

impl Programmed {
    /// Makes one with limits for an answer and for the greeting (s). The program is not started before the first decision.
    pub fn new(program: Program, timeout: f64, start_timeout: f64, opener: Arc<dyn Opener>) -> Self {
        let peer = Peer::new(opener, program, start_timeout);
        let session = Session { peer, timeout, worlds: 0, request: Vec::new(), answer: Vec::new() };
        Self::within(Arc::new(Mutex::new(session)))
    }

    fn within(session: Arc<Mutex<Session>>) -> Self {
        let id = {
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            session.worlds += 1;
            session.worlds - 1
        };
        Self { session, id, seed: None, generation: 0, state: Vec::new(), action: Vec::new(), fault: None }
    }

    fn ask(&mut self, scene: &Scene<'_>) -> Result<(), Fault> {
        self.state.resize(scene.obs_dim(), 0.0);
        self.action.resize(scene.bounds().len(), 0.0);
        scene.write_state(&mut self.state);
        let mut session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
        let Session { peer, timeout, request, answer, .. } = &mut *session;
        let hello = || serde_json::to_vec(&Hello::new(scene)).expect("numbers and words have a form in JSON");
        let generation = peer.ready(hello, &GREETING, read_greeting)?;
        let seed = self.seed.take();
        if seed.is_some() {
            self.generation = generation;
        } else if self.generation != generation {
            return Err(Fault::Restarted);
        }
        write_request(request, self.id, seed, &self.state, scene);
        let (id, action) = (self.id, &mut self.action);
        peer.exchange(request, *timeout, answer, |line| read_action(line, id, action)).inspect_err(|_| peer.end())
    }
}

impl WalkPolicy for Programmed {
    fn begin(&mut self, mut stream: Stream) {
        // Numbers in every language represent 53 bits exactly.
        self.seed = Some(stream.next_u64() >> 11);
        self.fault = None;
        self.session.lock().unwrap_or_else(PoisonError::into_inner).peer.forgive();
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let asked = self.ask(scene);
        self.fault = carry_out(scene, asked.map(|()| self.action.as_mut_slice()), commands);
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(Self::within(self.session.clone())))
    }
}
