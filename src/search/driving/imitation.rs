use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::DriveRule;
use base::seed::Seed;
use learn::{ActorCritic, Env, Fitted, PpoConfig, fit};

/// In the first round the teacher drives; in the others the learner does, and the teacher says what it would do.
const ROUNDS: u32 = 5;
/// Passes over all decisions up to then, after each round and after the last one; and the step size.
const EPOCHS: usize = 6;
const LAST_EPOCHS: usize = 20;
const STEP_SIZE: f64 = 1e-3;

/// Decisions between two glances at the work.
const GLANCE: u32 = 256;
/// A decision takes as long to show as this number of passes over it.
const SHOWING: u64 = 10;

/// An environment with a teacher.
pub(crate) trait Pupil: Env + Send {
    /// Lets the teacher say in every state from the next episode on what it would do, or no longer.
    fn teach(&mut self, teaches: bool);

    /// What the teacher would do in the present state, as an action.
    fn shown(&mut self) -> [f64; 2];
}

/// What an environment showed in a round.
#[derive(Default)]
struct Shown {
    observations: Vec<f32>,
    actions: Vec<f32>,
    rewards: Vec<f64>,
    /// Whether an episode ended with the decision.
    ends: Vec<bool>,
}

/// The work of an imitation: passes over decisions.
struct Work<'a> {
    done: AtomicU64,
    all: u64,
    watch: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Work<'_> {
    /// Adds passes, and returns whether to stop.
    fn add(&self, passes: u64) -> bool {
        let done = self.done.fetch_add(passes, Ordering::Relaxed) + passes;
        (self.watch)(done as f64 / self.all as f64)
    }
}

/// The passes of a round over all decisions up to then.
fn epochs(round: u32) -> usize {
    if round + 1 == ROUNDS { LAST_EPOCHS } else { EPOCHS }
}

/// Lets the networks imitate the teacher, in all environments: the actor its actions, the critic the sums of rewards of the learner's own driving.
/// Returns whether that was done: `watch` gets the share of the work that is done, as it grows, and answers whether to stop.
///
/// # Source
/// DAgger: Ross, Gordon and Bagnell, *A reduction of imitation learning and structured prediction to no-regret online learning*, AISTATS 2011.
pub(crate) fn imitate<E: Pupil>(
    envs: &mut [E],
    rule: &DriveRule,
    networks: &mut ActorCritic,
    config: &PpoConfig,
    seed: &Seed,
    watch: &(dyn Fn(f64) -> bool + Sync),
) -> bool {
    if rule.demonstrations == 0 {
        return true;
    }
    let decisions = (rule.demonstrations / ROUNDS).div_ceil(envs.len() as u32);
    let of_a_round = u64::from(decisions) * envs.len() as u64;
    let passes = |round| SHOWING + epochs(round) as u64 * u64::from(round + 1);
    let all = of_a_round * ((0..ROUNDS).map(passes).sum::<u64>() + EPOCHS as u64);
    let work = Work { done: AtomicU64::new(0), all, watch };
    envs.iter_mut().for_each(|env| env.teach(true));
    let (mut observations, mut actions) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        let seed = seed.index(round.into());
        let drive = |(number, env): (usize, &mut E)| {
            show(env, decisions, (round > 0).then_some(&*networks), &seed.index(number as u64), &work)
        };
        let shown: Vec<Shown> = envs.par_iter_mut().enumerate().map(drive).collect();
        if work.add(0) {
            return false;
        }
        if round + 1 == ROUNDS {
            let seen: Vec<f32> = shown.iter().flat_map(|each| each.observations.iter().copied()).collect();
            let returns: Vec<f32> = shown
                .iter()
                .flat_map(|each| returns(each, libm::pow(config.gamma, 1.0 / f64::from(rule.hold))))
                .collect();
            let data = (seen.as_slice(), returns.as_slice());
            let stop = || work.add(of_a_round);
            fit(networks, Fitted::Critic, data, (EPOCHS, STEP_SIZE), config, &seed.child("critic"), &stop);
        }
        for each in shown {
            observations.extend(each.observations);
            actions.extend(each.actions);
        }
        let data = (observations.as_slice(), actions.as_slice());
        let stop = || work.add(of_a_round * u64::from(round + 1));
        fit(networks, Fitted::Actor, data, (epochs(round), STEP_SIZE), config, &seed.child("actor"), &stop);
    }
    envs.iter_mut().for_each(|env| env.teach(false));
    !work.add(0)
}

/// A number of decisions: the teacher's, or those of the networks with their noise. Fewer when the work is to stop.
fn show<E: Pupil>(env: &mut E, decisions: u32, networks: Option<&ActorCritic>, seed: &Seed, work: &Work<'_>) -> Shown {
    let mut stream = seed.stream();
    let mut scratch = networks.map(|networks| networks.scratch(1));
    let bounds = env.action_bounds();
    let mut obs = vec![0.0; env.obs_dim()];
    let mut shown = Shown::default();
    env.reset(&mut obs);
    for decision in 0..decisions {
        if decision % GLANCE == 0 && work.add(SHOWING * u64::from(GLANCE.min(decisions - decision))) {
            break;
        }
        let mut action = env.shown();
        shown.observations.extend(obs.iter().map(|number| *number as f32));
        shown.actions.extend(action.map(|number| number as f32));
        if let Some((networks, scratch)) = networks.zip(scratch.as_mut()) {
            networks.sample(&obs, &mut action, scratch, &mut stream);
        }
        for (number, (low, high)) in action.iter_mut().zip(&bounds) {
            *number = number.clamp(*low, *high);
        }
        let step = env.step(&action, &mut obs);
        shown.rewards.push(step.reward);
        shown.ends.push(step.done());
        if step.done() {
            env.reset(&mut obs);
        }
    }
    shown
}

/// The discounted sum of rewards from each decision on; nothing is added after the last one of an episode or of the round.
fn returns(shown: &Shown, gamma: f64) -> Vec<f32> {
    let mut sum = 0.0;
    let mut all: Vec<f32> = Vec::with_capacity(shown.rewards.len());
    for (reward, ends) in shown.rewards.iter().zip(&shown.ends).rev() {
        sum = reward + if *ends { 0.0 } else { gamma * sum };
        all.push(sum as f32);
    }
    all.reverse();
    all
}
