use super::optimizer::{CmaEs, CrossEntropy, Optimizer};
use super::{BudgetedSimulation, Falsifier, Searched};
use base::seed::{Seed, Stream};
use base::signature::DeclarationId;
use base::{choice, keys};
use episode::walker::WalkPolicy;
use episode::{ActionSpec, Cast, Criterion, Outcome, Scene, Simulation, play};
use road::geometry::wrap_angle;
use world::sim::WalkCommand;

choice! {
    /// What follows a failure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum AfterFailure {
        Next = "next",
        GoOn = "go_on",
    }
}

keys! {
    /// What decides about failures.
    pub struct FailureKeys {
        /// Whether a failure ends the search from its start, or it goes on for a better one until the tries are used up.
        after_failure: AfterFailure = "next",
    }
}

keys! {
    /// What all searches for a plan take.
    pub struct PlanKeys {
        /// What a plan is to earn, unless the search has a goal. Without both, its least distance from the car is to be small, and the car fast when hit.
        reward: Option<DeclarationId> as Reference("reward"),
        /// Commands of a plan; the last is kept up to the end.
        legs: usize as whole(1, 100) = "6",
        /// Decisions that each of them lasts.
        decisions: usize as whole(1, 1000) = "1",
        /// Most plans that are tried from one start.
        tries: u64 as whole(1, 1_000_000) = "200",
        /// First standard deviation of all components; 1 is half a turn, or half of the speeds.
        spread: f64 as within(RATIO, 0.01, 10.0) = "0.5",
        ..on: FailureKeys,
    }
}

keys! {
    /// The cross-entropy method over open-loop plans, start by start.
    pub struct CrossEntropyKeys = "cem" {
        ..plan: PlanKeys,
        /// Plans of a generation.
        population: usize as whole(2, 100_000) = "20",
        /// The best of them, from which it learns.
        elite: usize as whole(1, 100_000) = "5",
    }
}

keys! {
    /// The covariance matrix adaptation evolution strategy over open-loop plans, start by start.
    pub struct CmaEsKeys = "cma_es" {
        ..plan: PlanKeys,
        /// Plans of a generation; without it 4 + ⌊3 ln n⌋.
        population: Option<usize> as whole(4, 100_000),
    }
}

/// The minimiser that searches for the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    CrossEntropy {
        population: usize,
        elite: usize,
    },
    /// `None` for the population that is usual for the dimensions.
    CmaEs {
        population: Option<usize>,
    },
}

/// Searches start by start for a plan of commands that leads to a collision.
///
/// A plan is *open loop*: its headings are measured from the line to the ego at the start, do not turn with it, and do not depend on what
/// the driver does. It has a number of legs, each of a number of decisions; the last leg lasts to the end. Every start gets a fresh
/// minimiser and a number of tries. After a failure, or when the tries are used up, the next start follows. So a failure is not counted
/// repeatedly, and the starts keep the distribution of the scenario. Several pedestrians have one joint plan.
///
/// | component | from | to |
/// |---|---|---|
/// | heading | 0, the line to the ego | ±1 is ±180°, and on round the circle |
/// | speed | −1, the least | 1, the greatest, and back again beyond |
#[derive(Debug, Clone)]
pub struct OpenLoop {
    method: Method,
    plan: PlanKeys,
}

impl OpenLoop {
    /// The cross-entropy method.
    pub fn cross_entropy(keys: CrossEntropyKeys) -> Self {
        let CrossEntropyKeys { plan, population, elite } = keys;
        Self { method: Method::CrossEntropy { population, elite }, plan }
    }

    pub fn cma_es(CmaEsKeys { plan, population }: CmaEsKeys) -> Self {
        Self { method: Method::CmaEs { population }, plan }
    }

    fn optimizer(&self, cast: &Cast) -> Box<dyn Optimizer> {
        let dimensions = cast.controlled().count() * ActionSpec::DIM * self.plan.legs;
        let middle = vec![0.0; dimensions];
        match self.method {
            Method::CrossEntropy { population, elite } => {
                Box::new(CrossEntropy::new(middle, self.plan.spread, population, elite))
            }
            Method::CmaEs { population } => {
                let population = population.unwrap_or_else(|| CmaEs::usual_population(dimensions));
                Box::new(CmaEs::new(middle, self.plan.spread, population))
            }
        }
    }

    fn cost(&self, outcome: &Outcome, criterion: Criterion) -> f64 {
        match (self.plan.reward, criterion) {
            (Some(_), _) | (_, Criterion::Violation(_)) => -outcome.reward,
            _ if !outcome.counts() => f64::INFINITY,
            _ => criterion.margin(outcome, &[]).unwrap_or(f64::INFINITY),
        }
    }

    /// Evaluates plans from one start; `None` if the budget is used up.
    fn search_from(&self, start: u64, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Option<()> {
        let mut stream = seed.stream();
        let mut optimizer = self.optimizer(&simulator.scenario().cast);
        let mut tried = 0;
        while tried < self.plan.tries {
            let points = optimizer.ask(&mut stream);
            let mut costs = Vec::with_capacity(points.len());
            for point in &points {
                if tried == self.plan.tries {
                    return Some(());
                }
                tried += 1;
                if !simulator.begin(start) {
                    return None;
                }
                let scene = simulator.scene();
                let all = 0..scene.world.pedestrians.len();
                let limited = |pedestrian: usize| !scene.scenario.cast.pedestrians[pedestrian].action.is_any_heading();
                let line = |pedestrian| match limited(pedestrian) {
                    true => scene.action_origin(pedestrian, 0.0),
                    false => scene.homing(pedestrian).heading,
                };
                let lines: Vec<f64> = all.map(line).collect();
                let mut plan = Plan { keys: &self.plan, lines, point, decision: 0 };
                let outcome = play(simulator, &mut plan, &mut ())?;
                if simulator.is_failure() && self.plan.on.after_failure == AfterFailure::Next {
                    return Some(());
                }
                costs.push(self.cost(&outcome, simulator.scenario().criterion));
            }
            optimizer.tell(&points, &costs);
        }
        Some(())
    }
}

/// The commands of a plan, one leg after another.
struct Plan<'a> {
    keys: &'a PlanKeys,
    /// The direction from which each pedestrian's headings are measured (rad).
    lines: Vec<f64>,
    point: &'a [f64],
    decision: usize,
}

impl WalkPolicy for Plan<'_> {
    fn begin(&mut self, _: Stream) {
        self.decision = 0;
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let leg = (self.decision / self.keys.decisions).min(self.keys.legs - 1);
        self.decision += 1;
        let size = self.point.len() / self.keys.legs;
        let components = &self.point[leg * size..][..size];
        for ((pedestrian, role), part) in scene.scenario.cast.controlled().zip(components.as_chunks().0) {
            commands[pedestrian] = command(&role.action, self.lines[pedestrian], *part);
        }
    }
}

/// The command for the components of a plan, heading and speed. Headings are measured from `line` (rad): the line to the ego, or the origin of
/// the headings if the pedestrian cannot choose all.
fn command(spec: &ActionSpec, line: f64, [heading, speed]: [f64; ActionSpec::DIM]) -> WalkCommand {
    // Values are mirrored at either end: −1 and 3 are the least, 1 and 5 the greatest.
    let within = |(low, high): (f64, f64), value: f64| {
        let share = 1.0 - ((value + 1.0).rem_euclid(4.0) / 2.0 - 1.0).abs();
        low + share * (high - low)
    };
    let turn = if spec.is_any_heading() { heading * std::f64::consts::PI } else { within(spec.heading, heading) };
    WalkCommand { heading: wrap_angle(line + turn), speed: within(spec.speed, speed) }
}

impl Falsifier for OpenLoop {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched {
        for start in 0.. {
            if self.search_from(start, simulator, &seed.index(start)).is_none() {
                break;
            }
        }
        Ok(None)
    }
}
