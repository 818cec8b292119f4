use std::collections::BTreeSet;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::process::CommandExt;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::signal::{Signal, kill, killpg};
#[cfg(target_os = "linux")]
use nix::sys::wait::{Id, WaitPidFlag, WaitStatus, waitid};
use nix::unistd::Pid;

use super::descendants;
use super::messages::Messages;
use super::notes::Notes;
use super::stopping::{self, GLANCE};
use world::av::external::{Link, Program};
use world::av::{Exit, Fault};

/// The number of bytes of one read.
const CHUNK: usize = 1 << 16;
/// Time that a child has to end after its input was closed.
const LEAVE: Duration = Duration::from_millis(500);
/// Time that a child has to end after it closed its output, so that its exit code can be told.
#[cfg(target_os = "linux")]
const FAREWELL: Duration = Duration::from_secs(1);
/// Time between two looks whether it has ended.
#[cfg(target_os = "linux")]
const LOOK: Duration = Duration::from_millis(2);

/// The running children, for an immediate end of the whole program.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// The number of children that were started, to tell them apart.
static STARTED: AtomicU64 = AtomicU64::new(0);

/// How often a child ended before it answered, or did not answer in time.
static FAILURES: AtomicU64 = AtomicU64::new(0);

/// How often a program ended before it answered, or did not answer in time.
pub fn failures() -> u64 {
    FAILURES.load(Ordering::Relaxed)
}

/// Ends all children at once, with all processes that they have started; on Linux also those that this process has adopted.
pub fn end_all() {
    let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    for id in &*running {
        let child = Pid::from_raw(*id as i32);
        let _ = killpg(child, Signal::SIGKILL);
        // It may have left its own group.
        let _ = kill(child, Signal::SIGKILL);
    }
    if !running.is_empty() {
        descendants::end(&format!("{}-", std::process::id()));
    }
    #[cfg(target_os = "linux")]
    descendants::end_children();
}

/// A child process with pipes that never block: every wait has a time limit.
pub(super) struct Child {
    program: Program,
    process: std::process::Child,
    /// Taken to close the input, which asks the child to end.
    input: Option<ChildStdin>,
    output: ChildStdout,
    /// Memory for a read. Of the bytes up to `end`, which were read, those from `used` on have not been returned yet.
    read: Box<[u8]>,
    used: usize,
    end: usize,
    limit: Duration,
    deadline: Instant,
    notes: Notes,
    /// By which processes that it has started are known.
    mark: String,
    messages: Option<Messages>,
}

impl Child {
    pub fn start(program: &Program, notes: Notes) -> io::Result<Self> {
        let mut command = Command::new(&program.words[0]);
        command.args(&program.words[1..]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mark = format!("{}-{}-", std::process::id(), STARTED.fetch_add(1, Ordering::Relaxed));
        command.process_group(0).env(descendants::MARK, &mark);
        if !program.folder.as_os_str().is_empty() {
            command.current_dir(&program.folder);
        }
        let mut process = command.spawn()?;
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).insert(process.id());
        let (input, output) = (process.stdin.take(), process.stdout.take());
        let (input, output) = input.zip(output).expect("both were asked for");
        let messages = process
            .stderr
            .take()
            .map(|from| Messages::pass_on(from, notes.clone(), program.clone()))
            .transpose()
            .inspect_err(|_| {
                let _ = killpg(Pid::from_raw(process.id() as i32), Signal::SIGKILL);
            })?;
        never_block(input.as_fd())?;
        never_block(output.as_fd())?;
        Ok(Self {
            program: program.clone(),
            process,
            input: Some(input),
            output,
            read: vec![0; CHUNK].into(),
            used: 0,
            end: 0,
            limit: Duration::ZERO,
            deadline: Instant::now(),
            notes,
            mark,
            messages,
        })
    }

    fn late(&self) -> Fault {
        Fault::Late { limit_ms: self.limit.as_millis() as u32 }
    }

    /// Waits until a pipe is ready, the time is up, or the user does not want to wait any more.
    fn wait(&self, pipe: BorrowedFd<'_>, what: PollFlags) -> Result<(), Fault> {
        loop {
            let left = self.deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(self.late());
            }
            if stopping::is_over() {
                return Err(Fault::Stopped);
            }
            // Rounded up, so that the last wait does not spin.
            let left = left.min(GLANCE) + Duration::from_millis(1);
            match poll(&mut [PollFd::new(pipe, what)], PollTimeout::try_from(left).unwrap_or(PollTimeout::MAX)) {
                Ok(0) => {}
                Ok(_) | Err(nix::errno::Errno::EINTR) => return Ok(()),
                Err(_) => return Err(Fault::Ended(Exit::Unknown)),
            }
        }
    }

    /// Whether there is output that nothing has asked for.
    fn has_spoken(&mut self) -> bool {
        let mut pipe = [PollFd::new(self.output.as_fd(), PollFlags::POLLIN)];
        let is_ready = poll(&mut pipe, PollTimeout::ZERO).is_ok_and(|ready| ready > 0);
        let has_input = pipe[0].revents().is_some_and(|events| events.contains(PollFlags::POLLIN));
        self.used < self.end || (is_ready && has_input)
    }

    /// Reads the available bytes, when all others have been returned; waits for at least one.
    fn more(&mut self) -> Result<(), Fault> {
        (self.used, self.end) = (0, 0);
        if Instant::now() >= self.deadline {
            return Err(self.late());
        }
        loop {
            match self.output.read(&mut self.read) {
                Ok(0) => return Err(Fault::Ended(Exit::Unknown)),
                Ok(count) => {
                    self.end = count;
                    return Ok(());
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    self.wait(self.output.as_fd(), PollFlags::POLLIN)?;
                }
                Err(_) => return Err(Fault::Ended(Exit::Unknown)),
            }
        }
    }
}

fn never_block(pipe: BorrowedFd<'_>) -> io::Result<()> {
    let flags = OFlag::from_bits_retain(fcntl(pipe, FcntlArg::F_GETFL)?);
    fcntl(pipe, FcntlArg::F_SETFL(flags | OFlag::O_NONBLOCK))?;
    Ok(())
}

impl Link for Child {
    fn send(&mut self, message: &[u8], limit: f64) -> Result<(), Fault> {
        self.write(message, limit).map_err(|fault| self.counted(fault))
    }

    fn line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault> {
        self.read_line(line, longest).map_err(|fault| self.counted(fault))
    }

    fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.fill(bytes).map_err(|fault| self.counted(fault))
    }

    fn note(&self, text: &str) {
        self.notes.say(&self.program, text);
    }
}

impl Child {
    fn counted(&self, fault: Fault) -> Fault {
        if matches!(fault, Fault::Ended(_) | Fault::Late { .. }) {
            FAILURES.fetch_add(1, Ordering::Relaxed);
        }
        self.with_exit(fault)
    }

    /// A fault, with the exit code or the signal if it is that the child has ended.
    #[cfg(target_os = "linux")]
    fn with_exit(&self, fault: Fault) -> Fault {
        let begun = Instant::now();
        let child = Pid::from_raw(self.process.id() as i32);
        let flags = WaitPidFlag::WEXITED | WaitPidFlag::WNOHANG | WaitPidFlag::WNOWAIT;
        while fault == Fault::Ended(Exit::Unknown) && begun.elapsed() < FAREWELL {
            match waitid(Id::Pid(child), flags) {
                Ok(WaitStatus::Exited(_, code)) => return Fault::Ended(Exit::Code(code)),
                Ok(WaitStatus::Signaled(_, signal, _)) => return Fault::Ended(Exit::Signal(signal.as_str())),
                _ => std::thread::sleep(LOOK),
            }
        }
        fault
    }

    /// Only Linux tells how a child has ended without giving its number to another process.
    #[cfg(not(target_os = "linux"))]
    fn with_exit(&self, fault: Fault) -> Fault {
        fault
    }

    /// Writes a message; the answer must be complete within the limit (s).
    fn write(&mut self, message: &[u8], limit: f64) -> Result<(), Fault> {
        if self.has_spoken() {
            let fault = Fault::Answer("it came before the question");
            self.note(&fault.to_string());
            return Err(fault);
        }
        self.limit = Duration::from_secs_f64(limit);
        self.deadline = Instant::now() + self.limit;
        let mut left = message;
        while !left.is_empty() {
            let Some(input) = &mut self.input else { return Err(Fault::Ended(Exit::Unknown)) };
            match input.write(left) {
                Ok(count) => left = &left[count..],
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    let input = self.input.as_ref().map(AsFd::as_fd).ok_or(Fault::Ended(Exit::Unknown))?;
                    self.wait(input, PollFlags::POLLOUT)?;
                }
                Err(_) => return Err(Fault::Ended(Exit::Unknown)),
            }
        }
        Ok(())
    }

    fn read_line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault> {
        loop {
            let new = &self.read[self.used..self.end];
            let end = new.iter().position(|byte| *byte == b'\n');
            let length = end.unwrap_or(new.len());
            line.extend_from_slice(&new[..length]);
            self.used += length + usize::from(end.is_some());
            if line.len() > longest {
                return Err(Fault::Answer("a line that does not end"));
            }
            match end {
                Some(_) => return Ok(()),
                None => self.more()?,
            }
        }
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        let mut filled = 0;
        while filled < bytes.len() {
            if self.used == self.end {
                self.more()?;
            }
            let count = (self.end - self.used).min(bytes.len() - filled);
            bytes[filled..filled + count].copy_from_slice(&self.read[self.used..self.used + count]);
            self.used += count;
            filled += count;
        }
        Ok(())
    }
}

impl Drop for Child {
    /// Closes its input, which asks it to end, and kills it when it does not.
    fn drop(&mut self) {
        drop(self.input.take());
        self.deadline = Instant::now() + LEAVE;
        // Its output is closed when it has ended.
        while self.fill(&mut [0; 1 << 12]).is_ok() {}
        // The group should be empty by now. A process that is left in it hangs, and is killed.
        let _ = killpg(Pid::from_raw(self.process.id() as i32), Signal::SIGKILL);
        // It may have left its own group.
        let _ = self.process.kill();
        let _ = self.process.wait();
        // A process that has left the group still has the mark.
        descendants::end(&self.mark);
        if let Some(messages) = self.messages.take() {
            messages.finish();
        }
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.process.id());
    }
}
