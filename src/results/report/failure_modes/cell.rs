use super::repeat::repeat;
use super::sample::{Case, RunSample};
use super::start::cases;
use crate::analysis::{Approach, Explanation, Failure, FailureMode, Richness, failure_modes};
use crate::record::CellKey;
use base::choice;
use base::seed::Seed;
use compile::Evaluation;
use learn::ActorCritic;
use world::geometry::Vector;

choice! {
    /// The outcome to explain.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Target {
        Collision = "collision",
        /// A collision that a careful human would have avoided.
        Preventable = "preventable",
    }
}

impl Target {
    fn hit(self) -> fn(&Case) -> bool {
        match self {
            Self::Collision => |case| case.collision,
            Self::Preventable => |case| case.preventable,
        }
    }
}

/// A mode with its examples.
#[derive(Debug, Clone)]
pub struct Mode {
    pub mode: FailureMode,
    /// The medoid's run and episode, and the name under which it can be found.
    pub example: (u32, u32, String),
    /// The approach of the medoid; none when it could not be repeated.
    pub medoid: Option<Approach>,
    /// The approaches of some other members.
    pub others: Vec<Approach>,
}

impl Mode {
    /// The name of its example, `RUN:EPISODE`.
    pub fn example_name(&self) -> String {
        format!("{}:{}", self.example.2, self.example.1)
    }
}

/// The analysis of a cell.
#[derive(Debug, Clone)]
pub struct CellModes<'a> {
    pub key: CellKey,
    pub evaluation: &'a Evaluation,
    /// Half extents of the car (m).
    pub car: Vector,
    /// The numbers of its episodes and collisions, without those in which the driver failed.
    pub all: (u64, u64),
    /// The number of each that was analysed.
    pub sampled: (u64, u64),
    /// The number of collisions that were repeated.
    pub repeated: u64,
    /// The number of collisions of each kind.
    pub counts: Vec<u64>,
    pub richness: Richness,
    pub modes: Vec<Mode>,
    pub explanations: Vec<(Target, Explanation)>,
}

/// The number of approaches of a mode in a picture.
const SHOWN: usize = 40;

impl<'a> CellModes<'a> {
    /// Analyses the runs of a cell, with the networks of each.
    pub fn new(mut runs: Vec<RunSample<'a>>, trained: &[Option<&ActorCritic>], seed: &Seed) -> Self {
        let evaluation = runs[0].evaluation;
        let scenario = &evaluation.scenario;
        let starts: Vec<Case> = runs.iter().flat_map(|run| run.cases.iter().copied()).collect();
        let explain = || {
            let explained = |target: Target| Some((target, Explanation::new(&cases(scenario, &starts, target.hit()))?));
            Target::ALL.into_iter().filter_map(explained).collect()
        };
        let look = || {
            repeat(&mut runs, trained, seed);
            let failures: Vec<Failure> =
                runs.iter().flat_map(|run| run.failures.iter().map(|sampled| sampled.failure.clone())).collect();
            let modes = failure_modes(&failures);
            let shown = modes.into_iter().map(|mode| shown(mode, &failures, &runs)).collect::<Vec<_>>();
            (failures, shown)
        };
        let ((failures, modes), explanations) = rayon::join(look, explain);
        // Each kind once, for any number of clusters.
        let counts: Vec<u64> =
            modes.iter().filter(|mode| mode.mode.cluster == 0).map(|mode| mode.mode.failures as u64).collect();
        let sum = |of: fn(&RunSample<'_>) -> u64| runs.iter().map(of).sum::<u64>();
        Self {
            key: runs[0].key.cell.clone(),
            evaluation,
            car: Vector::new(scenario.cast.ego().blueprint.half_length, scenario.cast.ego().blueprint.half_width),
            all: (sum(|run| run.all.0), sum(|run| run.all.1)),
            sampled: (sum(|run| run.episodes), failures.len() as u64),
            repeated: failures.iter().filter(|failure| failure.approach.is_some()).count() as u64,
            richness: Richness::new(&counts),
            counts,
            modes,
            explanations,
        }
    }
}

fn shown(mode: FailureMode, failures: &[Failure], runs: &[RunSample<'_>]) -> Mode {
    let example = &failures[mode.medoid];
    let run = runs.iter().find(|run| run.evaluation.trained.run == example.run);
    let approach = |member: &usize| failures[*member].approach.clone();
    Mode {
        example: (example.run, example.episode, run.map_or(String::new(), |run| run.key.id.to_string())),
        medoid: approach(&mode.medoid),
        others: mode.members.iter().filter_map(approach).take(SHOWN).collect(),
        mode,
    }
}
