use std::sync::Arc;

use crate::Judged;
use base::seed::Seed;
use episode::{Criterion, Draw, Observer, Outcome, Recorded, Scenario, Simulation, Trace, play, recorded_commands};
use world::av::DrivingPolicy;
use world::sim::WalkCommand;

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

/// Makes another driver of a driver.
pub type WrapMaker = dyn Fn(Box<dyn DrivingPolicy>) -> Box<dyn DrivingPolicy> + Send + Sync;

/// Runs episodes from one start.
pub struct Reruns {
    scenario: Arc<Scenario>,
    draw: Draw,
    criterion: Criterion,
    /// The start after its run-up; `None` if it cannot be copied.
    begun: Option<Box<dyn Simulation>>,
    /// The speed limit at the start (m/s).
    pub speed_limit: f64,
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
        let mut reruns = Self { scenario, draw, criterion: incident.criterion, begun: None, speed_limit: 0.0, runs: 0 };
        let begun = reruns.begin(reruns.scenario.clone());
        reruns.speed_limit = begun.scene().world.speed_limit(0);
        reruns.begun = begun.snapshot();
        reruns
    }

    /// Whether the start can be copied, so that a run takes no run-up.
    pub fn is_copied(&self) -> bool {
        self.begun.is_some()
    }

    /// Runs it with these commands, the last of which is kept until the end. `None` without commands.
    pub fn run(&mut self, commands: &[WalkCommand]) -> Option<Rerun> {
        let copy = self.begun.as_ref().and_then(|begun| begun.snapshot());
        let simulation = copy.unwrap_or_else(|| self.begin(self.scenario.clone()));
        self.finish(simulation, commands)
    }

    /// The same, with what `wrap` makes of the driver under test. A driver that cannot be copied is wrapped from its run-up on.
    pub fn run_with(&mut self, commands: &[WalkCommand], wrap: &Arc<WrapMaker>) -> Option<Rerun> {
        // Without a run-up the driver has seen the start when it was reset.
        let begun = self.begun.as_ref().filter(|begun| begun.run_up_ticks() > 0);
        let copy = begun.and_then(|begun| begun.snapshot_with(&**wrap));
        let simulation = copy.unwrap_or_else(|| {
            let mut scenario = Scenario::clone(&self.scenario);
            let (make, wrap) = (scenario.cast.vehicles[0].policy.clone(), wrap.clone());
            scenario.cast.vehicles[0].policy = Arc::new(move || wrap(make()));
            self.begin(Arc::new(scenario))
        });
        self.finish(simulation, commands)
    }

    /// A simulation after its run-up.
    fn begin(&self, scenario: Arc<Scenario>) -> Box<dyn Simulation> {
        let mut simulation = scenario.simulation();
        simulation.start(self.draw.clone());
        simulation
    }

    fn finish(&mut self, mut simulation: Box<dyn Simulation>, commands: &[WalkCommand]) -> Option<Rerun> {
        self.runs += 1;
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
