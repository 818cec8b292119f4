use std::collections::{BTreeMap, VecDeque};

use rand::RngExt;

use super::crossing::{Crossing, Goal};
use super::{Falsifier, Intercept, Simulator, WalkPolicy};
use crate::env::{FailureCell, PedestrianEnv};
use crate::rl::{TrainError, standard_normal};
use crate::seed::{Seed, Stream};
use crate::signature::{Arguments, Param, Signature, Type};
use crate::sim::WalkCommand;
use crate::units::Dimension;

/// A quality-diversity search: it keeps the best crossings of each [`FailureCell`], and varies them at new starts.
///
/// A crossing is a [`Goal`] of six numbers, carried out in closed loop by [`Crossing`]. An elite is drawn by three factors: how near the start
/// is to the one where it was found, what its variations have earned since, and how seldom its cell was filled. So the search neither finds
/// one fault a thousand times nor leaves what works. What similar crossings earned at similar starts says what a variation can be expected to
/// earn. A start from which nothing is expected is left at once, and a promising one gets several tries. The end of the budget chooses the controller that it
/// returns: on starts of their own, the elites must earn more than `intercept`.
///
/// # Source
/// Mouret and Clune, *Illuminating search spaces by mapping elites*, arXiv 1504.04909, with a start as the context of an elite.
#[derive(Debug, Clone, Copy)]
pub struct Archive {
    /// Share of the starts at which a goal is drawn uniformly.
    explore: f64,
    /// Standard deviation of a variation, in shares of a goal's range.
    spread: f64,
    /// Most tries from one start.
    tries: u32,
    /// Exponent of the preference for seldom cells; 0 for none.
    novelty: f64,
    /// Most elites of a cell.
    elites: usize,
    /// Share of the budget that chooses the controller.
    choice: f64,
}

impl Archive {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        let share = |low, high| Type::Quantity { dimension: Dimension::RATIO, min: low, max: high };
        let params = vec![
            Param::required(
                "reward",
                Type::Reference("reward"),
                "What a crossing is to earn; `on hit(attributable)` makes it look for faults of the driver.",
            ),
            Param::with_default(
                "explore",
                share(0.0, 1.0),
                "0.1",
                "Share of the starts at which a crossing is drawn uniformly.",
            ),
            Param::with_default(
                "spread",
                share(0.001, 1.0),
                "0.1",
                "Standard deviation of a variation; 1 is the whole range of a component.",
            ),
            Param::with_default(
                "tries",
                Type::Integer { min: 1, max: 1000 },
                "8",
                "Most crossings that are tried from one start, while they promise more than the average.",
            ),
            Param::with_default(
                "novelty",
                share(0.0, 5.0),
                "0.5",
                "Exponent of the preference for seldom failures; 0 for none.",
            ),
            Param::with_default(
                "elites",
                Type::Integer { min: 1, max: 1000 },
                "16",
                "Most crossings that are kept of one kind of failure.",
            ),
            Param::with_default(
                "choice",
                share(0.0, 0.5),
                "0.1",
                "Share of the budget that compares what was found with `intercept`, to choose the controller.",
            ),
        ];
        let doc = "A quality-diversity search over crossings: keeps the best of each kind of failure, and varies them at new starts.";
        Signature::new("archive", doc, params)
    }

    /// Makes one from checked arguments.
    pub fn new(arguments: &Arguments) -> Self {
        Self {
            explore: arguments.number("explore"),
            spread: arguments.number("spread"),
            tries: arguments.integer("tries") as u32,
            novelty: arguments.number("novelty"),
            elites: arguments.integer("elites") as usize,
            choice: arguments.number("choice"),
        }
    }
}

/// What matters of a start: where the pedestrian is, and how fast the car.
type Context = [f64; 3];
/// Scales of a context: two starts that differ by this are half related (m, m, m/s).
const SCALES: Context = [6.0, 3.0, 1.5];

/// The context at the start of an episode. A start at the right of the car is mirrored to its left: goals know no side.
fn context(env: &PedestrianEnv) -> Context {
    let ego = &env.world().ego().state;
    let local = ego.pose.to_local(env.world().pedestrians[0].state.pose.position());
    [local.x, local.y.abs(), ego.speed]
}

/// How related two contexts are, from 0 to 1.
fn kernel(a: &Context, b: &Context) -> f64 {
    let squares = a.iter().zip(b).zip(SCALES).map(|((a, b), scale)| ((a - b) / scale) * ((a - b) / scale));
    1.0 / (1.0 + squares.sum::<f64>())
}

/// A crossing that ended in a failure.
#[derive(Debug, Clone, Copy)]
struct Elite {
    context: Context,
    goal: Goal,
    cell: FailureCell,
    /// What it earned itself.
    reward: f64,
    /// What its variations earned, and their number.
    earned: f64,
    tries: f64,
}

impl Elite {
    /// What a variation of it can be expected to earn. Its own reward counts half, since it was selected for it.
    fn value(&self) -> f64 {
        (0.5 * self.reward + self.earned) / (1.0 + self.tries)
    }
}

/// A goal for a start.
struct Proposal {
    goal: Goal,
    /// The elite that it varies.
    parent: Option<usize>,
    /// What it can be expected to earn.
    expected: f64,
}

/// A crossing that was tried.
#[derive(Debug, Clone, Copy)]
struct Try {
    context: Context,
    goal: Goal,
    reward: f64,
}

/// The elites, the number of failures of each cell, and the last tries.
#[derive(Debug, Clone, Default)]
struct Elites {
    all: Vec<Elite>,
    filled: BTreeMap<FailureCell, usize>,
    memory: VecDeque<Try>,
    /// What all tries have earned, and their number.
    earned: f64,
    tries: f64,
}

/// A start is left at once if it promises less than this share of the average, once there were enough tries.
const HOPELESS: f64 = 0.5;
/// Share of the hopeless starts that are tried all the same. Without it a search whose starts cost no tick might never end.
const SECOND_LOOK: f64 = 0.1;
const FIRST_TRIES: usize = 100;
/// Most tries that are remembered.
const MEMORY: usize = 4000;
/// Goals that differ by this in one component are as far apart as contexts that differ by their scale.
const GOAL_SCALE: f64 = 0.15;
/// The square of the distance from which on a try says nothing, and the weight of the prior: that nothing is earned.
const REACH: f64 = 4.0;
const PRIOR: f64 = 0.5;
/// Variations of which the most promising is tried, and elites among which a controller chooses.
const CANDIDATES: usize = 4;
const FINALISTS: usize = 32;

impl Elites {
    /// Adds a failure; of a full cell the elite with the least value leaves.
    fn add(&mut self, elite: Elite, most: usize) {
        *self.filled.entry(elite.cell).or_default() += 1;
        let cell = self.all.iter().enumerate().filter(|(_, each)| each.cell == elite.cell);
        if cell.clone().count() < most {
            self.all.push(elite);
        } else if let Some((place, _)) = cell.min_by(|a, b| a.1.value().total_cmp(&b.1.value())) {
            self.all[place] = elite;
        }
    }

    /// Draws an elite for a start.
    fn draw(&self, context: &Context, novelty: f64, stream: &mut Stream) -> Option<usize> {
        let weight = |elite: &Elite| {
            let near = kernel(context, &elite.context);
            let seldom = libm::pow(self.filled[&elite.cell] as f64, -novelty);
            near * near * elite.value() * seldom
        };
        let mut sums: Vec<f64> = Vec::with_capacity(self.all.len());
        for elite in &self.all {
            sums.push(sums.last().copied().unwrap_or(0.0) + weight(elite));
        }
        let drawn = sums.last().copied().filter(|total| *total > 0.0)? * stream.random::<f64>();
        Some(sums.partition_point(|sum| *sum <= drawn).min(self.all.len() - 1))
    }

    /// What the tries have earned on average.
    fn average(&self) -> f64 {
        self.earned / self.tries.max(1.0)
    }

    /// Remembers a try.
    fn remember(&mut self, tried: Try) {
        if self.memory.len() == MEMORY {
            self.memory.pop_front();
        }
        self.earned += tried.reward;
        self.tries += 1.0;
        self.memory.push_back(tried);
    }

    /// What goals can be expected to earn at a start: a mean over similar tries at similar starts, weighted by a biweight kernel.
    fn expect<const N: usize>(&self, context: &Context, goals: &[Goal; N]) -> [f64; N] {
        let mut sums = [(PRIOR, 0.0); N];
        for tried in &self.memory {
            let parts = context.iter().zip(&tried.context).zip(SCALES).map(|((a, b), scale)| (a - b) / scale);
            let apart: f64 = parts.map(|part| part * part).sum();
            if apart >= REACH {
                continue;
            }
            let there = tried.goal.components();
            for (goal, (weight, earned)) in goals.iter().zip(&mut sums) {
                let parts = goal.components().into_iter().zip(there).map(|(a, b)| (a - b) / GOAL_SCALE);
                let share = 1.0 - (apart + parts.map(|part| part * part).sum::<f64>()) / REACH;
                if share > 0.0 {
                    *weight += share * share;
                    *earned += share * share * tried.reward;
                }
            }
        }
        sums.map(|(weight, earned)| earned / weight)
    }

    /// The goal that promises most at a start; none without an elite.
    fn best(&self, context: &Context) -> Option<Goal> {
        let promise = |elite: &Elite| kernel(context, &elite.context) * elite.value();
        let mut order: Vec<(f64, Goal)> = self.all.iter().map(|elite| (promise(elite), elite.goal)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let first = order.first()?.1;
        let candidates: [Goal; FINALISTS] = std::array::from_fn(|place| order.get(place).map_or(first, |each| each.1));
        let expected = self.expect(context, &candidates);
        let best = expected.iter().zip(candidates).max_by(|a, b| a.0.total_cmp(b.0));
        best.map(|(_, goal)| goal)
    }
}

impl Archive {
    /// A goal for a start.
    fn propose(&self, elites: &Elites, context: &Context, stream: &mut Stream) -> Proposal {
        let explore = stream.random::<f64>() < self.explore;
        let parent = if explore { None } else { elites.draw(context, self.novelty, stream) };
        let Some(parent) = parent else {
            // Before the first failure every second try intercepts.
            let uniform = explore || stream.random::<f64>() < 0.5;
            let goal = if uniform { Goal::new(std::array::from_fn(|_| stream.random())) } else { Goal::INTERCEPT };
            return Proposal { goal, parent: None, expected: elites.expect(context, &[goal])[0] };
        };
        let mut parents = [parent; CANDIDATES];
        for other in &mut parents[1..] {
            *other = elites.draw(context, self.novelty, stream).unwrap_or(parent);
        }
        let goals = parents.map(|parent| {
            let varied =
                elites.all[parent].goal.components().map(|share| share + self.spread * standard_normal(stream));
            Goal::new(varied)
        });
        // The interception competes with the variations.
        let goals: [Goal; CANDIDATES + 1] =
            std::array::from_fn(|place| goals.get(place).copied().unwrap_or(Goal::INTERCEPT));
        let expected = elites.expect(context, &goals);
        let best = (0..goals.len()).max_by(|a, b| expected[*a].total_cmp(&expected[*b]));
        let best = best.expect("there are candidates");
        Proposal { goal: goals[best], parent: parents.get(best).copied(), expected: expected[best] }
    }

    /// Tries crossings from one start while they promise more than the search has earned on average; none when the budget is used up.
    fn search_from(
        &self,
        start: u64,
        simulator: &mut Simulator<'_>,
        elites: &mut Elites,
        stream: &mut Stream,
    ) -> Option<()> {
        for number in 0..self.tries {
            if !simulator.begin(start) {
                return None;
            }
            let context = context(simulator.env());
            let proposal = self.propose(elites, &context, stream);
            let average = elites.average();
            let promising = match number {
                0 => proposal.expected >= HOPELESS * average || stream.random::<f64>() < SECOND_LOOK,
                _ => proposal.expected > average,
            };
            if elites.memory.len() >= FIRST_TRIES && !promising {
                return Some(());
            }
            let goal = proposal.goal;
            let reward = run(simulator, &mut Crossing::new(goal))?;
            elites.remember(Try { context, goal, reward });
            if let Some(parent) = proposal.parent {
                elites.all[parent].earned += reward.max(0.0);
                elites.all[parent].tries += 1.0;
            }
            if let Some(cell) = FailureCell::new(simulator.env()).filter(|_| reward > 0.0) {
                elites.add(Elite { context, goal, cell, reward, earned: 0.0, tries: 0.0 }, self.elites);
            }
        }
        Some(())
    }
}

impl Falsifier for Archive {
    fn search(&self, simulator: &mut Simulator<'_>, seed: &Seed) -> Result<Option<Box<dyn WalkPolicy>>, TrainError> {
        let mut stream = seed.child("archive").stream();
        let mut elites = Elites::default();
        let (budget, mut start) = (simulator.left(), 0);
        let kept = (budget as f64 * self.choice) as u64;
        while simulator.left() > kept {
            if self.search_from(start, simulator, &mut elites, &mut stream).is_none() {
                break;
            }
            start += 1;
        }
        let mut found = Found { elites, crossing: Crossing::new(Goal::INTERCEPT), begun: false };
        // The same starts for both, one after another.
        let (mut sums, mut played) = ([0.0; 2], 0);
        loop {
            let candidates: [&mut dyn WalkPolicy; 2] = [&mut found, &mut Intercept];
            let mut earned = [None; 2];
            for (walker, earned) in candidates.into_iter().zip(&mut earned) {
                if simulator.begin(start) {
                    *earned = run(simulator, walker);
                }
            }
            let [Some(ours), Some(baseline)] = earned else { break };
            sums = [sums[0] + ours, sums[1] + baseline];
            (start, played) = (start + 1, played + 1);
        }
        let chosen: Box<dyn WalkPolicy> =
            if played > 0 && sums[0] >= sums[1] { Box::new(found) } else { Box::new(Intercept) };
        Ok(Some(chosen))
    }
}

/// Runs the episode that has begun to its end and returns its reward; none when the budget is used up before.
fn run(simulator: &mut Simulator<'_>, walker: &mut dyn WalkPolicy) -> Option<f64> {
    // No controller of this search draws random numbers.
    walker.begin(Seed::root(0).stream());
    Some(simulator.finish(|env, commands| walker.choose(env, commands))?.reward)
}

/// The controller that the search ends up with: at each start the elite that promises most.
#[derive(Debug, Clone)]
struct Found {
    elites: Elites,
    crossing: Crossing,
    begun: bool,
}

impl WalkPolicy for Found {
    fn begin(&mut self, _: Stream) {
        self.begun = false;
    }

    fn choose(&mut self, env: &PedestrianEnv, commands: &mut [WalkCommand]) {
        if !self.begun {
            self.begun = true;
            self.crossing = Crossing::new(self.elites.best(&context(env)).unwrap_or(Goal::INTERCEPT));
        }
        self.crossing.choose(env, commands);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
