//! Monte Carlo tree search over the pedestrian's actions, in the manner of adaptive stress testing.
//!
//! A node represents the actions that lead to it from the start. The simulator is deterministic, so these actions are its state, and
//! *double* progressive widening reduces to that of actions. Each simulation runs from the start and all of its ticks count, as for a
//! simulator that cannot be reset to a state. On its way down it adds an action to a node with *N* visits while there are fewer than *k
//! √N* of them; otherwise it takes the action with the greatest upper confidence bound. Below the tree it acts at random. The sum of
//! rewards is backed up as a mean. New actions are drawn as the `random` falsifier draws them. Returns are scaled to the least and
//! greatest of the tree, so the exploration constant does not depend on the reward.
//!
//! The reward is that of the scenario; the reward of adaptive stress testing is in `scenarios/lib/rewards.scn`.
//!
//! # Source
//! Lee, Kochenderfer, Mengshoel, Brat, Owen, *Adaptive stress testing of airborne collision avoidance systems*, DASC 2015
//! (algorithm 1); Koren, Alsaif, Lee, Kochenderfer, *Adaptive stress testing for autonomous vehicles*, IV 2018.

use rand::RngExt;

use super::open_loop::{AfterFailure, FailureKeys};
use super::{BudgetedSimulation, Falsifier, Searched};
use base::keys;
use base::seed::{Seed, Stream};
use base::signature::DeclarationId;
use episode::Simulation;

keys! {
    /// Monte Carlo tree search with progressive widening, in the manner of adaptive stress testing, start by start.
    pub struct TreeSearch = "mcts" {
        /// What it maximises over an episode.
        reward: DeclarationId as Reference("reward"),
        /// Most simulations from one start.
        tries: u64 as whole(1, 1_000_000) = "200",
        /// The k of the k √N actions of a node with N visits.
        widening: f64 as within(RATIO, 0.01, 100.0) = "1",
        /// Weight of the confidence bound, in spans between the least and the greatest return.
        exploration: f64 as within(RATIO, 0.0, 100.0) = "0.15",
        ..on: FailureKeys,
    }
}

/// An action that was taken at a node, and the node it leads to.
#[derive(Debug, Clone, Copy)]
struct Branch {
    visits: f64,
    /// Mean of the sums of rewards from this action on.
    value: f64,
    /// Number of the node below, and of the action in [`Tree::actions`].
    node: usize,
}

#[derive(Debug, Clone, Default)]
struct Node {
    visits: f64,
    branches: Vec<Branch>,
}

/// The tree of one start.
struct Tree {
    nodes: Vec<Node>,
    /// The action that leads to each node, one after another; that of the root is not used.
    actions: Vec<f64>,
    /// The numbers of an action.
    dim: usize,
    /// Least and greatest return from any node.
    returns: (f64, f64),
}

/// A branch that a simulation took, and the reward of that decision.
struct Taken {
    node: usize,
    branch: usize,
    reward: f64,
}

impl TreeSearch {
    /// Grows a tree from one start; `None` if the budget is used up.
    fn search_from(&self, start: u64, simulator: &mut BudgetedSimulation<'_>, stream: &mut Stream) -> Option<()> {
        let mut tree = Tree::new(simulator.scene().bounds().len());
        for _ in 0..self.tries {
            if !simulator.begin(start) {
                return None;
            }
            self.simulate(&mut tree, simulator, stream)?;
            if self.on.after_failure == AfterFailure::Next && simulator.is_failure() {
                break;
            }
        }
        Some(())
    }

    /// Goes down the tree, adds a node, acts at random below it, and backs the rewards up.
    fn simulate(&self, tree: &mut Tree, simulator: &mut BudgetedSimulation<'_>, stream: &mut Stream) -> Option<()> {
        let mut path = Vec::new();
        let (mut node, mut grown) = (0, false);
        while simulator.outcome().is_none() && !grown {
            let (branch, new) = self.choose(tree, node, simulator, stream);
            let below = tree.nodes[node].branches[branch].node;
            let step = simulator.act(tree.action(below))?;
            path.push(Taken { node, branch, reward: step.reward });
            (node, grown) = (below, new);
        }
        let (mut below, mut action) = (0.0, Vec::with_capacity(tree.dim));
        while simulator.outcome().is_none() {
            action.clear();
            action.extend(draw(simulator, stream));
            below += simulator.act(&action)?.reward;
        }
        tree.back_up(&path, below);
        Some(())
    }

    /// The branch to take, and whether it is new.
    fn choose(
        &self,
        tree: &mut Tree,
        node: usize,
        simulator: &BudgetedSimulation<'_>,
        stream: &mut Stream,
    ) -> (usize, bool) {
        let (next, scale) = (tree.nodes.len(), tree.scale());
        let here = &mut tree.nodes[node];
        let allowed = self.widening * libm::pow(here.visits, 0.5);
        if here.branches.is_empty() || (here.branches.len() as f64) < allowed {
            here.branches.push(Branch { visits: 0.0, value: 0.0, node: next });
            let branch = here.branches.len() - 1;
            tree.nodes.push(Node::default());
            tree.actions.extend(draw(simulator, stream));
            return (branch, true);
        }
        let explored = libm::log(here.visits);
        let bound = |branch: &Branch| scale(branch.value) + self.exploration * (explored / branch.visits).sqrt();
        let best = (0..here.branches.len()).max_by(|a, b| {
            let (a, b) = (bound(&here.branches[*a]), bound(&here.branches[*b]));
            a.total_cmp(&b)
        });
        (best.expect("the node has branches"), false)
    }
}

impl Tree {
    /// Only a root, for actions of this many numbers.
    fn new(dim: usize) -> Self {
        let returns = (f64::INFINITY, f64::NEG_INFINITY);
        Self { nodes: vec![Node::default()], actions: vec![0.0; dim], dim, returns }
    }

    fn action(&self, node: usize) -> &[f64] {
        &self.actions[node * self.dim..(node + 1) * self.dim]
    }

    /// Scales a return to its share of the way from the least to the greatest.
    fn scale(&self) -> impl Fn(f64) -> f64 + use<> {
        let (low, high) = self.returns;
        let span = high - low;
        move |value| if span > 0.0 { (value - low) / span } else { 0.5 }
    }

    fn back_up(&mut self, path: &[Taken], below: f64) {
        let mut sum = below;
        for taken in path.iter().rev() {
            sum += taken.reward;
            if sum.is_finite() {
                self.returns = (self.returns.0.min(sum), self.returns.1.max(sum));
            }
            let node = &mut self.nodes[taken.node];
            node.visits += 1.0;
            let branch = &mut node.branches[taken.branch];
            branch.visits += 1.0;
            branch.value += (sum - branch.value) / branch.visits;
        }
    }
}

/// The numbers of an action drawn uniformly from its bounds.
fn draw<'a>(simulator: &'a BudgetedSimulation<'_>, stream: &'a mut Stream) -> impl Iterator<Item = f64> + 'a {
    simulator.scene().bounds().iter().map(|(low, high)| low + (high - low) * stream.random::<f64>())
}

impl Falsifier for TreeSearch {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched {
        for start in 0.. {
            if self.search_from(start, simulator, &mut seed.index(start).stream()).is_none() {
                break;
            }
        }
        Ok(None)
    }
}
