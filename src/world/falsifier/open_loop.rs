use super::optimizer::{CmaEs, CrossEntropy, Optimizer};
use super::{Falsifier, Simulator, TrainError, WalkPolicy};
use crate::env::{ActionSpec, Cast, Outcome};
use crate::geometry::wrap_angle;
use crate::sim::WalkCommand;
use base::seed::Seed;
use base::signature::{Arguments, Param, Signature, Type};
use base::units::Dimension;

/// The minimiser that searches for the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    CrossEntropy {
        population: usize,
        elite: usize,
        smoothing: f64,
    },
    /// None for the population that is usual for the dimensions.
    CmaEs {
        population: Option<usize>,
    },
}

/// The objective by which episodes are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Objective {
    /// The least distance to the car; among hits, the car's speed.
    Miss,
    /// The reward that the scenario pays.
    Reward,
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
#[derive(Debug, Clone, Copy)]
pub struct OpenLoop {
    method: Method,
    objective: Objective,
    legs: usize,
    decisions: usize,
    tries: u64,
    spread: f64,
    go_on: bool,
}

fn shared() -> Vec<Param> {
    let count = |max| Type::Integer { min: 1, max };
    vec![
        Param::optional(
            "reward",
            Type::Reference("reward"),
            "What a plan is to earn. Without it, its least distance from the car is to be small, and the car fast when hit.",
        ),
        Param::with_default("legs", count(100), "6", "Commands of a plan; the last is kept up to the end."),
        Param::with_default("decisions", count(1000), "1", "Decisions that each of them lasts."),
        Param::with_default("tries", count(1_000_000), "200", "Most plans that are tried from one start."),
        Param::with_default(
            "spread",
            Type::Quantity { dimension: Dimension::RATIO, min: 0.01, max: 10.0 },
            "0.5",
            "First standard deviation of all components; 1 is half a turn, or half of the speeds.",
        ),
        after_failure(),
    ]
}

/// The key that decides what follows a failure.
pub(super) fn after_failure() -> Param {
    Param::with_default(
        "after_failure",
        Type::Choice(&["next", "go_on"]),
        "next",
        "Whether a failure ends the search from its start, or it goes on for a better one until the tries are used up.",
    )
}

impl OpenLoop {
    /// The keys of the cross-entropy method in a scenario.
    pub fn cross_entropy_signature() -> Signature {
        let count = |min| Type::Integer { min, max: 100_000 };
        let mut params = shared();
        params.extend([
            Param::with_default("population", count(2), "20", "Plans of a generation."),
            Param::with_default("elite", count(1), "5", "The best of them, from which it learns."),
            Param::with_default(
                "smoothing",
                Type::Quantity { dimension: Dimension::RATIO, min: 0.01, max: 1.0 },
                "0.7",
                "Weight of the elite's moments against those before.",
            ),
        ]);
        let doc = "The cross-entropy method over open-loop plans, start by start.";
        Signature::new("cem", doc, params)
    }

    /// The keys of CMA-ES in a scenario.
    pub fn cma_es_signature() -> Signature {
        let mut params = shared();
        let population = Type::Integer { min: 4, max: 100_000 };
        params.push(Param::optional("population", population, "Plans of a generation; without it 4 + ⌊3 ln n⌋."));
        let doc = "The covariance matrix adaptation evolution strategy over open-loop plans, start by start.";
        Signature::new("cma_es", doc, params)
    }

    /// Makes one that uses the cross-entropy method, from checked arguments.
    pub fn cross_entropy(arguments: &Arguments) -> Self {
        let count = |key: &str| arguments.integer(key) as usize;
        let smoothing = arguments.number("smoothing");
        Self::new(Method::CrossEntropy { population: count("population"), elite: count("elite"), smoothing }, arguments)
    }

    /// Makes one that uses CMA-ES, from checked arguments.
    pub fn cma_es(arguments: &Arguments) -> Self {
        let population = arguments.has("population").then(|| arguments.integer("population") as usize);
        Self::new(Method::CmaEs { population }, arguments)
    }

    fn new(method: Method, arguments: &Arguments) -> Self {
        Self {
            method,
            objective: if arguments.has("reward") { Objective::Reward } else { Objective::Miss },
            legs: arguments.integer("legs") as usize,
            decisions: arguments.integer("decisions") as usize,
            tries: arguments.integer("tries") as u64,
            spread: arguments.number("spread"),
            go_on: arguments.choice("after_failure") == "go_on",
        }
    }

    fn optimizer(&self, cast: &Cast) -> Box<dyn Optimizer> {
        let dimensions = cast.controlled().count() * ActionSpec::DIM * self.legs;
        let middle = vec![0.0; dimensions];
        match self.method {
            Method::CrossEntropy { population, elite, smoothing } => {
                Box::new(CrossEntropy::new(middle, self.spread, population, elite, smoothing))
            }
            Method::CmaEs { population } => {
                let population = population.unwrap_or_else(|| CmaEs::usual_population(dimensions));
                Box::new(CmaEs::new(middle, self.spread, population))
            }
        }
    }

    fn cost(&self, outcome: &Outcome) -> f64 {
        match self.objective {
            Objective::Reward => -outcome.reward,
            Objective::Miss => outcome.impact_speed().map_or(outcome.least_gap, |speed| -1.0 - speed),
        }
    }

    /// Evaluates plans from one start; none when the budget is used up.
    fn search_from(&self, start: u64, simulator: &mut Simulator<'_>, seed: &Seed) -> Option<()> {
        let mut stream = seed.stream();
        let mut optimizer = self.optimizer(&simulator.env().scenario().cast);
        let mut tried = 0;
        while tried < self.tries {
            let points = optimizer.ask(&mut stream);
            let mut costs = Vec::with_capacity(points.len());
            for point in &points {
                if tried == self.tries {
                    return Some(());
                }
                tried += 1;
                if !simulator.begin(start) {
                    return None;
                }
                let env = simulator.env();
                let all = 0..env.world().pedestrians.len();
                let limited = |pedestrian| !env.scenario().cast.pedestrian(pedestrian).action.is_any_heading();
                let line = |pedestrian| match limited(pedestrian) {
                    true => env.action_origin(pedestrian, 0.0),
                    false => env.homing(pedestrian).heading,
                };
                let lines: Vec<f64> = all.map(line).collect();
                let mut decision = 0;
                let outcome = simulator.finish(|env, commands| {
                    let leg = (decision / self.decisions).min(self.legs - 1);
                    decision += 1;
                    let cast = &env.scenario().cast;
                    let components = point.chunks_exact(point.len() / self.legs).nth(leg).expect("a plan has its legs");
                    for ((pedestrian, role), part) in cast.controlled().zip(components.as_chunks().0) {
                        commands[pedestrian] = command(&role.action, lines[pedestrian], *part);
                    }
                })?;
                if outcome.is_collision() && !self.go_on {
                    return Some(());
                }
                costs.push(self.cost(&outcome));
            }
            optimizer.tell(&points, &costs);
        }
        Some(())
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
    fn search(&self, simulator: &mut Simulator<'_>, seed: &Seed) -> Result<Option<Box<dyn WalkPolicy>>, TrainError> {
        for start in 0.. {
            if self.search_from(start, simulator, &seed.index(start)).is_none() {
                break;
            }
        }
        Ok(None)
    }
}
