//! Another simulator as the world of an episode: a program that moves the car, and that is told where each pedestrian is.
//!
//! ```text
//! LocalSimulation ── Bridge ── Peer ── Link ──> the program ──> another simulator
//!   drivers, gaits,   messages,          (pipes, deadlines:
//!   contacts, judges  checks              given from above)
//! ```
//! Drivers, pedestrians, contacts, signals and verdicts stay ours: they see the poses that come back. The protocol is described in
//! `docs/src/how-to/bridge.md`. A program cannot copy its state, so an episode in it has no snapshot.

mod bridge;
mod delay;
mod message;
mod odometer;

use std::sync::{Arc, Mutex, PoisonError};

use crate::Scenario;
use base::keys;
use road::Town;
use world::av::Fault;
use world::av::external::{Opener, Peer, Program, ProgramKeys};

pub(super) use bridge::Bridge;
pub use message::{Abilities, HERE, PROTOCOL};

keys! {
    /// A program that bridges to another simulator over its standard input and output (`docs/src/how-to/bridge.md`): it loads the map, moves the car, and
    /// places the pedestrian. It is started only where `--allow-external` is given; a check starts it to ask what the simulator can do.
    pub struct BridgeKeys = "bridge" {
        ..program: ProgramKeys,
    }
    .explained("timeout", "Time that it has for a tick.")
    .explained("start_timeout", "Time that it has for its greeting, and for loading a town.")
}

/// Writes the map of a town in OpenDRIVE; the error is the reason why it cannot, as a part of a sentence.
pub type MapWriter = dyn Fn(&Town) -> Result<String, String> + Send + Sync;

/// Another simulator: the program that bridges to it, and what that says about it.
#[derive(Clone)]
pub struct ExternalWorld {
    program: Program,
    opener: Arc<dyn Opener>,
    /// Time for a tick (s).
    timeout: f64,
    /// Time for the greeting, and for loading a town (s).
    start_timeout: f64,
    write_map: Arc<MapWriter>,
    /// Programs that have a town and no episode, for all towns.
    idle: Arc<Mutex<Vec<Loaded>>>,
    /// What its greeting said; `None` if it was not asked.
    pub abilities: Option<Abilities>,
}

/// A running program that has loaded a town.
struct Loaded {
    peer: Peer,
    /// The message with the town.
    load: Vec<u8>,
    /// Whether its brake was tried.
    has_braked: bool,
}

/// Maximum number of idle programs: MetaDrive takes 0.3 GB, and seconds to load a town.
const MAX_IDLE: usize = 6;

/// How far the lanes of another simulator are from those of a town (m), at places on the middle of lanes outside junctions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneMatch {
    /// Number of places.
    pub places: usize,
    /// Mean distance.
    pub mean: f64,
    /// Maximum distance.
    pub farthest: f64,
}

impl ExternalWorld {
    /// Makes one. If the opener asks, the program is started, asked what its simulator can do, and ended.
    ///
    /// # Errors
    /// It cannot be started, does not answer in time, or answers something else.
    pub fn new(
        program: Program,
        keys: &ProgramKeys,
        opener: Arc<dyn Opener>,
        write_map: Arc<MapWriter>,
    ) -> Result<Self, Fault> {
        let (timeout, start_timeout) = (keys.timeout, keys.start_timeout);
        let mut abilities = None;
        if opener.asks() {
            let greeted = |line: &[u8]| {
                abilities = Some(message::read_greeting(line)?);
                Ok(())
            };
            let mut peer = Peer::new(opener.clone(), program.clone(), start_timeout);
            peer.ready(message::hello, &message::GREETING, greeted)?;
        }
        Ok(Self { program, opener, timeout, start_timeout, write_map, idle: Arc::default(), abilities })
    }

    /// Compares the lanes of the town of a scenario, by starting the program; `None` if the simulator has no lanes.
    ///
    /// # Errors
    /// The program failed, or the lanes are farther apart than an episode allows.
    pub fn lanes(self: &Arc<Self>, scenario: &Scenario) -> Result<Option<LaneMatch>, Fault> {
        Bridge::new(self.clone()).start(scenario)
    }

    /// An idle program that has loaded what this message says.
    fn take(&self, load: &[u8]) -> Option<Loaded> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let place = idle.iter().position(|other| other.load == load)?;
        Some(idle.remove(place))
    }

    /// A new program.
    fn peer(&self) -> Peer {
        Peer::new(self.opener.clone(), self.program.clone(), self.start_timeout)
    }

    /// Keeps a program for later episodes, instead of the one that has been idle longest.
    fn keep(&self, loaded: Loaded) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(loaded);
        // Its end may take a while.
        let oldest = if idle.len() > MAX_IDLE { Some(idle.remove(0)) } else { None };
        drop(idle);
        drop(oldest);
    }

    /// The map of a town in OpenDRIVE.
    ///
    /// # Errors
    /// It cannot be written; the reason is a part of a sentence.
    pub fn map(&self, town: &Town) -> Result<String, String> {
        (self.write_map)(town)
    }
}
