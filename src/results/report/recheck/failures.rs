use super::Encounters;
use crate::failure::FoundBy;
use crate::record::in_world;
use crate::report::FailureChange;
use crate::report::compare::drivers;
use base::choice;

choice! {
    /// What moves the pedestrian of a failure when it is met again.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum WalkedBy {
        /// Its own policy, which reacts to the new driver.
        Pedestrian = "pedestrian",
        /// The recorded commands; the last one is kept until the episode ends.
        Commands = "commands",
    }
}

/// The failures of a report in a town, met again by a new driver.
#[derive(Debug, Clone)]
pub struct RecheckedFailures {
    /// The old driver and the new one.
    pub policies: [String; 2],
    pub town: String,
    /// The simulator in which the new driver drives.
    pub world: String,
    /// What found the failures.
    pub found_in: FoundBy,
    /// What moves the pedestrian now.
    pub walked_by: WalkedBy,
    /// One encounter for each failure.
    pub encounters: Encounters,
}

impl RecheckedFailures {
    /// The drivers, the town and the source of the failures.
    pub fn title(&self) -> String {
        let (found_in, walked_by) = (self.found_in.name(), self.walked_by.name());
        format!("{} in {}, {found_in}, by {walked_by}", drivers(&self.policies), in_world(&self.town, &self.world))
    }

    /// The failures, as they end for both drivers.
    pub fn changes(&self) -> Vec<FailureChange> {
        self.encounters.valid().filter_map(|encounter| encounter.change(self.title())).collect()
    }
}
