use base::choice;

choice! {
    /// What may happen in an encounter.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum Event {
        /// The moving car touches a pedestrian, or the requirement is violated where one is asked about.
        Failure = "failure",
        /// A failure that a careful human would have avoided.
        Preventable = "preventable",
        /// A failure that counts against the driver.
        Fault = "fault",
    }
}

impl Event {
    /// The number of events.
    pub const COUNT: usize = 3;
}

/// Which events happened, in the order of [`Event`].
pub type Events = [bool; Event::COUNT];
