//! A quality-diversity search: it keeps the best crossings of each [`FailureCell`], and varies them at new starts.
//!
//! The reward of a start is that of its worst failure; a further failure counts a share of it (`again`), the less the more its cell has earned.
//!
//! A crossing is a [`Goal`] of six numbers for each pedestrian, carried out in closed loop by [`Crossing`]. A variation of several changes that of one. An elite is drawn by three factors: how near the start
//! is to the one where it was found, what its variations have earned since, and how little its cell has earned. A failure *gains* less
//! the more its cell has earned before. So the search neither finds one fault a thousand times nor leaves what works.
//!
//! What similar crossings gained at similar starts says what a variation can be expected to gain. The best of several estimates is too high,
//! so an expected gain is corrected by what earlier ones turned out to be. A start is left as soon as the expected gain of a further attempt is less per tick
//! than the search gained recently, as a forager leaves a patch. The end of the budget chooses the controller
//! that it returns: on starts of their own, the elites must earn more than `intercept` and `homing`.
//!
//! # Source
//! Mouret and Clune, *Illuminating search spaces by mapping elites*, arXiv 1504.04909, with a start as the context of an elite; Charnov, *Optimal
//! foraging, the marginal value theorem*, Theoretical Population Biology 9 (1976).

use std::collections::{BTreeMap, VecDeque};

use rand::RngExt;

use super::crossing::{Crossing, Goal};
use super::{BudgetedSimulation, Falsifier, Searched, TrainError};
use base::keys;
use base::seed::{Seed, Stream};
use base::signature::DeclarationId;
use episode::walker::{Controller, FaultStreak, Homing, Intercept, WalkPolicy};
use episode::{FailureCell, Scene, Simulation, play};
use learn::standard_normal;
use world::sim::WalkCommand;

keys! {
    /// A quality-diversity search: keeps the best episode of each kind of failure, and varies it at new starts.
    pub struct Archive = "archive" {
        /// What an episode is to earn; `on touch(fault)` makes it look for faults of the driver.
        reward: DeclarationId as Reference("reward"),
        /// Share of the starts at which the walk is drawn uniformly.
        explore: f64 as share() = "0.1",
        /// Standard deviation of a variation; 1 is the whole range of a component.
        spread: f64 as within(RATIO, 0.001, 1.0) = "0.1",
        /// Maximum attempts per start, made while they are expected to gain more than another start.
        tries: u32 as whole(1, 1000) = "32",
        /// Discount for repeated failures from one start, as a fraction of their reward: with 0 a start is left
        /// after its first fault, with 1 more faults of one start count like those of others.
        again: f64 as share() = "0.3",
        /// Share of the budget that compares what was found with `intercept` and `homing`, and with that of `from`, to choose the pedestrian.
        choice: f64 as within(RATIO, 0.0, 0.5) = "0.1",
        /// A pedestrian that walks first from every start, such as `hunter` of std/pedestrians.scn.
        from: Option<DeclarationId> as Reference("pedestrian"),
    }
}

/// An archive with the controller that walks first from every start.
#[derive(Debug, Clone)]
pub struct ArchiveSearch {
    pub keys: Archive,
    pub from: Option<Controller>,
}

/// What matters of a start: where the pedestrian is, and how fast the car.
type Context = [f64; 3];
/// Scales of a context: two starts that differ by this are half related (m, m, m/s).
const SCALES: Context = [6.0, 3.0, 1.5];

/// The context at the start of an episode. A start at the right of the car is mirrored to its left: goals know no side.
fn context(scene: &Scene<'_>) -> Context {
    let ego = &scene.world.ego().state;
    let local = ego.pose.to_local(scene.world.pedestrians[0].state.pose.position());
    [local.x, local.y.abs(), ego.speed]
}

/// How related two contexts are, from 0 to 1.
fn kernel(a: &Context, b: &Context) -> f64 {
    let squares = a.iter().zip(b).zip(SCALES).map(|((a, b), scale)| ((a - b) / scale) * ((a - b) / scale));
    1.0 / (1.0 + squares.sum::<f64>())
}

/// Goals drawn uniformly.
fn uniform(pedestrians: usize, stream: &mut Stream) -> Vec<Goal> {
    (0..pedestrians).map(|_| Goal::new(std::array::from_fn(|_| stream.random()))).collect()
}

/// The square of the distance of goals in [`GOAL_SCALE`], a mean over the pedestrians.
fn mean_square(some: &[Goal], others: &[Goal]) -> f64 {
    let square = |(a, b): (&Goal, &Goal)| {
        let parts = a.components().into_iter().zip(b.components()).map(|(a, b)| (a - b) / GOAL_SCALE);
        parts.map(|part| part * part).sum::<f64>()
    };
    some.iter().zip(others).map(square).sum::<f64>() / some.len() as f64
}

/// A crossing that ended in a failure.
#[derive(Debug, Clone)]
struct Elite {
    context: Context,
    goals: Vec<Goal>,
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

/// The goals of the pedestrians for a start.
struct Proposal {
    goals: Vec<Goal>,
    /// The elite that it varies.
    parent: Option<usize>,
    /// What it can be expected to gain.
    expected: f64,
}

/// A crossing that was tried, or a walk of another controller.
#[derive(Debug, Clone)]
struct Try {
    context: Context,
    /// Empty of another controller.
    goals: Vec<Goal>,
    reward: f64,
    cell: Option<FailureCell>,
    /// What it gained when it was tried.
    gain: f64,
    /// The ticks of the episode, and those with its share of a run-up.
    ticks: (f64, f64),
}

/// The elites, what each cell has earned, and the last tries.
#[derive(Debug, Clone, Default)]
struct Elites {
    /// The number of pedestrians that cross.
    pedestrians: usize,
    all: Vec<Elite>,
    /// What each cell has earned, and the share of a further reward that it gains.
    earned: BTreeMap<FailureCell, (f64, f64)>,
    memory: VecDeque<Try>,
    /// Ticks that were left of the budget after the last try.
    left: u64,
    calibration: Calibration,
}

/// What tries were expected to gain and what they gained, by their number at a start and by whether an earlier one there had failed the driver.
///
/// The best of several predictions is too high, and the more so the longer a start has gained nothing.
#[derive(Debug, Clone, Copy, Default)]
struct Calibration {
    expected: [[f64; 4]; 2],
    gained: [[f64; 4]; 2],
}

impl Calibration {
    /// The gain of a try as a share of the predicted gain.
    fn factor(&self, number: u32, worth: &Worth) -> f64 {
        let (number, failed) = (number.min(3) as usize, usize::from(worth.best > 0.0));
        (self.gained[failed][number] + DOUBT) / (self.expected[failed][number] + DOUBT)
    }

    fn note(&mut self, number: u32, worth: &Worth, expected: f64, gained: f64) {
        let (number, failed) = (number.min(3) as usize, usize::from(worth.best > 0.0));
        self.expected[failed][number] += expected;
        self.gained[failed][number] += gained;
    }
}

/// What a failure is worth at a start: how much worse it is than the worst there, and a share of its reward for a new way to fail.
#[derive(Debug, Clone, Copy, Default)]
struct Worth {
    /// The greatest reward from this start.
    best: f64,
    again: f64,
    /// Whether it guides the search, where an unknown crossing is predicted to gain the average.
    of_search: bool,
}

/// The experience of the last tries.
#[derive(Debug, Clone, Copy)]
struct Recent {
    /// Gain per tick, with the run-ups of all starts, also of those that were left at once.
    rate: f64,
    /// Mean ticks of an episode without its run-up.
    ticks: f64,
    /// Mean gain.
    gain: f64,
}

/// Maximum number of crossings that are kept of one kind of failure.
const MAX_ELITES: usize = 16;
/// Exponent of the preference for failures of a kind that was seldom found.
const NOVELTY: f64 = 0.5;
/// Share of the starts that are tried although their predicted gain is small. Without it a search whose starts cost no tick might never end.
const SECOND_LOOK: f64 = 0.1;
/// Number of the last tries whose gain is compared with the predicted gain of a start.
const RECENT_TRIES: usize = 200;
const FIRST_TRIES: usize = 60;
/// Most tries that are remembered.
const MEMORY: usize = 4000;
/// Goals that differ by this in one component are as far apart as contexts that differ by their scale.
const GOAL_SCALE: f64 = 0.15;
/// The square of the distance from which on a try says nothing, and the weight of the prior: the mean gain of the last tries.
const REACH: f64 = 4.0;
const PRIOR: f64 = 4.0;
/// The weight of the prior that predictions are right, in rewards.
const DOUBT: f64 = 0.5;
/// Variations of which that with the highest predicted gain is tried, and elites among which a controller chooses.
const CANDIDATES: usize = 8;
/// Crossings drawn uniformly that compete with the variations.
const STRANGERS: usize = 6;
const FIXED: [Goal; 2] = [Goal::INTERCEPT, Goal::HOMING];
const FINALISTS: usize = 32;

impl Elites {
    /// Adds a failure; of a full cell the elite with the least value leaves.
    fn add(&mut self, elite: Elite) {
        let cell = self.all.iter().enumerate().filter(|(_, each)| each.cell == elite.cell);
        if cell.clone().count() < MAX_ELITES {
            self.all.push(elite);
        } else if let Some((place, _)) = cell.min_by(|a, b| a.1.value().total_cmp(&b.1.value())) {
            self.all[place] = elite;
        }
    }

    /// Draws an elite for a start.
    fn draw(&self, context: &Context, stream: &mut Stream) -> Option<usize> {
        let weight = |elite: &Elite| {
            let near = kernel(context, &elite.context);
            near * near * self.gain(elite.value(), Some(elite.cell))
        };
        let mut sums: Vec<f64> = Vec::with_capacity(self.all.len());
        for elite in &self.all {
            sums.push(sums.last().copied().unwrap_or(0.0) + weight(elite));
        }
        let drawn = sums.last().copied().filter(|total| *total > 0.0)? * stream.random::<f64>();
        Some(sums.partition_point(|sum| *sum <= drawn).min(self.all.len() - 1))
    }

    /// What a reward gains: less if it is for a failure of a cell that has earned much.
    fn gain(&self, reward: f64, cell: Option<FailureCell>) -> f64 {
        reward * cell.and_then(|cell| self.earned.get(&cell)).map_or(1.0, |(_, share)| *share)
    }

    /// What a try is worth to a start.
    fn worth(&self, reward: f64, cell: Option<FailureCell>, worth: &Worth) -> f64 {
        let more = (reward - worth.best).max(0.0);
        more + worth.again * self.gain(reward.max(0.0), cell)
    }

    /// What the last tries gained per tick with their run-ups, the mean ticks of their episodes, and their mean gain.
    fn recent(&self) -> Recent {
        let last = || self.memory.iter().rev().take(RECENT_TRIES);
        let sum = |of: fn(&Try) -> f64| last().map(of).sum::<f64>();
        let of_crossings = |of: fn(&Try) -> f64| last().filter(|tried| !tried.goals.is_empty()).map(of).sum::<f64>();
        let count = of_crossings(|_| 1.0).max(1.0);
        Recent {
            rate: sum(|tried| tried.gain) / sum(|tried| tried.ticks.1).max(1.0),
            ticks: of_crossings(|tried| tried.ticks.0) / count,
            gain: of_crossings(|tried| tried.gain) / count,
        }
    }

    fn remember(&mut self, tried: Try) {
        if self.memory.len() == MEMORY {
            self.memory.pop_front();
        }
        if let Some(cell) = tried.cell {
            let (sum, share) = self.earned.entry(cell).or_default();
            *sum += tried.reward.max(0.0);
            *share = libm::pow(1.0 + *sum, -NOVELTY);
        }
        self.memory.push_back(tried);
    }

    /// What goals can be expected to be worth at a start: a mean over similar tries at similar starts, weighted by a biweight kernel.
    fn expect(&self, context: &Context, candidates: &[Vec<Goal>], worth: &Worth) -> Vec<f64> {
        let prior = if worth.of_search { self.recent().gain } else { 0.0 };
        let mut sums = vec![(PRIOR, PRIOR * prior); candidates.len()];
        for tried in &self.memory {
            let parts = context.iter().zip(&tried.context).zip(SCALES).map(|((a, b), scale)| (a - b) / scale);
            let apart: f64 = parts.map(|part| part * part).sum();
            if apart >= REACH {
                continue;
            }
            if tried.goals.is_empty() {
                continue;
            }
            let gain = self.worth(tried.reward, tried.cell, worth);
            for (goals, (weight, earned)) in candidates.iter().zip(&mut sums) {
                let share = 1.0 - (apart + mean_square(goals, &tried.goals)) / REACH;
                if share > 0.0 {
                    *weight += share * share;
                    *earned += share * share * gain;
                }
            }
        }
        sums.into_iter().map(|(weight, earned)| earned / weight).collect()
    }

    /// The goals with the highest predicted gain at a start: those of an elite, or of a scripted controller.
    fn best(&self, context: &Context) -> Vec<Goal> {
        let predicted = |elite: &Elite| kernel(context, &elite.context) * elite.value();
        let mut order: Vec<(f64, &Elite)> = self.all.iter().map(|elite| (predicted(elite), elite)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let elites = order.into_iter().map(|(_, elite)| elite.goals.clone());
        let fixed = FIXED.map(|goal| vec![goal; self.pedestrians]);
        let fallback = std::iter::repeat_with(|| vec![Goal::INTERCEPT; self.pedestrians]);
        let candidates: Vec<_> = fixed.into_iter().chain(elites).chain(fallback).take(FINALISTS).collect();
        let expected = self.expect(context, &candidates, &Worth::default());
        let best = expected.iter().zip(candidates).max_by(|a, b| a.0.total_cmp(b.0));
        best.expect("there are finalists").1
    }
}

impl Archive {
    /// A goal for a start.
    fn propose(&self, elites: &Elites, context: &Context, worth: &Worth, stream: &mut Stream) -> Proposal {
        let explore = stream.random::<f64>() < self.explore;
        let parent = if explore { None } else { elites.draw(context, stream) };
        let Some(parent) = parent else {
            // Before the first failure two thirds of the tries are those of the scripted controllers.
            let uniform = uniform(elites.pedestrians, stream);
            let fixed = FIXED.get(stream.random_range(0..=FIXED.len())).filter(|_| !explore);
            let goals = fixed.map_or(uniform, |fixed| vec![*fixed; elites.pedestrians]);
            let expected = elites.expect(context, std::slice::from_ref(&goals), worth)[0];
            return Proposal { goals, parent: None, expected };
        };
        let mut parents = [parent; CANDIDATES];
        for other in &mut parents[1..] {
            *other = elites.draw(context, stream).unwrap_or(parent);
        }
        let vary = |parent: usize| {
            let mut goals = elites.all[parent].goals.clone();
            let varied = if goals.len() > 1 { stream.random_range(0..goals.len()) } else { 0 };
            goals[varied] =
                Goal::new(goals[varied].components().map(|share| share + self.spread * standard_normal(stream)));
            goals
        };
        let mut goals: Vec<Vec<Goal>> = parents.into_iter().map(vary).collect();
        // The scripted controllers and crossings drawn uniformly compete with the variations.
        goals.extend(FIXED.map(|goal| vec![goal; elites.pedestrians]));
        goals.extend((0..STRANGERS).map(|_| uniform(elites.pedestrians, stream)));
        let expected = elites.expect(context, &goals, worth);
        let best = (0..goals.len()).max_by(|a, b| expected[*a].total_cmp(&expected[*b]));
        let best = best.expect("there are candidates");
        Proposal { goals: goals.swap_remove(best), parent: parents.get(best).copied(), expected: expected[best] }
    }

    /// Tries crossings from one start while their expected gain per tick exceeds the recent gain of the search; `None` if the budget is used up.
    fn search_from(
        &self,
        start: u64,
        simulator: &mut BudgetedSimulation<'_>,
        elites: &mut Elites,
        first: Option<(&mut Box<dyn WalkPolicy>, Stream)>,
        stream: &mut Stream,
    ) -> Option<()> {
        let mut worth = Worth { best: 0.0, again: self.again, of_search: true };
        if let Some((first, drawn)) = first {
            if !simulator.begin(start) {
                return None;
            }
            let (context, ready) = (context(&simulator.scene()), simulator.left());
            let reward = run(simulator, first.as_mut(), drawn)?;
            let (left, cell) = (simulator.left(), simulator.cell());
            let gain = elites.worth(reward, cell, &worth);
            worth.best = worth.best.max(reward);
            let ticks = ((ready - left) as f64, (elites.left - left) as f64);
            elites.left = left;
            elites.remember(Try { context, goals: Vec::new(), reward, cell, gain, ticks });
        }
        for number in 0..self.tries {
            if !simulator.begin(start) {
                return None;
            }
            let context = context(&simulator.scene());
            let begins = elites.memory.len() < FIRST_TRIES;
            let proposal = match begins && number == 0 && stream.random::<f64>() >= self.explore {
                true => Proposal { goals: vec![Goal::INTERCEPT; elites.pedestrians], parent: None, expected: 0.0 },
                false => self.propose(elites, &context, &worth, stream),
            };
            let Recent { rate, ticks, .. } = elites.recent();
            let expected = proposal.expected * elites.calibration.factor(number, &worth);
            let promising = expected > rate * ticks || (number == 0 && stream.random::<f64>() < SECOND_LOOK);
            // At first one interception from each start, and more only where it failed the driver.
            let leaves = if begins { number > 0 && worth.best <= 0.0 } else { !promising };
            if leaves {
                return Some(());
            }
            let ready = simulator.left();
            let reward = run(simulator, &mut Crossing::joint(&proposal.goals), Seed::root(0).stream())?;
            let left = simulator.left();
            let cell = simulator.cell();
            let gain = elites.worth(reward, cell, &worth);
            elites.calibration.note(number, &worth, proposal.expected, gain);
            worth.best = worth.best.max(reward);
            let ticks = ((ready - left) as f64, (elites.left - left) as f64);
            elites.left = left;
            let goals = proposal.goals;
            elites.remember(Try { context, goals: goals.clone(), reward, cell, gain, ticks });
            if let Some(parent) = proposal.parent {
                elites.all[parent].earned += reward.max(0.0);
                elites.all[parent].tries += 1.0;
            }
            if let Some(cell) = cell.filter(|_| reward > 0.0) {
                elites.add(Elite { context, goals, cell, reward, earned: 0.0, tries: 0.0 });
            }
        }
        Some(())
    }
}

impl Falsifier for ArchiveSearch {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched {
        let mut stream = seed.child("archive").stream();
        let mut first = self.from.as_ref().map(Controller::walk_policy);
        let mut faults = FaultStreak::default();
        // Crossings draw nothing.
        let drawn = |start: u64| seed.child("from").index(start).stream();
        let (budget, mut start) = (simulator.left(), 0);
        let pedestrians = simulator.scenario().cast.controlled().count();
        let mut elites = Elites { pedestrians, left: budget, ..Elites::default() };
        let kept = (budget as f64 * self.keys.choice) as u64;
        while simulator.left() > kept {
            let walker = first.as_mut().map(|walker| (walker, drawn(start)));
            if self.keys.search_from(start, simulator, &mut elites, walker, &mut stream).is_none() {
                break;
            }
            faults.count(first.as_ref().and_then(|walker| walker.fault()));
            if let Some(fault) = faults.hopeless() {
                return Err(TrainError::Controller { fault });
            }
            start += 1;
        }
        let found = Found { elites, crossing: Crossing::new(Goal::INTERCEPT), begun: false };
        let mut candidates: Vec<Box<dyn WalkPolicy>> = vec![Box::new(found), Box::new(Intercept), Box::new(Homing)];
        candidates.extend(first);
        // The same starts for all, one after another.
        let mut sums = vec![0.0; candidates.len()];
        loop {
            let mut earned = vec![None; candidates.len()];
            for (walker, earned) in candidates.iter_mut().zip(&mut earned) {
                *earned = if simulator.begin(start) { run(simulator, walker.as_mut(), drawn(start)) } else { None };
            }
            let Some(earned) = earned.into_iter().collect::<Option<Vec<f64>>>() else { break };
            sums.iter_mut().zip(earned).for_each(|(sum, earned)| *sum += earned);
            start += 1;
        }
        // The first of equal ones.
        let best = (0..sums.len()).rev().max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or_default();
        Ok(Some(candidates.swap_remove(best)))
    }
}

/// Runs the episode that has begun to its end and returns its reward; `None` if the budget is used up before.
fn run(simulator: &mut BudgetedSimulation<'_>, walker: &mut dyn WalkPolicy, drawn: Stream) -> Option<f64> {
    walker.begin(drawn);
    Some(play(simulator, walker, &mut ())?.reward)
}

/// The controller that the search ends up with: at each start the elite with the highest predicted gain.
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

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        if !self.begun {
            self.begun = true;
            self.crossing = Crossing::joint(&self.elites.best(&context(scene)));
        }
        self.crossing.choose(scene, commands);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
