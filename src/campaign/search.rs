use super::Observer;
use crate::compile::{Search, SearchKey};
use crate::env::Outcome;
use crate::falsifier::{Simulator, Spent, try_walker};
use crate::rl::TrainError;
use crate::seed::Seed;

/// What came of a search.
#[derive(Debug, Clone)]
pub struct SearchResult {
    /// Which search.
    pub key: SearchKey,
    /// How many simulator ticks it might use.
    pub budget: u64,
    /// What it did with them.
    pub spent: Spent,
    /// Fresh episodes of the pedestrian that it ended up with; empty without one.
    pub tried: Vec<Outcome>,
    /// Why it ended early.
    pub error: Option<TrainError>,
}

impl Search {
    /// The seed of its beginnings: the same for all falsifiers.
    pub fn beginnings(&self, seed: &Seed) -> Seed {
        seed.child("search").child(&self.key.town).child(&self.key.policy).index(self.key.run.into())
    }
}

/// Carries a search out; none when the observer stops it before it has begun.
pub fn search(search: &Search, seed: &Seed, observer: &dyn Observer) -> Option<SearchResult> {
    if observer.stop() {
        return None;
    }
    let key = &search.key;
    let stop = || observer.stop();
    let mut simulator = Simulator::new(search.scenario.clone(), search.beginnings(seed), search.budget, &stop);
    let place = |branch: &str| seed.child(branch).child(&key.town).child(&key.policy);
    let own = place("falsifier").child(&key.falsifier).index(key.run.into());
    let (walker, error) = match search.falsifier.search(&mut simulator, &own.child("search")) {
        Ok(walker) => (walker, None),
        Err(error) => (None, Some(error)),
    };
    let spent = simulator.into_spent();
    let tried = walker.filter(|_| !spent.stopped && search.tries > 0).map_or_else(Vec::new, |mut walker| {
        let (fresh, drawn) = (place("evaluate"), own.child("tries"));
        try_walker(walker.as_mut(), &search.scenario, search.tries, &fresh, &drawn, &mut |_| super::run::flow(observer))
    });
    Some(SearchResult { key: key.clone(), budget: search.budget, spent, tried, error })
}
