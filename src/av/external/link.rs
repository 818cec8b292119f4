use super::Program;
use crate::av::Fault;

/// A connection to a driver that runs elsewhere: a message out, an answer in.
///
/// Dropping it ends the driver.
pub trait Link: Send {
    /// Sends a message. The answer has to be complete within the limit (s), which begins now.
    ///
    /// # Errors
    /// The driver has ended, or does not take the message in time.
    fn send(&mut self, message: &[u8], limit: f64) -> Result<(), Fault>;

    /// Receives a line without its end into an empty buffer.
    ///
    /// # Errors
    /// It does not come in time, the driver has ended, or the line is longer than the limit (bytes).
    fn line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault>;

    /// Receives exactly as many bytes as the buffer is long.
    ///
    /// # Errors
    /// They do not come in time, or the driver has ended.
    fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Fault>;

    /// Tells people about something that the driver did wrong.
    fn note(&self, text: &str) {
        let _ = text;
    }
}

/// Starts drivers.
pub trait Opener: Send + Sync {
    /// Looks whether a program could be started, without starting it.
    ///
    /// # Errors
    /// What is missing, as half a sentence.
    fn find(&self, program: &Program) -> Result<(), String> {
        let _ = program;
        Ok(())
    }

    /// Digests the files that the words of a command name, so that results of a changed program are not reused.
    fn digest(&self, program: &Program) -> [u8; 32] {
        let _ = program;
        [0; 32]
    }

    /// Starts one.
    ///
    /// # Errors
    /// [`Fault::NotStarted`].
    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault>;
}
