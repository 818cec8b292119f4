use std::sync::Arc;

use super::binary::{self, Room};
use super::message::{self, Decision, Encoding, Greeting, Hello, PROTOCOL, Pedals, Vehicle};
use super::{Link, Opener, Program};
use crate::av::view::View;
use crate::av::{Fault, Perception};

/// Longest line of a driver's answer (bytes).
const LONGEST_LINE: usize = 1 << 20;
/// The number of bytes of a wrong answer that are shown.
const SHOWN: usize = 200;

/// The settings of the exchange with an external driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Time for the answer to a tick (s).
    pub timeout: f64,
    /// Time for the greeting (s).
    pub start_timeout: f64,
    /// The number of episodes at the same time.
    pub worlds: usize,
    /// The greatest number of road users in a message.
    pub actors: usize,
    /// The greatest number of points of the route in a message.
    pub route_points: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { timeout: 1.0, start_timeout: 30.0, worlds: 32, actors: 8, route_points: 20 }
    }
}

/// A running driver with the requests of a tick, and the answers.
pub(super) struct Session {
    opener: Arc<dyn Opener>,
    program: Program,
    settings: Settings,
    connection: Option<Connection>,
    /// How many times the driver has been started.
    generation: u64,
    /// Why it could not be started; the next episode tries again.
    refusal: Option<Fault>,
    worlds: u32,
    asked: Vec<u32>,
    request: Vec<u8>,
    answer: Vec<u8>,
    decisions: Vec<Decision>,
    outcome: Option<Result<(), Fault>>,
}

struct Connection {
    link: Box<dyn Link>,
    encoding: Encoding,
    control: Pedals,
}

impl Session {
    pub fn new(opener: Arc<dyn Opener>, program: Program, settings: Settings) -> Self {
        Self {
            opener,
            program,
            settings,
            connection: None,
            generation: 0,
            refusal: None,
            worlds: 0,
            asked: Vec::new(),
            request: Vec::new(),
            answer: Vec::new(),
            decisions: Vec::new(),
            outcome: None,
        }
    }

    /// A number for one more world.
    pub fn enter(&mut self) -> u32 {
        self.worlds += 1;
        self.worlds - 1
    }

    /// Allows another start of the driver after a failed one.
    pub fn forgive(&mut self) {
        self.refusal = None;
    }

    /// Starts the driver if it does not run; returns the number of its starts.
    pub fn ready(&mut self, perception: &Perception<'_>) -> Result<u64, Fault> {
        if let Some(fault) = self.refusal {
            return Err(fault);
        }
        if self.connection.is_none() {
            self.generation += 1;
            match self.greet(perception) {
                Ok(connection) => self.connection = Some(connection),
                Err(fault) => {
                    self.refusal = Some(fault);
                    return Err(fault);
                }
            }
        }
        Ok(self.generation)
    }

    fn greet(&mut self, perception: &Perception<'_>) -> Result<Connection, Fault> {
        let settings = &self.settings;
        let mut link = self.opener.open(&self.program)?;
        let hello = Hello {
            r#type: "hello",
            protocol: PROTOCOL,
            tick_s: perception.dt,
            town: &perception.town.name,
            vehicle: Vehicle::new(perception),
            worlds: settings.worlds,
            actors: settings.actors,
            route_points: settings.route_points,
        };
        let mut line = serde_json::to_vec(&hello).expect("numbers and words have a form in JSON");
        line.push(b'\n');
        link.send(&line, settings.start_timeout)?;
        line.clear();
        link.line(&mut line, LONGEST_LINE)?;
        let greeting: Result<Greeting, Fault> =
            serde_json::from_slice(&line).map_err(|_| Fault::Greeting("not the JSON of a greeting"));
        let greeting = greeting.and_then(|greeting| match greeting.protocol == PROTOCOL {
            true => Ok(greeting),
            false => Err(Fault::Greeting("another protocol than falsify-av/1")),
        });
        match greeting {
            Ok(Greeting { encoding, control, .. }) => Ok(Connection { link, encoding, control }),
            Err(fault) => {
                link.note(&format!("{fault}: {}", shown(&line)));
                Err(fault)
            }
        }
    }

    /// Adds a world's request to those of this tick; returns its index among them.
    pub fn ask(&mut self, id: u32, tick: u32, seed: Option<u64>, view: &View) -> usize {
        let encoding = self.connection.as_ref().map_or(Encoding::Json, |connection| connection.encoding);
        if self.outcome.take().is_some() {
            self.asked.clear();
            self.request.clear();
        }
        match encoding {
            Encoding::Json => {
                let before: &[u8] = if self.asked.is_empty() { br#"{"type":"step","worlds":["# } else { b"," };
                self.request.extend_from_slice(before);
                message::write_world(&mut self.request, id, tick, seed, view);
            }
            Encoding::Binary => {
                if self.asked.is_empty() {
                    // The length is known after all requests.
                    self.request.extend_from_slice(&[0; 4]);
                }
                let room = Room { actors: self.settings.actors, points: self.settings.route_points };
                binary::write_world(&mut self.request, id, tick, seed, view, room);
            }
        }
        self.asked.push(id);
        self.asked.len() - 1
    }

    /// The answer to the request at this index; the first call of a tick sends all requests.
    pub fn answer(&mut self, place: usize) -> Result<Decision, Fault> {
        let outcome = match self.outcome {
            Some(outcome) => outcome,
            None => {
                let outcome = self.exchange();
                if outcome.is_err() {
                    // Anything it sends later would not be the answer to a later request.
                    self.connection = None;
                }
                *self.outcome.insert(outcome)
            }
        };
        outcome.map(|()| self.decisions[place])
    }

    fn exchange(&mut self) -> Result<(), Fault> {
        let Some(Connection { link, encoding, control }) = &mut self.connection else { return Err(Fault::Ended) };
        let limit = self.settings.timeout;
        self.answer.clear();
        let read = match encoding {
            Encoding::Json => {
                self.request.extend_from_slice(b"]}\n");
                link.send(&self.request, limit)?;
                link.line(&mut self.answer, LONGEST_LINE)?;
                message::read_decisions(&self.answer, &self.asked, &mut self.decisions)
            }
            Encoding::Binary => {
                let length = (self.request.len() - 4) as u32;
                self.request[..4].copy_from_slice(&length.to_le_bytes());
                link.send(&self.request, limit)?;
                let mut length = [0; 4];
                link.exact(&mut length)?;
                self.answer.resize(binary::answer_length(self.asked.len()), 0);
                if u32::from_le_bytes(length) as usize == self.answer.len() {
                    link.exact(&mut self.answer)?;
                    binary::read_decisions(&self.answer, &self.asked, *control, &mut self.decisions)
                } else {
                    Err(Fault::Answer("a length other than four numbers for each world"))
                }
            }
        };
        if let Err(fault) = read {
            match encoding {
                Encoding::Json => link.note(&format!("{fault}: {}", shown(&self.answer))),
                Encoding::Binary => link.note(&fault.to_string()),
            }
        }
        read
    }
}

/// The start of a driver's answer, in printable characters.
fn shown(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(&said[..said.len().min(SHOWN)]).replace(char::is_control, " ");
    let dots = if said.len() > SHOWN { "…" } else { "" };
    format!("`{text}{dots}`")
}
