mod block;
mod written;

use std::sync::Arc;

use super::{Origin, Planned};
use base::seed::Seed;
pub(super) use block::BLOCK;
use episode::Scenario;
use episode::walker::Controller;
use search::hardening::{Attack, Hardening};
pub use written::{VariedKey, WrittenPolicy};

/// A driver that is to be hardened.
#[derive(Debug, Clone)]
pub struct Harden {
    pub origin: Origin,
    pub hardening: Arc<Hardening>,
    pub written: Arc<WrittenPolicy>,
}

impl Harden {
    /// The seed of all that it draws: the same for all drivers.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("harden").index(self.origin.run.into())
    }

    /// All numbers and names of the block that its results depend on, as a text.
    pub fn settings(&self) -> String {
        let Hardening { driver, towns, attacks, test_towns, walkers, rivals, rule, .. } = &*self.hardening;
        let Hardening { budget, rounds, candidates, lessons, traffic, episodes, .. } = &*self.hardening;
        let names =
            |places: &[(String, Arc<Scenario>)]| places.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let attackers = |all: &[Attack]| all.iter().map(|(name, ..)| name.clone()).collect::<Vec<_>>();
        format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {rule:?} {:?}",
            driver.keys,
            names(towns),
            attackers(attacks),
            names(test_towns),
            walkers.iter().map(Controller::name).collect::<Vec<_>>(),
            attackers(rivals),
            (budget, rounds, candidates, lessons, traffic, episodes)
        )
    }

    /// Simulator ticks that it may use at most, about: the attacks, and the test by falsifiers.
    pub fn budget(&self) -> u64 {
        let Hardening { budget, rounds, towns, attacks, test_towns, rivals, .. } = &*self.hardening;
        let attacks = u64::from(*rounds) * (attacks.len() * towns.len()) as u64;
        budget.saturating_mul(attacks + 2 * (rivals.len() * test_towns.len()) as u64)
    }
}

impl Planned for Harden {
    /// `idm, run 0`.
    fn title(&self) -> String {
        format!("{}, run {}", self.written.name, self.origin.run)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        let towns = self.hardening.towns.iter().chain(&self.hardening.test_towns);
        towns.map(|(town, scenario)| (town.as_str(), scenario)).collect()
    }

    fn units(&self, _: u32) -> u64 {
        self.budget()
    }

    /// Some falsifiers learn.
    fn depends_on_processor(&self) -> bool {
        true
    }

    fn shorten(&mut self) {
        let small = Arc::make_mut(&mut self.hardening);
        let longest = small.towns.iter().map(|(_, town)| town.longest()).max();
        small.budget = small.budget.min(10 * longest.unwrap_or(0));
        small.rounds = 1;
        small.candidates = small.candidates.min(3);
        small.lessons = small.lessons.min(2);
        small.traffic = small.traffic.min(2);
        small.episodes = small.episodes.min(5);
    }

    fn names(&self, _: Option<&dyn Planned>) -> Vec<String> {
        let Origin { block, run, fingerprint, .. } = &self.origin;
        let settings = self.settings();
        let all: [&dyn ToString; 6] = [&"harden", block, &self.written.name, run, fingerprint, &settings];
        all.map(ToString::to_string).into()
    }
}
