use super::repeat::repeat;
use super::sample::{Case, RunSample};
use super::start::cases;
use crate::analysis::{Explanation, FailureMode, failure_modes};
use crate::failure::Failure;
use crate::record::CellKey;
use base::choice;
use base::seed::Seed;
use learn::ActorCritic;

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

/// A mode with its example.
#[derive(Debug, Clone)]
pub struct Mode {
    pub mode: FailureMode,
    /// The medoid.
    pub example: Failure,
}

/// The analysis of a cell.
#[derive(Debug, Clone)]
pub struct CellModes {
    pub key: CellKey,
    /// The numbers of its episodes and collisions, without those in which the driver failed.
    pub all: (u64, u64),
    /// The number of each that was analysed.
    pub sampled: (u64, u64),
    pub modes: Vec<Mode>,
    pub explanations: Vec<(Target, Explanation)>,
}

impl CellModes {
    /// The number of kinds of its collisions.
    pub fn kinds(&self) -> u64 {
        // Each kind once, for any number of clusters.
        self.modes.iter().filter(|mode| mode.mode.cluster == 0).count() as u64
    }

    /// Analyses the runs of a cell, with the networks of each.
    pub fn new(mut runs: Vec<RunSample<'_>>, trained: &[Option<&ActorCritic>], seed: &Seed) -> Self {
        let evaluation = runs[0].evaluation;
        let scenario = &evaluation.scenario;
        let starts: Vec<Case> = runs.iter().flat_map(|run| run.cases.iter().copied()).collect();
        let explain = || {
            let explained = |target: Target| Some((target, Explanation::new(&cases(scenario, &starts, target.hit()))?));
            Target::ALL.into_iter().filter_map(explained).collect()
        };
        let look = || {
            repeat(&mut runs, trained, seed);
            let failures: Vec<Failure> = runs.iter_mut().flat_map(|run| std::mem::take(&mut run.failures)).collect();
            let example = |mode: FailureMode| Mode { example: failures[mode.medoid].clone(), mode };
            let modes: Vec<Mode> = failure_modes(&failures).into_iter().map(example).collect();
            (failures.len() as u64, modes)
        };
        let ((failures, modes), explanations) = rayon::join(look, explain);
        let sum = |of: fn(&RunSample<'_>) -> u64| runs.iter().map(of).sum::<u64>();
        Self {
            key: runs[0].key.cell.clone(),
            all: (sum(|run| run.all.0), sum(|run| run.all.1)),
            sampled: (sum(|run| run.episodes), failures),
            modes,
            explanations,
        }
    }
}
