use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use world::av::Fault;
use world::av::external::{Link, Opener, Program};

/// Maximum number of notes about programs that are printed.
const MAX_NOTES: usize = 20;

/// Starts drivers as child processes, and reports their errors on the error stream.
#[derive(Debug, Clone, Default)]
pub struct ProcessOpener {
    notes: Notes,
}

impl Opener for ProcessOpener {
    fn find(&self, program: &Program) -> Result<(), String> {
        super::find::find(program)
    }

    fn digests(&self, program: &Program) -> Result<BTreeMap<String, String>, String> {
        super::digests::digests(program)
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        self.start(program)
    }
}

impl ProcessOpener {
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

/// Prints notes up to a maximum. A repeated note is printed once.
#[derive(Debug, Clone, Default)]
pub(super) struct Notes(Arc<Mutex<(usize, String)>>);

impl Notes {
    /// Prints a note about a program.
    pub fn say(&self, program: &Program, text: &str) {
        let mut said = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, last) = &mut *said;
        if last == text {
            return;
        }
        last.clear();
        last.push_str(text);
        *count += 1;
        if *count <= MAX_NOTES {
            // A name may hold commands to the terminal.
            let command =
                program.words.join(" ").replace(|c: char| c.is_control() || ('\u{202a}'..'\u{206a}').contains(&c), " ");
            anstream::eprintln!("program `{command}`: {text}");
        } else if *count == MAX_NOTES + 1 {
            anstream::eprintln!("more notes about programs are left out");
        }
    }
}
