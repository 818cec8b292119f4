use std::sync::Arc;

use super::{Degree, Trace};
use base::signature::{Requirement, VariableId};

/// A requirement of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedRequirement {
    pub name: Arc<str>,
    /// Its rank among those of a campaign: 1 is the most important.
    pub priority: u32,
    pub requirement: Arc<Requirement>,
}

/// Watches the requirements of a scenario in its episodes.
#[derive(Debug, Clone)]
pub struct Monitor {
    requirements: Arc<[NamedRequirement]>,
    traces: Vec<Trace>,
    /// The degree of each requirement in the episode that ended last.
    degrees: Vec<Degree>,
    dt: f64,
}

impl Monitor {
    /// Watches requirements in samples this time (s) apart; memory is reserved for this number of samples. The values of silent variables say nothing.
    pub fn new(
        requirements: Arc<[NamedRequirement]>,
        dt: f64,
        samples: usize,
        is_silent: &impl Fn(VariableId) -> bool,
    ) -> Self {
        let traces = requirements.iter().map(|each| Trace::new(&each.requirement, samples, is_silent)).collect();
        let degrees = Vec::with_capacity(requirements.len());
        Self { requirements, traces, degrees, dt }
    }

    /// Forgets the last episode.
    pub fn clear(&mut self) {
        self.traces.iter_mut().for_each(Trace::clear);
        self.degrees.clear();
    }

    /// Adds a sample, by the values of the variables (SI).
    #[inline]
    pub fn push(&mut self, values: &impl Fn(VariableId) -> f64) {
        for (trace, each) in self.traces.iter_mut().zip(&*self.requirements) {
            trace.push(&each.requirement, values);
        }
    }

    /// Evaluates the requirements at the end of an episode.
    pub fn conclude(&mut self) {
        let (dt, all) = (self.dt, self.traces.iter_mut().zip(&*self.requirements));
        self.degrees.clear();
        self.degrees.extend(all.map(|(trace, each)| trace.degree(&each.requirement, dt)));
    }

    /// The degree of each requirement, in their order; empty before an episode ends.
    pub fn degrees(&self) -> &[Degree] {
        &self.degrees
    }
}
