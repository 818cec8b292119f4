//! One environment in mid-episode, and what acting in it needs.

use super::actor_critic::{ActorCritic, Scratch};
use super::arithmetic::Path;
use super::env::{Agent, Env, Step};
use super::frame_stack::FrameStack;
use super::gaussian::{Gaussian, Spread};
use super::log::FinishedEpisode;
use super::normal::standard_normal;
use super::rollout::Rollout;
use super::shaping::shaping;
use super::train_error::Quantity;
use base::seed::Stream;

/// The part of a collector that belongs to one agent of an environment. Lanes of different environments do not share data, so they can run in parallel.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    pub(super) policy: usize,
    frame_dim: usize,
    bounds: Vec<(f64, f64)>,
    /// The noise of the actions.
    pub(super) noise: Stream,
    /// The input of the next decision.
    pub(super) stack: FrameStack,
    /// Whether the next decision is the first of an episode.
    pub(super) start: bool,
    pub(super) running: FinishedEpisode,
    /// The discounted sum of the rewards of this episode up to now, for their normalisation.
    pub(super) discounted: f64,
    /// The outcome of the last step.
    pub(super) outcome: Step,
    /// The shaped reward of the last step.
    pub(super) earned: f64,
    /// The potential of the present state.
    pub(super) potential: f64,
    /// The episodes that ended in this rollout, each with its last step.
    pub(super) finished: Vec<(usize, FinishedEpisode)>,
    /// The quantity that was not finite, and its step.
    pub(super) failure: Option<(usize, Quantity)>,
    /// The last observation of the episode that the last step ended.
    end: FrameStack,
    /// Memory for the numbers of all agents of the environment, in the lane of its first.
    joint: Joint,
    spread: Spread,
    mean: Vec<f64>,
    clipped: Vec<f64>,
    scratch: Scratch,
    chunk: usize,
}

/// The actions and the observations of all agents of an environment.
#[derive(Debug, Clone, Default)]
struct Joint {
    action: Vec<f64>,
    frames: Vec<f64>,
}

impl Lane {
    /// Makes a lane of an agent that precedes its first episode. `chunk` is the number of observations that are valued at once.
    pub(super) fn new<E: Env>(
        env: &E,
        agent: &Agent,
        policy: &ActorCritic,
        (frames, chunk): (usize, usize),
        noise: Stream,
    ) -> Self {
        let action_dim = policy.action_dim();
        let stack = FrameStack::new(agent.obs_dim, frames);
        Self {
            policy: agent.policy,
            frame_dim: agent.obs_dim,
            bounds: agent.action_bounds.clone(),
            noise,
            end: stack.clone(),
            stack,
            start: true,
            running: FinishedEpisode::default(),
            discounted: 0.0,
            outcome: Step { reward: 0.0, terminated: false, truncated: false },
            earned: 0.0,
            potential: 0.0,
            finished: Vec::new(),
            failure: None,
            joint: Joint { action: vec![0.0; env.action_bounds().len()], frames: vec![0.0; env.obs_dim()] },
            spread: Spread::new(action_dim),
            mean: vec![0.0; action_dim],
            clipped: vec![0.0; action_dim],
            scratch: policy.scratch(chunk),
            chunk,
        }
    }

    /// Starts an episode for all agents of an environment.
    pub(super) fn begin<E: Env>(lanes: &mut [Self], env: &mut E) -> Result<(), Quantity> {
        Self::reset(lanes, env)?;
        for lane in lanes {
            lane.start = true;
            lane.running = FinishedEpisode::default();
            lane.discounted = 0.0;
        }
        Ok(())
    }

    /// Resets an environment and takes its first observations.
    fn reset<E: Env>(lanes: &mut [Self], env: &mut E) -> Result<(), Quantity> {
        let [first, ..] = lanes else { return Ok(()) };
        let mut frames = std::mem::take(&mut first.joint.frames);
        env.reset(&mut frames);
        let mut rest = frames.as_slice();
        for lane in &mut *lanes {
            lane.stack.begin(rest.split_off(..lane.frame_dim).unwrap_or_default());
            lane.potential = env.potential();
        }
        let representable = representable(&frames);
        lanes[0].joint.frames = frames;
        representable
    }

    /// Prepares a rollout with this policy.
    pub(super) fn prepare(&mut self, policy: &ActorCritic) {
        self.finished.clear();
        self.failure = None;
        self.spread.set(policy.log_std());
    }

    /// Writes the input of the networks in step `t` of a rollout, and returns it.
    fn look<'a>(&self, policy: &ActorCritic, rollout: &'a mut Rollout, t: usize) -> &'a [f32] {
        let input = &mut rollout.obs[t * rollout.obs_dim..(t + 1) * rollout.obs_dim];
        policy.prepare(self.stack.as_slice(), input);
        input
    }

    /// Takes step `t` of a rollout of each agent of an environment by its policy; [`Lane::settle`] does the part that depends on normalised numbers.
    pub(super) fn step<E: Env>(
        lanes: &mut [Self],
        env: &mut E,
        policies: &[ActorCritic],
        rollouts: &mut [Rollout],
        t: usize,
        gamma: f64,
    ) -> Result<(), Quantity> {
        let [first, ..] = lanes else { return Ok(()) };
        let mut joint = std::mem::take(&mut first.joint);
        let mut rest = joint.action.as_mut_slice();
        for (lane, rollout) in lanes.iter_mut().zip(rollouts) {
            let policy = &policies[lane.policy];
            let input = lane.look(policy, rollout, t);
            policy.mean(input, &mut lane.mean, &mut lane.scratch.actor);
            lane.act(rollout, t)?;
            rest.split_off_mut(..lane.clipped.len()).unwrap_or_default().copy_from_slice(&lane.clipped);
        }
        let outcome = env.step(&joint.action, &mut joint.frames);
        let potential = env.potential();
        let mut rest = joint.frames.as_slice();
        for (agent, lane) in lanes.iter_mut().enumerate() {
            let frame = rest.split_off(..lane.frame_dim).unwrap_or_default();
            let credit = Step { reward: env.credit(agent, outcome.reward), ..outcome };
            lane.receive(credit, outcome.reward, potential, frame, gamma)?;
        }
        lanes[0].joint = joint;
        if outcome.done() {
            let running = &mut lanes[0].running;
            (running.success, running.fault) = (env.is_success(), env.is_fault());
            let ended = *running;
            lanes[0].finished.push((t, ended));
            lanes.iter_mut().for_each(|lane| lane.running = FinishedEpisode::default());
            Self::reset(lanes, env)?;
        }
        Ok(())
    }

    /// Draws the action of step `t`.
    fn act(&mut self, rollout: &mut Rollout, t: usize) -> Result<(), Quantity> {
        let action = &mut rollout.actions[t * rollout.action_dim..(t + 1) * rollout.action_dim];
        for ((action, mean), std) in action.iter_mut().zip(&self.mean).zip(self.spread.std()) {
            *action = mean + std * standard_normal(&mut self.noise);
        }
        finite(action, Quantity::Action)?;
        rollout.log_probs[t] = Gaussian { mean: &self.mean, spread: &self.spread }.log_prob(action);
        rollout.episode_starts[t] = self.start;
        for ((slot, action), (low, high)) in self.clipped.iter_mut().zip(action.iter()).zip(&self.bounds) {
            *slot = action.max(*low).min(*high);
        }
        Ok(())
    }

    /// Takes what came of a step: the agent's own part, the reward of the episode, the potential and its observation.
    fn receive(
        &mut self,
        outcome: Step,
        reward: f64,
        potential: f64,
        frame: &[f64],
        gamma: f64,
    ) -> Result<(), Quantity> {
        self.outcome = outcome;
        self.earned = outcome.reward + shaping(self.potential, potential, outcome, gamma);
        self.potential = potential;
        finite(&[self.earned], Quantity::Reward)?;
        representable(frame)?;
        self.running.reward += reward;
        self.running.length += 1;
        self.start = outcome.done();
        if outcome.done() {
            self.end.restore(self.stack.as_slice());
            self.end.push(frame);
        } else {
            self.stack.push(frame);
        }
        Ok(())
    }

    /// Records the reward of the last step; `reward` is in the unit of the critic, and `cut_gamma` discounts what it says of a state that was cut off.
    pub(super) fn settle(
        &mut self,
        policy: &ActorCritic,
        rollout: &mut Rollout,
        t: usize,
        reward: f64,
        cut_gamma: f64,
    ) {
        rollout.rewards[t] = reward;
        if self.outcome.truncated && !self.outcome.terminated {
            rollout.rewards[t] += cut_gamma * policy.value(self.end.as_slice(), &mut self.scratch);
        }
        if self.outcome.done() {
            self.discounted = 0.0;
        }
    }

    /// Completes a rollout with values, advantages and returns.
    ///
    /// All observations are valued together, which is cheaper than one by one while acting. The critic does not change in
    /// between.
    pub(super) fn finish(&mut self, policy: &ActorCritic, rollout: &mut Rollout, gamma: f64, lambda: f64, path: Path) {
        let obs = rollout.obs.chunks(self.chunk * rollout.obs_dim);
        for (obs, values) in obs.zip(rollout.values.chunks_mut(self.chunk)) {
            policy.values(obs, values, &mut self.scratch, path);
        }
        let last_value = policy.value(self.stack.as_slice(), &mut self.scratch);
        rollout.finish(last_value, self.start, gamma, lambda);
    }
}

fn finite(values: &[f64], quantity: Quantity) -> Result<(), Quantity> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(quantity) }
}

/// Returns an error for observations that are infinite in the networks' precision.
fn representable(obs: &[f64]) -> Result<(), Quantity> {
    if obs.iter().all(|&value| (value as f32).is_finite()) { Ok(()) } else { Err(Quantity::Observation) }
}
