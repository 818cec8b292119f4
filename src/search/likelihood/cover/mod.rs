//! Evidence of absence: how much of a box of parameters can have failures that a picture of it does not show.
//!
//! Two phases alternate. The *learning* phase puts points where the picture is least sure of the outcome. The *look* draws fresh points,
//! uniform in the box, and counts those that fail where the picture says that they pass. The points of a look are independent of the picture
//! that they check, so the count is binomial, and Clopper and Pearson's one-sided bound is exact. A look that does not show enough becomes
//! part of what the next picture is learnt from. All looks share the 5 %, so the statement that is made after the last one is true with 95 %
//! confidence whatever made the looks end.
//!
//! # Source
//! Local linear regression: Cleveland, *Robust locally weighted regression and smoothing scatterplots*, JASA 74, 1979, without its robustness
//! weights. Latin hypercube: McKay, Beckman and Conover, Technometrics 21, 1979. Bound: Clopper and Pearson, Biometrika 26, 1934.

mod design;
mod look;
mod picture;
#[cfg(test)]
mod tests;

pub(crate) use design::latin_hypercube;
pub use look::Look;
pub use picture::{Picture, Point, Sampled};

use std::ops::ControlFlow;

use base::seed::Seed;
pub(super) use design::uniform;
use look::{bound, share_of_look, size};
use picture::uncertain;

/// What is to be shown, and at what cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoverConfig {
    /// The number of parameters, at least one.
    pub dimensions: usize,
    /// The share of the box that is small enough, above 0 and below 1.
    pub epsilon: f64,
    /// The greatest number of experiments.
    pub budget: u64,
}

/// What was shown of a box.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Coverage {
    /// Every experiment, in order.
    pub points: Vec<Point>,
    /// The looks, in order; none only when it was stopped before the first.
    pub looks: Vec<Look>,
    /// The number of parameters.
    pub dimensions: usize,
    /// Whether it was stopped from outside.
    pub stopped: bool,
}

impl Coverage {
    /// The look with the least bound, the first of equals. All looks are true together with 95 % confidence, so the best may be chosen.
    pub fn best(&self) -> Option<&Look> {
        self.looks.iter().min_by(|a, b| a.bound.total_cmp(&b.bound))
    }

    /// The picture that a look checked.
    pub fn picture(&self, look: &Look) -> Picture {
        Picture::of(self.dimensions, &self.points[..look.learnt as usize])
    }

    /// The share of the box that a picture shows as failing, from 4,096 places that are spread over it.
    pub fn shown(&self, picture: &Picture) -> f64 {
        let places = latin_hypercube(SPREAD, self.dimensions, &mut Seed::root(0).child("shown").stream());
        places.iter().filter(|at| picture.fails(at)).count() as f64 / SPREAD as f64
    }

    /// The number of experiments that failed.
    pub fn failures(&self) -> u64 {
        self.points.iter().filter(|point| point.failed).count() as u64
    }
}

/// The places that measure a share of the box.
const SPREAD: usize = 4096;
/// The least number of points of the first design.
const MIN_DESIGN: u64 = 40;
/// A batch of learning is this part of the points so far.
const BATCH: u64 = 8;
/// The least number of points of a batch.
const MIN_BATCH: u64 = 10;
/// Candidates for each point of a batch, and their bounds.
const CANDIDATES: (u64, u64, u64) = (20, 500, 20_000);
/// The greatest number of points of a look that may be worse than the picture.
const MAX_WORSE: u64 = 20;

/// Whether a run at a point of the unit box, with this number, failed; a break to stop.
pub type Experiment<'a> = dyn FnMut(&[f64], u64) -> ControlFlow<(), bool> + 'a;

/// Learns a picture of where in the unit box an experiment fails, and checks it.
///
/// `experiment` gets a point of the unit box and the number of the experiment, and says whether it failed. It may be random: then "failed" has
/// a probability at each point, and the bound holds for the share of experiments, over the box and over chance. It may break to stop. The
/// result depends on the seed and on what the experiment says, on nothing else.
pub fn cover(config: &CoverConfig, seed: &Seed, experiment: &mut Experiment<'_>) -> Coverage {
    let mut work = Work {
        config,
        picture: Picture::of(config.dimensions, &[]),
        coverage: Coverage { points: Vec::new(), looks: Vec::new(), dimensions: config.dimensions, stopped: false },
        experiment,
    };
    let stopped = work.run(seed).is_break();
    Coverage { stopped, ..work.coverage }
}

/// A cover in progress.
struct Work<'a, 'b> {
    config: &'a CoverConfig,
    /// Knows all points that are not part of a look in progress.
    picture: Picture,
    coverage: Coverage,
    experiment: &'a mut Experiment<'b>,
}

impl Work<'_, '_> {
    fn run(&mut self, seed: &Seed) -> ControlFlow<()> {
        let CoverConfig { dimensions, epsilon, budget } = *self.config;
        let design = ((1.0 / epsilon) as u64).max(MIN_DESIGN).min(budget / 2);
        for at in latin_hypercube(design as usize, dimensions, &mut seed.child("design").stream()) {
            self.try_at(at, Sampled::Design)?;
        }
        self.learn_all();
        for number in 0.. {
            let seed = seed.index(number);
            let alpha = share_of_look(number);
            self.learn(&seed.child("learn"), self.reserve(alpha))?;
            let left = budget - self.used();
            let learnt = self.used();
            // A look may cost as much as what was learnt before it. More points allow more of them to be worse.
            let allowed = (1..=MAX_WORSE).take_while(|worse| size(*worse, epsilon, alpha) <= learnt.min(left)).last();
            let allowed = allowed.unwrap_or(0);
            let last = left < size(allowed, epsilon, alpha);
            // The last look uses what is left, whatever it finds: nothing could be learnt from it.
            let (planned, allowed) = if last { (left, left) } else { (size(allowed, epsilon, alpha), allowed) };
            let bound = self.look(&seed.child("look"), planned, allowed, alpha)?;
            if bound <= epsilon || last || self.used() >= budget {
                return ControlFlow::Continue(());
            }
        }
        ControlFlow::Continue(())
    }

    fn used(&self) -> u64 {
        self.coverage.points.len() as u64
    }

    /// What learning leaves for the look after it: the least look, or half of what is left.
    fn reserve(&self, alpha: f64) -> u64 {
        let left = self.config.budget - self.used();
        size(0, self.config.epsilon, alpha).min(left.div_ceil(2))
    }

    fn try_at(&mut self, at: Vec<f64>, sampled: Sampled) -> ControlFlow<(), bool> {
        let number = self.used();
        let failed = (self.experiment)(&at, number)?;
        self.coverage.points.push(Point { at, failed, sampled });
        ControlFlow::Continue(failed)
    }

    /// Lets the picture know all points.
    fn learn_all(&mut self) {
        let known = self.picture.len();
        self.coverage.points[known..].iter().for_each(|point| self.picture.learn(point));
    }

    /// Tries points near the boundary: at most as many as there are, and no more than leave `reserve`. Ends early where the picture is sure.
    fn learn(&mut self, seed: &Seed, reserve: u64) -> ControlFlow<()> {
        let mut stream = seed.stream();
        let room = (self.config.budget - self.used()).saturating_sub(reserve);
        let end = self.used() + self.used().min(room);
        while self.used() < end {
            let batch = (self.used() / BATCH).max(MIN_BATCH).min(end - self.used());
            let (each, least, most) = CANDIDATES;
            let candidates = (each * batch).clamp(least, most);
            let points = uncertain(&self.picture, candidates, batch, &mut stream);
            if points.is_empty() {
                break;
            }
            for at in points {
                self.try_at(at, Sampled::Learning)?;
            }
            self.learn_all();
        }
        ControlFlow::Continue(())
    }

    /// Checks the picture with fresh points; returns the bound. Ends early when more points are worse than `allowed`: the bound is then that of
    /// the points so far, which is on the safe side.
    fn look(&mut self, seed: &Seed, planned: u64, allowed: u64, alpha: f64) -> ControlFlow<(), f64> {
        let mut stream = seed.stream();
        let mut look = Look { learnt: self.used(), points: 0, worse: 0, better: 0, alpha, bound: 1.0 };
        while look.points < planned && look.worse <= allowed {
            let at = uniform(self.config.dimensions, &mut stream);
            let shown = self.picture.fails(&at);
            let failed = self.try_at(at, Sampled::Look)?;
            look.points += 1;
            look.worse += u64::from(failed && !shown);
            look.better += u64::from(shown && !failed);
        }
        look.bound = bound(look.worse, look.points, alpha);
        self.coverage.looks.push(look);
        self.learn_all();
        ControlFlow::Continue(look.bound)
    }
}
