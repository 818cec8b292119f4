use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::json;

use super::binary::{self, Room};
use super::message::{self, Decision, Encoding, Hello, PROTOCOL, Pedals, Revision, Vehicle};
use super::peer::Peer;
use super::{Opener, Program};
use crate::av::view::View;
use crate::av::{Fault, Perception};

/// The settings of the exchange with an external driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Time for the answer to a tick (s).
    pub timeout: f64,
    /// Time for the greeting (s).
    pub start_timeout: f64,
    /// The number of episodes at the same time.
    pub worlds: usize,
    /// Maximum number of road users in a message.
    pub actors: usize,
    /// Maximum number of points of the route in a message.
    pub route_points: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { timeout: 1.0, start_timeout: 30.0, worlds: 32, actors: 8, route_points: 20 }
    }
}

/// A running driver with the requests of a tick, and the answers.
pub(super) struct Session {
    peer: Peer,
    parameters: BTreeMap<String, f64>,
    settings: Settings,
    /// What the driver's last greeting said.
    encoding: Encoding,
    control: Pedals,
    /// Whether the last number of a binary answer is the angle of the front wheels.
    is_angle: bool,
    revision: Revision,
    /// The angle of the front wheels at full steer and no speed (rad).
    greatest_angle: f64,
    worlds: u32,
    asked: Vec<u32>,
    request: Vec<u8>,
    answer: Vec<u8>,
    decisions: Vec<Decision>,
    outcome: Option<Result<(), Fault>>,
    /// Whether a number out of its range was reported.
    is_clamped: bool,
}

impl Session {
    pub fn new(opener: Arc<dyn Opener>, program: Program, settings: Settings) -> Self {
        Self {
            parameters: program.parameters.clone(),
            peer: Peer::new(opener, program, settings.start_timeout),
            settings,
            encoding: Encoding::default(),
            control: Pedals::default(),
            is_angle: false,
            revision: Revision::default(),
            greatest_angle: f64::INFINITY,
            worlds: 0,
            asked: Vec::new(),
            request: Vec::new(),
            answer: Vec::new(),
            decisions: Vec::new(),
            outcome: None,
            is_clamped: false,
        }
    }

    /// A number for one more world.
    pub fn enter(&mut self) -> u32 {
        self.worlds += 1;
        self.worlds - 1
    }

    /// Allows another start of the driver after a failed one.
    pub fn forgive(&mut self) {
        self.peer.forgive();
    }

    /// Starts the driver if it does not run; returns the number of its starts.
    pub fn ready(&mut self, perception: &Perception<'_>) -> Result<u64, Fault> {
        let Self { peer, parameters, settings, encoding, control, is_angle, revision, greatest_angle, .. } = self;
        let hello = || {
            let vehicle = Vehicle::new(perception);
            *greatest_angle = vehicle.greatest_wheel_angle;
            let hello = Hello {
                r#type: "hello",
                protocol: PROTOCOL,
                tick_s: perception.dt,
                town: &perception.town.name,
                map: perception.town.map_file.as_ref().map(|map| json!({ "file": map.path, "blake3": map.blake3 })),
                vehicle,
                worlds: settings.worlds,
                actors: settings.actors,
                route_points: settings.route_points,
                revision: Revision::NEWEST,
                parameters,
            };
            serde_json::to_vec(&hello).expect("numbers and words have a form in JSON")
        };
        let greeted = |line: &[u8]| {
            let greeting = message::read_greeting(line)?;
            (*encoding, *control) = (greeting.encoding, greeting.control);
            (*is_angle, *revision) = (greeting.wheel_angle, greeting.revision);
            Ok(())
        };
        peer.ready(hello, &message::GREETING, greeted)
    }

    /// Whether messages hold the lanes along the route.
    pub fn has_lanes(&self) -> bool {
        self.revision >= Revision::Second
    }

    /// Adds a world's request to those of this tick; returns its index among them.
    pub fn ask(&mut self, id: u32, tick: u32, seed: Option<u64>, view: &View) -> usize {
        if self.outcome.take().is_some() {
            self.asked.clear();
            self.request.clear();
        }
        match self.encoding {
            Encoding::Json => {
                let before: &[u8] = if self.asked.is_empty() { br#"{"type":"step","worlds":["# } else { b"," };
                self.request.extend_from_slice(before);
                message::write_world(&mut self.request, id, tick, seed, view, self.revision);
            }
            Encoding::Binary => {
                if self.asked.is_empty() {
                    // The length is known after all requests.
                    self.request.extend_from_slice(&[0; 4]);
                }
                let room = Room { actors: self.settings.actors, points: self.settings.route_points };
                binary::write_world(&mut self.request, id, tick, seed, view, room, self.revision);
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
                    self.peer.end();
                }
                *self.outcome.insert(outcome)
            }
        };
        outcome.map(|()| self.decisions[place])
    }

    /// Sends all requests and receives the decisions. The first one that is out of its range is reported.
    fn exchange(&mut self) -> Result<(), Fault> {
        self.ask_all()?;
        let clamped = || self.decisions.iter().find_map(|decision| decision.out_of_range(self.greatest_angle));
        if !self.is_clamped
            && let Some(text) = clamped()
        {
            self.is_clamped = true;
            self.peer.link()?.note(&text);
        }
        Ok(())
    }

    fn ask_all(&mut self) -> Result<(), Fault> {
        let limit = self.settings.timeout;
        let Self { peer, request, asked, answer, decisions, control, is_angle, .. } = self;
        match self.encoding {
            Encoding::Json => {
                request.extend_from_slice(b"]}\n");
                peer.exchange(request, limit, answer, |line| message::read_decisions(line, asked, decisions))
            }
            Encoding::Binary => {
                let link = peer.link()?;
                let length = (request.len() - 4) as u32;
                request[..4].copy_from_slice(&length.to_le_bytes());
                link.send(request, limit)?;
                let mut length = [0; 4];
                link.exact(&mut length)?;
                answer.resize(binary::answer_length(asked.len()), 0);
                let read = if u32::from_le_bytes(length) as usize == answer.len() {
                    link.exact(answer)?;
                    binary::read_decisions(answer, asked, (*control, *is_angle), decisions)
                } else {
                    Err(Fault::Answer("a length other than four numbers for each world"))
                };
                read.inspect_err(|fault| link.note(&fault.to_string()))
            }
        }
    }
}
