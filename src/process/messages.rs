use std::io::{self, BufRead, BufReader, Read};
use std::process::ChildStderr;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::find::missing_package;
use super::notes::Notes;
use world::av::external::Program;

/// The number of bytes of a line that are passed on at once.
const MAX_LINE: u64 = 1 << 13;
/// Time for the last messages to arrive after the driver has ended.
const LAST: Duration = Duration::from_millis(200);

/// What a driver writes to its standard error, which is passed on to ours up to a limit and without commands to the terminal. The rest is read
/// and dropped, so that the driver never waits for it.
pub(super) struct Messages(JoinHandle<()>);

impl Messages {
    /// Starts to pass on.
    pub fn pass_on(from: ChildStderr, notes: Notes, program: Program) -> io::Result<Self> {
        let work = move || {
            let (mut from, mut line) = (BufReader::new(from), Vec::new());
            loop {
                line.clear();
                match from.by_ref().take(MAX_LINE).read_until(b'\n', &mut line) {
                    Ok(0) => return,
                    Ok(_) => {
                        notes.pass_on(&line);
                        if String::from_utf8_lossy(&line).contains("No module named 'falsify_av'") {
                            notes.say(&program, &missing_package(&program.words));
                        }
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(_) => return,
                }
            }
        };
        thread::Builder::new().name("messages of a driver".into()).spawn(work).map(Self)
    }

    /// Waits for the last messages, but not for a process that keeps the pipe open.
    pub fn finish(self) {
        let begun = Instant::now();
        while !self.0.is_finished() && begun.elapsed() < LAST {
            thread::sleep(Duration::from_millis(1));
        }
    }
}
