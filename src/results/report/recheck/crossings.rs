use super::{Encounter, Encounters};
use crate::record::in_world;
use crate::report::FailureChange;
use crate::report::compare::drivers;

/// The fixed list in a town: every crossing of a grid from the same starts, met by both drivers.
#[derive(Debug, Clone)]
pub struct CrossedStarts {
    /// The old driver and the new one.
    pub policies: [String; 2],
    pub town: String,
    /// The simulator in which the new driver drives.
    pub world: String,
    /// Number of the setup (spawn, episode and pedestrian) in the town, from 0.
    pub setup: u64,
    /// Crossings from each start.
    pub crossings: u64,
    /// All encounters, start by start.
    pub encounters: Encounters,
}

impl CrossedStarts {
    /// The drivers and the town.
    pub fn title(&self) -> String {
        let setup = if self.setup == 0 { String::new() } else { format!(", setup {}", self.setup) };
        format!("{} in {}{setup}", drivers(&self.policies), in_world(&self.town, &self.world))
    }

    /// The crossings that are a fault of a driver, as they end for both. Empty if the old driver was not run.
    pub fn changes(&self) -> Vec<FailureChange> {
        let is_fault = |each: &&Encounter| each.after.fault || each.before.is_some_and(|before| before.fault);
        let faults = self.encounters.valid().filter(is_fault);
        faults.filter_map(|encounter| encounter.change(self.title())).collect()
    }
}
