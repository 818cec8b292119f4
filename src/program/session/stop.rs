use std::sync::atomic::{AtomicBool, Ordering};

/// Asks a session to stop after the current update or episode. A signal handler or another thread raises it.
#[derive(Debug, Default)]
pub struct Stop {
    asked: AtomicBool,
    reporting: AtomicBool,
    placing: AtomicBool,
}

impl Stop {
    /// A flag that is not raised.
    pub const fn new() -> Self {
        Self { asked: AtomicBool::new(false), reporting: AtomicBool::new(false), placing: AtomicBool::new(false) }
    }

    /// Raises the flag; returns whether it was raised before.
    pub fn ask(&self) -> bool {
        self.asked.swap(true, Ordering::Relaxed)
    }

    /// Whether the flag is raised.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Whether a report is being made, of results that are stored. A process that ends now loses none of them.
    pub fn is_reporting(&self) -> bool {
        self.reporting.load(Ordering::Relaxed)
    }

    /// Makes a report.
    pub(super) fn while_reporting<T>(&self, report: impl FnOnce() -> T) -> T {
        self.reporting.store(true, Ordering::Relaxed);
        let made = report();
        self.reporting.store(false, Ordering::Relaxed);
        made
    }

    /// Whether a report is being moved to its place. A process that ends now could leave half of it.
    pub fn is_placing(&self) -> bool {
        self.placing.load(Ordering::Relaxed)
    }

    /// Runs what must not be interrupted.
    pub(super) fn while_placing<T>(&self, place: impl FnOnce() -> T) -> T {
        self.placing.store(true, Ordering::Relaxed);
        let placed = place();
        self.placing.store(false, Ordering::Relaxed);
        placed
    }
}
