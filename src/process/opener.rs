use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::notes::Notes;
use world::av::Fault;
use world::av::external::{Link, Opener, Program};

/// Starts drivers as child processes, and reports their errors on the error stream.
#[derive(Debug, Clone, Default)]
pub struct ProcessOpener {
    notes: Notes,
    asks: bool,
    /// The first greeting of each program.
    greetings: Arc<Mutex<BTreeMap<String, String>>>,
}

impl Opener for ProcessOpener {
    fn find(&self, program: &Program) -> Result<(), String> {
        super::find::find(program)
    }

    fn digests(&self, program: &Program) -> Result<BTreeMap<String, String>, String> {
        super::digests::digests(program)
    }

    fn greets_as_before(&self, program: &Program, greeting: &str) -> bool {
        let mut greetings = self.greetings.lock().unwrap_or_else(PoisonError::into_inner);
        greetings.entry(format!("{program:?}")).or_insert_with(|| greeting.into()) == greeting
    }

    fn asks(&self) -> bool {
        self.asks
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        self.start(program)
    }
}

impl ProcessOpener {
    /// Of a program, not of a library: what it starts ends with this process, also what has lost its parent, and it may ask before a run.
    pub fn of_program() -> Self {
        #[cfg(target_os = "linux")]
        super::descendants::adopt();
        Self::default().asking()
    }

    /// The same; it may start a program before a run to ask what that can do.
    pub fn asking(self) -> Self {
        Self { asks: true, ..self }
    }

    #[cfg(unix)]
    fn start(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        match super::child::Child::start(program, self.notes.clone()) {
            Ok(child) => Ok(Box::new(child)),
            Err(error) => {
                self.notes.say(program, &error.to_string());
                Err(Fault::NotStarted)
            }
        }
    }

    #[cfg(not(unix))]
    fn start(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        self.notes.say(program, "drivers as processes need a Unix system");
        Err(Fault::NotStarted)
    }
}
