use std::sync::Arc;

use super::cover::uniform;
use base::seed::{Seed, Stream};
use episode::walker::WalkPolicy;
use episode::{
    Draw, DrawnParameter, Outcome, Recorded, Scenario, Simulation, SpawnRule, StartParameter, Trace, place, play,
};
use road::geometry::wrap_angle;
use world::sim::WalkCommand;

/// Episodes whose starts are points of the box of a scenario's parameters ([`Scenario::start_parameters`]). A coordinate is a share: the value is that
/// quantile of what the spawn rule draws the parameter from, so equal parts of the box are equally likely.
pub struct BoxOfStarts {
    spawn: SpawnRule,
    parameters: Vec<DrawnParameter>,
    walker: Box<dyn WalkPolicy>,
    simulation: Box<dyn Simulation>,
    trace: Trace,
    seed: Seed,
}

impl BoxOfStarts {
    /// Prepares for a scenario. Where the spawn rule is a test, its target walks as the point says, and the walk policy is not asked.
    pub fn new(scenario: &Arc<Scenario>, walker: Box<dyn WalkPolicy>, seed: Seed) -> Self {
        Self {
            spawn: scenario.spawn.clone(),
            parameters: scenario.start_parameters(),
            walker,
            simulation: scenario.simulation(),
            trace: Trace::new(scenario),
            seed,
        }
    }

    pub fn parameters(&self) -> &[DrawnParameter] {
        &self.parameters
    }

    /// A point that is drawn uniformly.
    pub fn any_point(&self, stream: &mut Stream) -> Vec<f64> {
        uniform(self.parameters.len(), stream)
    }

    /// The values of the parameters (SI) at a point of the unit box.
    pub fn values(&self, at: &[f64]) -> Vec<(StartParameter, f64)> {
        self.parameters.iter().zip(at).map(|(drawn, share)| (drawn.parameter, drawn.value(*share))).collect()
    }

    /// Runs the episode with this number from a point of the unit box; `None` if no place on the road has such a start. The number decides over
    /// everything that is chance.
    pub fn run(&mut self, at: &[f64], number: u64) -> Option<(Outcome, &Trace)> {
        let values = self.values(at);
        let rule = self.spawn.fixed(&values);
        let scenario = self.simulation.scenario();
        let (town, obstacles) = (&scenario.town, &scenario.obstacles);
        let first = scenario.cast.pedestrian().first_heading;
        let drawn = &mut self.seed.child("place").index(number).stream();
        let rule = rule.settled(town, obstacles, first, drawn)?;
        let target = rule.target_walk.as_ref().map(|walk| stated(walk.command(), &values));
        self.simulation.respawn(rule);
        self.walker.begin(self.seed.child("walker").index(number).stream());
        let stated = target.map(|command| vec![command; self.simulation.scenario().cast.pedestrians.len()]);
        let mut stated = stated.as_deref().map(|commands| Recorded::new(commands.len(), commands, true));
        let walker: &mut dyn WalkPolicy = match &mut stated {
            Some(stated) => stated,
            None => self.walker.as_mut(),
        };
        place(&mut *self.simulation, Draw::new(&self.seed.child("episodes"), number), &mut self.trace);
        let outcome = play(&mut *self.simulation, walker, &mut self.trace).expect("our simulator ends every episode");
        Some((outcome, &self.trace))
    }
}

/// The first command of a target with the stated speed and turn.
fn stated(nominal: WalkCommand, values: &[(StartParameter, f64)]) -> WalkCommand {
    let value = |wanted| values.iter().find(|(parameter, _)| *parameter == wanted).map(|(_, value)| *value);
    WalkCommand {
        heading: wrap_angle(nominal.heading + value(StartParameter::Turn).unwrap_or(0.0)),
        speed: value(StartParameter::WalkingSpeed).unwrap_or(nominal.speed),
    }
}
