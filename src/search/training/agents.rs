use episode::{Cast, Ending, Simulation};
use learn::{Agent, Credit, PpoConfig};
use world::sim::WalkCommand;

/// One agent for each pedestrian that is controlled, and what each earned.
pub struct Agents {
    credit: Credit,
    all: Vec<Agent>,
    /// The numbers of their pedestrians.
    pedestrians: Vec<usize>,
    /// The start of the running episode; `None` if it cannot be copied.
    start: Option<Box<dyn Simulation>>,
    /// What each earned in the last step.
    earned: Vec<f64>,
}

impl Agents {
    /// The agents of a cast; `None` if one chooses for all pedestrians.
    pub fn new(cast: &Cast, config: &PpoConfig) -> Option<Self> {
        let all = cast.agents(Some(config.policies?));
        let pedestrians = cast.controlled().map(|(number, _)| number).collect();
        let credit = config.credit.unwrap_or(Credit::Team);
        Some(Self { credit, earned: vec![0.0; all.len()], all, pedestrians, start: None })
    }

    pub fn all(&self) -> &[Agent] {
        &self.all
    }

    /// What an agent earned in the last step.
    pub fn earned(&self, agent: usize) -> f64 {
        self.earned[agent]
    }

    /// Takes the start of an episode. Where it cannot be copied, removal pays as a team.
    pub fn begin(&mut self, simulation: &dyn Simulation) {
        self.start = if self.credit == Credit::Removal { simulation.snapshot() } else { None };
    }

    /// Works out what each earned in a step of this reward; `decisions` has the commands of the episode up to now.
    pub fn step(&mut self, reward: f64, simulation: &dyn Simulation, decisions: &[WalkCommand]) {
        self.earned.fill(reward);
        let Some(outcome) = simulation.outcome() else { return };
        match (self.credit, outcome.ending) {
            (Credit::Own, Ending::Touch { pedestrian, .. }) => {
                for (earned, number) in self.earned.iter_mut().zip(&self.pedestrians) {
                    *earned = if *number == usize::from(pedestrian) { reward } else { 0.0 };
                }
            }
            (Credit::Removal, _) => {
                for (earned, number) in self.earned.iter_mut().zip(&self.pedestrians) {
                    let without = self.start.as_ref().and_then(|start| start.snapshot_without(*number));
                    *earned -= without.map_or(0.0, |rest| reward_of(rest, decisions));
                }
            }
            (Credit::Team | Credit::Own, _) => {}
        }
    }
}

/// The reward of an episode that goes on with these commands; the last ones are kept until it ends.
fn reward_of(mut simulation: Box<dyn Simulation>, decisions: &[WalkCommand]) -> f64 {
    let each = simulation.scenario().cast.pedestrians.len();
    let mut decisions = decisions.chunks(each);
    let mut commands: &[WalkCommand] = &[];
    while simulation.outcome().is_none() {
        commands = decisions.next().unwrap_or(commands);
        simulation.carry_out(commands);
    }
    simulation.outcome().map_or(0.0, |outcome| outcome.reward)
}
