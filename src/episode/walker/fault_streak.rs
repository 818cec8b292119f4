use world::av::Fault;

/// The episodes in a row in which a driver or a controller failed. After ten it is not asked again.
#[derive(Debug, Clone, Copy, Default)]
pub struct FaultStreak {
    length: u32,
    last: Option<Fault>,
}

/// Number of episodes in a row that a driver or a controller may fail.
const MAX_FAULTS: u32 = 10;

impl FaultStreak {
    /// Counts an episode that is over.
    pub fn count(&mut self, fault: Option<Fault>) {
        self.length = if fault.is_some() { self.length + 1 } else { 0 };
        self.last = fault.or(self.last);
    }

    /// The last fault, if there were ten in a row.
    pub fn hopeless(&self) -> Option<Fault> {
        self.last.filter(|_| self.length >= MAX_FAULTS)
    }

    /// Whether the user asked to stop while a driver or a controller was waited for. Nothing is concluded from the episodes since then.
    pub fn is_stopped(&self) -> bool {
        self.last == Some(Fault::Stopped)
    }
}
