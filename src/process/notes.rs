use std::sync::{Arc, Mutex, PoisonError};

use base::printable::printable;
use world::av::external::Program;

/// Maximum number of notes about programs that are printed.
const MAX_NOTES: usize = 20;
/// Maximum number of bytes that are passed on of what programs write to their standard error, of all starts together.
#[cfg(unix)]
const MAX_BYTES: usize = 1 << 20;

/// Prints notes, and what programs write, up to a maximum. A repeated note is printed once.
#[derive(Debug, Clone, Default)]
pub(super) struct Notes(Arc<Mutex<Said>>);

#[derive(Debug, Default)]
struct Said {
    /// The number of notes, and the last one.
    count: usize,
    last: String,
    /// The number of bytes that were passed on.
    #[cfg(unix)]
    bytes: usize,
}

impl Notes {
    /// Passes on what a program wrote, without commands to the terminal.
    #[cfg(unix)]
    pub fn pass_on(&self, written: &[u8]) {
        let mut said = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if said.bytes >= MAX_BYTES {
            return;
        }
        said.bytes += written.len();
        let text = String::from_utf8_lossy(written).replace("\r\n", "\n").replace('\r', "\n");
        anstream::eprint!("{}", printable(&text));
        if said.bytes >= MAX_BYTES {
            anstream::eprintln!("\nfurther messages of programs are left out, after {} KiB", MAX_BYTES >> 10);
        }
    }

    /// Prints a note about a program.
    pub fn say(&self, program: &Program, text: &str) {
        let mut said = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Said { count, last, .. } = &mut *said;
        if last == text {
            return;
        }
        last.clear();
        last.push_str(text);
        *count += 1;
        if *count <= MAX_NOTES {
            let command = program.words.join(" ").replace('\n', " ");
            // Both may hold commands to the terminal.
            anstream::eprintln!("{}", printable(&format!("program `{command}`: {text}")));
        } else if *count == MAX_NOTES + 1 {
            anstream::eprintln!("more notes about programs are left out");
        }
    }
}
