use base::seed::{Seed, Tape};

/// All random numbers of an encounter. Equal lots give equal encounters.
#[derive(Debug, Clone)]
pub struct Lot {
    /// The number of the start: it chooses the cell where a spawn rule goes through cells in turn.
    pub number: u64,
    /// What the spawn rule draws.
    pub start: Tape,
    /// What the walker draws.
    pub walk: Tape,
    /// The seed of what drivers draw, the way to the start included.
    pub drivers: Seed,
    /// The decisions from which on drivers draw from another seed, in rising order.
    pub turns: Vec<(usize, Seed)>,
    /// The number of the walker's words that were drawn before each decision that was taken.
    pub before: Vec<usize>,
}

impl Lot {
    /// A fresh lot.
    pub fn new(number: u64, seed: &Seed) -> Self {
        Self {
            number,
            start: Tape::new(seed.child("start")),
            walk: Tape::new(seed.child("walk")),
            drivers: seed.child("drivers"),
            turns: Vec::new(),
            before: Vec::new(),
        }
    }

    /// The same up to a decision; from there on the walker and the drivers draw anew.
    pub fn redrawn(&self, decision: usize, seed: &Seed) -> Self {
        let walk = self.before.get(decision).map(|from| self.walk.redrawn(*from, seed.child("walk")));
        Self { walk: walk.unwrap_or_else(|| self.walk.clone()), ..self.with_other_drivers(decision, seed) }
    }

    /// The same, but the drivers draw anew from a decision on.
    pub fn with_other_drivers(&self, decision: usize, seed: &Seed) -> Self {
        let mut lot = self.clone();
        lot.turns.retain(|(turn, _)| *turn < decision);
        lot.turns.push((decision, seed.child("drivers")));
        lot
    }

    /// The seed from which drivers draw from this decision on, if it changes there.
    pub fn turn(&self, decision: usize) -> Option<Seed> {
        self.turns.iter().find(|(turn, _)| *turn == decision).map(|(_, seed)| *seed)
    }
}
