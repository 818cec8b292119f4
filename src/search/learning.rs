use super::training::Agents;
use super::{BudgetedSimulation, Falsifier, Searched};
use base::keys;
use base::seed::Seed;
use base::signature::DeclarationId;
use episode::Simulation;
use episode::walker::{ActionMode, TrainedWalker};
use learn::{ActorCritic, Agent, Env, PpoConfig, Step, Trainer};

keys! {
    /// Trains a pedestrian by proximal policy optimisation.
    pub struct LearningKeys = "ppo" {
        /// What it is trained for.
        reward: DeclarationId as Reference("reward"),
        /// How it is trained, instead of the campaign's `training`; the budget takes the place of `steps`.
        training: Option<DeclarationId> as Reference("training"),
    }
}

/// Learning by PPO as a falsifier: the failures are those of the training.
///
/// The budget replaces the training's number of steps; schedules end with the decisions that fit into it. Several environments have equal
/// shares of the budget. An update is discarded if the first share is used up in it. Pedestrians that choose for themselves earn as a team, or each its own
/// touch: what an episode earns without one of them takes ticks that the budget does not have.
#[derive(Debug, Clone)]
pub struct Learning(pub PpoConfig);

/// A share of the simulator as an environment of the learner. When the budget is used up, it does not move and ends every episode at once.
/// What is learnt from such episodes is discarded.
struct Ground<'a> {
    share: BudgetedSimulation<'a>,
    /// `None` if one agent moves all pedestrians.
    agents: Option<Agents>,
    next: u64,
    stride: u64,
}

impl Env for Ground<'_> {
    fn agents(&self) -> Vec<Agent> {
        self.agents.as_ref().map_or_else(|| self.share.scenario().cast.agents(None), |agents| agents.all().to_vec())
    }

    fn obs_dim(&self) -> usize {
        self.share.scenario().cast.obs_dim()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.share.scenario().cast.action_bounds()
    }

    fn credit(&self, agent: usize, reward: f64) -> f64 {
        self.agents.as_ref().map_or(reward, |agents| agents.earned(agent))
    }

    fn reset(&mut self, state: &mut [f64]) {
        self.share.begin(self.next);
        self.next += self.stride;
        self.share.scene().write_state(state);
    }

    fn step(&mut self, action: &[f64], state: &mut [f64]) -> Step {
        let step = self.share.act(action);
        self.share.scene().write_state(state);
        let step = step.unwrap_or(Step { reward: 0.0, terminated: true, truncated: false });
        if let Some(agents) = &mut self.agents {
            agents.step(step.reward, &self.share, &[]);
        }
        step
    }

    fn is_success(&self) -> bool {
        self.share.is_failure()
    }

    fn is_fault(&self) -> Option<bool> {
        self.share.judged_fault()
    }

    fn potential(&self) -> f64 {
        self.share.shaping()
    }
}

impl Falsifier for Learning {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched {
        let scenario = simulator.scenario();
        let (hold, cast) = (u64::from(scenario.episode.hold), scenario.cast.clone());
        let run_up = u64::from(scenario.most_run_up());
        let stride = self.0.environments as u64;
        let shares = simulator.shares(stride);
        let agents = || Agents::new(&cast, &self.0);
        let mut grounds: Vec<Ground<'_>> =
            (0..).zip(shares).map(|(next, share)| Ground { share, agents: agents(), next, stride }).collect();
        let config = PpoConfig { steps: (simulator.left() / hold).max(1), ..self.0.clone() };
        let trained = train(&mut grounds, &config, hold + run_up, seed);
        simulator.take_over(grounds.into_iter().map(|ground| ground.share).collect());
        Ok(Some(Box::new(TrainedWalker::new(trained?, &cast, ActionMode::Deterministic))))
    }
}

/// Trains until one of the shares is used up. `longest` is the greatest number of ticks that a decision takes, with a run-up before it.
fn train(
    grounds: &mut [Ground<'_>],
    config: &PpoConfig,
    longest: u64,
    seed: &Seed,
) -> Result<Vec<ActorCritic>, learn::TrainError> {
    let most = config.steps_per_update as u64 * longest;
    let mut trainer = Trainer::new(grounds, config, seed)?;
    loop {
        let enough = grounds.iter().all(|ground| ground.share.left() >= most);
        let before = (!enough).then(|| trainer.policies().to_vec());
        trainer.update(grounds)?;
        if grounds.iter().any(|ground| ground.share.is_spent()) {
            return Ok(before.unwrap_or_else(|| trainer.finish().policies));
        }
    }
}
