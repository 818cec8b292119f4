use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{JobResult, Kind, Work, json, result};
use crate::campaign::{Finished, Part, TaskError};
use compile::Planned;

/// A job of one part that finds one thing, which is stored as JSON when it is whole.
pub trait Measurement: Planned + Clone {
    /// What it finds.
    type Found: Serialize + DeserializeOwned + PartialEq + Clone + fmt::Debug + Send + Sync;

    const KIND: &'static Kind;

    /// Simulator ticks without which it finds nothing: with a lower limit it is not begun.
    fn budget(&self) -> u64 {
        0
    }

    /// Runs it: what it found, and why it ended early. Both are missing if the user asked to stop.
    fn measure(&self, part: &Part<'_>) -> (Option<Self::Found>, Option<TaskError>);

    /// The units that it took.
    fn units_of(&self, found: Option<&Self::Found>) -> u64;

    /// What it found, for people.
    fn note(&self, found: &Self::Found) -> String;

    /// Whether it was not stopped.
    fn is_whole(_found: &Self::Found) -> bool {
        true
    }

    /// Number of episodes in which a program failed. They may end otherwise another time, so such a result is not stored.
    fn errors(_found: &Self::Found) -> u64 {
        0
    }
}

/// The result of a [`Measurement`].
#[derive(Debug, Clone)]
pub struct Measured<J: Measurement> {
    /// What was planned.
    pub job: J,
    /// `None` if it failed.
    pub found: Option<J::Found>,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

impl<J: Measurement> JobResult for Measured<J> {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn is_whole(&self) -> bool {
        self.error.is_none() && self.found.as_ref().is_some_and(J::is_whole)
    }

    fn units(&self) -> u64 {
        self.job.units_of(self.found.as_ref())
    }

    fn note(&self) -> String {
        self.found.as_ref().map_or_else(String::new, |found| self.job.note(found))
    }

    fn encode(&self) -> Option<Vec<u8>> {
        json(self.found.as_ref().filter(|found| J::errors(found) == 0)?)
    }
}

impl<J: Measurement> Work for J {
    fn kind(&self) -> &'static Kind {
        J::KIND
    }

    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>> {
        result(Measured { job: self.clone(), found: serde_json::from_slice(bytes).ok()?, error: None })
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let (found, error) = match part.limit(self.budget()) {
            Some(limit @ TaskError::Ticks { .. }) => (None, Some(limit)),
            _ => {
                part.begin(0);
                self.measure(part)
            }
        };
        if found.is_none() && error.is_none() {
            return None;
        }
        result(Measured { job: self.clone(), found, error })
    }
}

impl Finished {
    /// What the measurements of a kind found, in the plan's order.
    pub fn found<J: Measurement>(&self) -> impl Iterator<Item = (&J, &J::Found)> {
        self.all::<Measured<J>>().iter().filter_map(|each| Some((&each.job, each.found.as_ref()?)))
    }

    /// [`Finished::found`]; `None` if no measurement of the kind has a result.
    pub(super) fn found_if_any<J: Measurement>(&self) -> Option<Vec<(&J, &J::Found)>> {
        (!self.all::<Measured<J>>().is_empty()).then(|| self.found().collect())
    }
}
