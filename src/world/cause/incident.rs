use std::sync::Arc;

use crate::env::{Criterion, Draw, Observer, Outcome, Scenario, Simulation, Trace};
use crate::falsifier::{Recorded, play, recorded_commands};
use crate::judge::Judged;
use crate::sim::WalkCommand;
use base::seed::Seed;

/// A failure by what repeats it.
#[derive(Debug, Clone)]
pub struct Incident {
    pub scenario: Arc<Scenario>,
    /// The seed of the starts.
    pub seed: Seed,
    /// The number of its start.
    pub start: u64,
    /// One command for each pedestrian in every decision.
    pub commands: Vec<WalkCommand>,
    /// What failed.
    pub criterion: Criterion,
}

/// Runs episodes from one start.
pub struct Reruns {
    scenario: Arc<Scenario>,
    draw: Draw,
    criterion: Criterion,
    /// The start after its run-up; `None` if it cannot be copied.
    begun: Option<Box<dyn Simulation>>,
    /// The number of episodes up to now.
    pub runs: u32,
}

/// An episode that was run again.
#[derive(Debug, Clone)]
pub struct Rerun {
    pub outcome: Outcome,
    pub trace: Trace,
    /// The commands that it took: one for each pedestrian in every decision.
    pub commands: Vec<WalkCommand>,
}

impl Rerun {
    /// What its judges say about a criterion.
    pub fn judged(&self, criterion: Criterion, scenario: &Scenario) -> Judged {
        Judged::by(criterion, &self.outcome, &self.trace.main_pair(scenario))
    }
}

impl Reruns {
    /// From the start of an incident, with the drivers of its scenario.
    pub fn new(incident: &Incident) -> Self {
        Self::with(incident, incident.scenario.clone())
    }

    /// From the start of an incident in another scenario, which has the same start: with another driver, or another world.
    pub fn with(incident: &Incident, scenario: Arc<Scenario>) -> Self {
        let draw = Draw::new(&incident.seed, incident.start);
        let mut simulation = scenario.simulation();
        simulation.start(draw.clone());
        let begun = simulation.snapshot();
        Self { scenario, draw, criterion: incident.criterion, begun, runs: 0 }
    }

    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// Runs it with these commands, the last of which is kept until the end. `None` without commands.
    pub fn run(&mut self, commands: &[WalkCommand]) -> Option<Rerun> {
        self.runs += 1;
        let copy = self.begun.as_ref().and_then(|begun| begun.snapshot());
        let mut simulation = copy.unwrap_or_else(|| {
            let mut simulation = self.scenario.simulation();
            simulation.start(self.draw.clone());
            simulation
        });
        let mut trace = Trace::new(&self.scenario);
        trace.begin(&simulation.scene());
        let mut walk = Recorded::new(self.scenario.cast.pedestrians.len(), commands, true);
        let outcome = play(&mut *simulation, &mut walk, &mut trace)?;
        let commands = recorded_commands(&trace);
        (!commands.is_empty()).then_some(Rerun { outcome, trace, commands })
    }

    /// Whether an episode fails by the criterion.
    pub fn fails(&self, rerun: &Rerun) -> bool {
        rerun.outcome.counts() && self.criterion.is_met(&rerun.outcome, rerun.trace.degrees())
    }
}
