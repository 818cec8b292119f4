use std::sync::Arc;

use super::refusal::{KeyOf, known, shown, unknown_key};
use super::{Link, Opener, Program};
use crate::av::{Exit, Fault};

/// Longest line of an answer (bytes).
const MAX_LINE: usize = 1 << 20;
/// What is said of a program that says something else of itself at a later start.
const ANOTHER: Fault = Fault::Greeting(
    "otherwise than at its first start: what it says of itself is recorded, so it must be the same at each start",
);

/// A program that is started when it is needed, and started again after a fault. It holds no message: who speaks with it knows the protocol.
pub struct Peer {
    opener: Arc<dyn Opener>,
    program: Program,
    /// Time for the greeting (s).
    start_timeout: f64,
    link: Option<Box<dyn Link>>,
    /// How many times the program has been started.
    generation: u64,
    /// Why it could not be started; the next episode tries again.
    refusal: Option<Fault>,
}

impl Peer {
    /// Makes one with a limit for its greeting (s). The program is not started.
    pub fn new(opener: Arc<dyn Opener>, program: Program, start_timeout: f64) -> Self {
        Self { opener, program, start_timeout, link: None, generation: 0, refusal: None }
    }

    /// Allows another start of the program after a failed one.
    pub fn forgive(&mut self) {
        self.refusal = None;
    }

    /// Starts the program if it does not run; returns the number of its starts. `hello` is the line that it is greeted with, and `greeted`
    /// reads the line of its answer. A key of that which is none of `keys` is noted.
    ///
    /// # Errors
    /// It cannot be started, does not answer in time, or `greeted` refuses its answer. Until [`Peer::forgive`] it is not started again.
    pub fn ready(
        &mut self,
        hello: impl FnOnce() -> Vec<u8>,
        keys: &[KeyOf],
        greeted: impl FnOnce(&[u8]) -> Result<(), Fault>,
    ) -> Result<u64, Fault> {
        if let Some(fault) = self.refusal {
            return Err(fault);
        }
        if self.link.is_none() {
            self.generation += 1;
            match self.greet(hello(), keys, greeted) {
                Ok(link) => self.link = Some(link),
                Err(fault) => {
                    self.refusal = Some(fault);
                    return Err(fault);
                }
            }
        }
        Ok(self.generation)
    }

    fn greet(
        &self,
        mut line: Vec<u8>,
        keys: &[KeyOf],
        greeted: impl FnOnce(&[u8]) -> Result<(), Fault>,
    ) -> Result<Box<dyn Link>, Fault> {
        let mut link = self.opener.open(&self.program)?;
        line.push(b'\n');
        link.send(&line, self.start_timeout).map_err(Fault::at_start)?;
        line.clear();
        link.line(&mut line, MAX_LINE).map_err(Fault::at_start)?;
        let is_same = || self.opener.greets_as_before(&self.program, &known(&line, keys));
        match greeted(&line).and_then(|()| if is_same() { Ok(()) } else { Err(ANOTHER) }) {
            Ok(()) => {
                unknown_key(&line, keys).iter().for_each(|text| link.note(text));
                Ok(link)
            }
            Err(fault) => {
                link.note(&format!("{fault}: {}", shown(&line)));
                Err(fault)
            }
        }
    }

    /// Whether it runs.
    pub fn is_running(&self) -> bool {
        self.link.is_some()
    }

    /// Its link.
    ///
    /// # Errors
    /// [`Fault::Ended`] if it does not run.
    pub fn link(&mut self) -> Result<&mut dyn Link, Fault> {
        match &mut self.link {
            Some(link) => Ok(link.as_mut()),
            None => Err(Fault::Ended(Exit::Unknown)),
        }
    }

    /// Ends the program: anything that it sends later would not be the answer to a later request.
    pub fn end(&mut self) {
        self.link = None;
    }

    /// Sends a line with its line end, and reads the line of the answer within the limit (s). `read` makes something of the answer, and
    /// the user sees an answer that it refuses.
    ///
    /// # Errors
    /// The fault of the program, or that of `read`.
    pub fn exchange<T>(
        &mut self,
        line: &[u8],
        limit: f64,
        answer: &mut Vec<u8>,
        read: impl FnOnce(&[u8]) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let link = self.link()?;
        answer.clear();
        link.send(line, limit)?;
        link.line(answer, MAX_LINE)?;
        read(answer).inspect_err(|fault| link.note(&format!("{fault}: {}", shown(answer))))
    }
}
