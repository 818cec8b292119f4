use std::collections::BTreeMap;

use super::Program;
use crate::av::Fault;

/// A connection to a driver that runs elsewhere: it sends a message and receives an answer.
///
/// Dropping it ends the driver.
pub trait Link: Send {
    /// Sends a message. The answer must be complete within the limit (s), which starts now.
    ///
    /// # Errors
    /// The driver has ended, or does not accept the message in time.
    fn send(&mut self, message: &[u8], limit: f64) -> Result<(), Fault>;

    /// Receives a line without its line end into an empty buffer.
    ///
    /// # Errors
    /// It does not come in time, the driver has ended, or the line is longer than the limit (bytes).
    fn line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault>;

    /// Receives exactly as many bytes as the buffer holds.
    ///
    /// # Errors
    /// They do not come in time, or the driver has ended.
    fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Fault>;

    /// Reports a mistake of the driver to the user.
    fn note(&self, text: &str) {
        let _ = text;
    }
}

/// Starts drivers.
pub trait Opener: Send + Sync {
    /// Checks whether a program could be started, without starting it.
    ///
    /// # Errors
    /// The missing part, as half a sentence.
    fn find(&self, program: &Program) -> Result<(), String> {
        let _ = program;
        Ok(())
    }

    /// BLAKE3 of the declared files of a program in hexadecimal digits, by their paths relative to its folder. Results belong to them.
    ///
    /// # Errors
    /// A file cannot be read, as a part of a sentence.
    fn digests(&self, program: &Program) -> Result<BTreeMap<String, String>, String> {
        let _ = program;
        Ok(BTreeMap::new())
    }

    /// Whether a program greets with what it said when it was started first.
    fn greets_as_before(&self, program: &Program, greeting: &str) -> bool {
        let _ = (program, greeting);
        true
    }

    /// Whether a program may be started to ask what it can do, before anything is run. Editors start nothing.
    fn asks(&self) -> bool {
        false
    }

    /// Starts one.
    ///
    /// # Errors
    /// [`Fault::NotStarted`].
    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault>;
}
