use std::io::{self, Read, Write};
use std::process::ChildStderr;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Maximum number of bytes of a driver's messages that are passed on.
const MAX_BYTES: usize = 1 << 20;
/// Time for the last messages to arrive after the driver has ended.
const LAST: Duration = Duration::from_millis(200);

/// What a driver writes to its standard error, which is passed on to ours up to a limit. The rest is read and dropped, so that the driver
/// never waits for it.
pub(super) struct Messages(JoinHandle<()>);

impl Messages {
    /// Starts to pass on.
    pub fn pass_on(mut from: ChildStderr) -> io::Result<Self> {
        let work = move || {
            let (mut left, mut bytes) = (MAX_BYTES, [0; 1 << 13]);
            loop {
                let count = match from.read(&mut bytes) {
                    Ok(0) => return,
                    Ok(count) => count,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                    Err(_) => return,
                };
                let shown = count.min(left);
                let _ = io::stderr().write_all(&bytes[..shown]);
                if shown < count && left > 0 {
                    anstream::eprintln!(
                        "\nfurther messages of this driver are left out, after {} KiB",
                        MAX_BYTES >> 10
                    );
                }
                left -= shown;
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
