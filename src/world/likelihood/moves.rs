use std::rc::Rc;

use rand::RngExt;

use super::{Lot, TestBed};
use base::seed::{Seed, Stream};

/// An encounter of a population.
pub(super) struct Particle<M> {
    pub lot: Lot,
    /// Its greatest level; the least number if it does not count.
    pub height: f64,
    pub counts: bool,
    /// The greatest level before each decision, and at the end.
    pub climb: Rc<[f64]>,
    /// Copies of its states, in the order of their decisions.
    marks: Vec<(usize, Rc<M>)>,
}

impl<M> Clone for Particle<M> {
    fn clone(&self) -> Self {
        Self { lot: self.lot.clone(), climb: self.climb.clone(), marks: self.marks.clone(), ..*self }
    }
}

/// The steps of the moves, and how often those were accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steps {
    /// Of the words of the start, of the walker, and of both: 0 for none, 1 for fresh ones.
    pub sizes: [f64; 3],
    tried: [u32; 3],
    accepted: [u32; 3],
}

/// The share of accepted moves that is aimed at.
const WANTED: f64 = 0.4;
/// Least and greatest step.
const SIZES: (f64, f64) = (0.005, 1.0);

impl Steps {
    pub fn new() -> Self {
        Self { sizes: [0.5; 3], tried: [0; 3], accepted: [0; 3] }
    }

    /// Changes the steps towards the wanted share of accepted ones.
    pub fn adapt(&mut self) {
        for ((size, tried), accepted) in self.sizes.iter_mut().zip(self.tried).zip(self.accepted) {
            if tried > 0 {
                let share = f64::from(accepted) / f64::from(tried);
                *size = (*size * libm::exp(1.5 * (share - WANTED))).clamp(SIZES.0, SIZES.1);
            }
        }
        (self.tried, self.accepted) = ([0; 3], [0; 3]);
    }
}

/// What a move changes.
enum Kind {
    /// The words of the start, of the walker, or of both, by a step.
    Vary(usize),
    /// All that is drawn from a decision on.
    Redraw(usize),
    /// What the drivers draw from a decision on.
    OtherDrivers(usize),
}

/// Runs an encounter from its start.
pub(super) fn run<B: TestBed>(bed: &mut B, mut lot: Lot, level: f64) -> Particle<B::Mark> {
    bed.begin(&mut lot);
    go_on(bed, lot, vec![bed.level()], Vec::new(), level)
}

/// Runs an encounter to its end, from a state before a decision. The state at which it reaches a level is copied.
fn go_on<B: TestBed>(
    bed: &mut B,
    mut lot: Lot,
    mut climb: Vec<f64>,
    mut marks: Vec<(usize, Rc<B::Mark>)>,
    level: f64,
) -> Particle<B::Mark> {
    if marks.is_empty() && climb.len() == 1 {
        marks.extend(bed.mark().map(|mark| (0, Rc::new(mark))));
    }
    let mut below = climb.last().is_none_or(|last| *last < level);
    while bed.step(&mut lot) {
        climb.push(bed.level());
        if below && bed.level() >= level {
            below = false;
            marks.truncate(1);
            marks.extend(bed.mark().map(|mark| (climb.len() - 1, Rc::new(mark))));
        }
    }
    let trial = bed.trial();
    climb.push(trial.level);
    Particle { lot, height: trial.height(), counts: trial.counts, climb: climb.into(), marks }
}

impl<M> Particle<M> {
    /// The number of decisions that were taken.
    fn decisions(&self) -> usize {
        self.climb.len() - 1
    }

    /// Tries a move that leaves the law of encounters at or above a level as it is; whether the encounter was simulated, in whole or in part.
    ///
    /// All moves are as likely to go as to come back, so a move is accepted if the level is reached:
    /// - Words are varied by a step ([`Tape::varied`](base::seed::Tape::varied)).
    /// - All is redrawn from the decision on at which the level was reached: a *branch*. It always stays above the level.
    /// - All, or only what drivers draw, is redrawn from a decision on that is drawn uniformly.
    pub fn vary<B: TestBed<Mark = M>>(
        &mut self,
        bed: &mut B,
        level: f64,
        steps: &mut Steps,
        longest: usize,
        seed: Seed,
    ) -> bool {
        let mut stream = seed.child("choice").stream();
        let moved = match self.choose(level, longest, &mut stream) {
            Kind::Vary(scope) => {
                let size = steps.sizes[scope];
                let mut lot = self.lot.clone();
                if scope != 1 {
                    lot.start = lot.start.varied(seed.child("start"), |_| size);
                }
                if scope != 0 {
                    lot.walk = lot.walk.varied(seed.child("walk"), |_| size);
                }
                // The way to the start and the run-up stay where the start stays.
                let from = if scope == 1 { 0 } else { usize::MAX };
                let moved = self.again(bed, lot, from, level);
                steps.tried[scope] += 1;
                steps.accepted[scope] += u32::from(moved.height >= level);
                moved
            }
            Kind::Redraw(decision) if decision >= self.decisions() => return false,
            Kind::Redraw(decision) => self.again(bed, self.lot.redrawn(decision, &seed), decision, level),
            Kind::OtherDrivers(decision) if decision >= self.decisions() => return false,
            Kind::OtherDrivers(decision) => {
                self.again(bed, self.lot.with_other_drivers(decision, &seed), decision, level)
            }
        };
        if moved.height >= level {
            *self = moved;
        }
        true
    }

    fn choose(&self, level: f64, longest: usize, stream: &mut Stream) -> Kind {
        let walks = self.lot.walk.drawn() > 0;
        let scope = if walks { stream.random_range(0..3) } else { 0 };
        let decision = stream.random_range(0..longest.max(1));
        // Drivers may draw without the walker; a test bed without decisions has neither.
        match stream.random::<f64>() {
            _ if longest <= 1 => Kind::Vary(scope),
            share if share < 0.6 => Kind::Vary(scope),
            share if share < 0.75 => {
                let reached = self.climb.iter().position(|climbed| *climbed >= level);
                Kind::Redraw(reached.unwrap_or(usize::MAX))
            }
            share if share < 0.9 => Kind::Redraw(decision),
            _ => Kind::OtherDrivers(decision),
        }
    }

    /// Runs the encounter of a lot that agrees with this one's up to a decision; `usize::MAX` for one that agrees in nothing.
    fn again<B: TestBed<Mark = M>>(&self, bed: &mut B, mut lot: Lot, decision: usize, level: f64) -> Self {
        let near = self.marks.iter().rev().find(|(at, _)| *at <= decision && decision < usize::MAX);
        let Some((at, mark)) = near else { return run(bed, lot, level) };
        bed.restore(mark, &mut lot);
        let marks = self.marks.iter().filter(|(other, _)| other <= at).cloned().collect();
        go_on(bed, lot, self.climb[..=*at].to_vec(), marks, level)
    }
}
