use std::sync::Arc;

use super::{Origin, Planned};
use crate::RunId;
use base::seed::Seed;
use episode::{Criterion, EpisodeRule, RewardRule, Scenario};
use world::av::{Cruise, CruiseKeys};

/// What a driver gives for safety in a town: its progress, and needless braking.
#[derive(Debug, Clone)]
pub struct Pricing {
    pub origin: Origin,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    /// The car and one pedestrian, without traffic lights.
    pub scenario: Arc<Scenario>,
    /// The same with a driver that drives as fast as limits and bends allow.
    pub free: Arc<Scenario>,
    pub starts: u32,
}

/// The longest episode (s): its end comes when the pedestrian has long crossed.
const LONGEST: f64 = 30.0;

impl Pricing {
    /// The seed of its starts, the same for all drivers.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        seed.child("price").child(&self.town)
    }
}

impl Planned for Pricing {
    fn title(&self) -> String {
        format!("{} in {}", self.policy, self.town)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.town, &self.scenario)]
    }

    fn units(&self, _: u32) -> u64 {
        self.starts.into()
    }

    fn ticks(&self, _: u32) -> u64 {
        3 * u64::from(self.starts) * self.scenario.longest()
    }

    fn shorten(&mut self) {
        self.starts = self.starts.min(2);
    }

    fn names(&self, _: Option<&dyn Planned>) -> Vec<String> {
        let Self { origin, town, policy, starts, .. } = self;
        let all: [&dyn ToString; 5] = [&"price", town, policy, &origin.fingerprint, starts];
        all.map(ToString::to_string).into()
    }
}

impl Pricing {
    /// That of a driver in a town, in the setting of another job, without any start.
    pub(super) fn new(origin: &Origin, [town, policy]: [&str; 2], scenario: &Scenario) -> Self {
        let ticks = scenario.episode.ticks.min((LONGEST / scenario.episode.tick) as u32);
        let scenario = Scenario {
            cast: scenario.cast.alone(0),
            reward: RewardRule::default(),
            requirements: Arc::default(),
            criterion: Criterion::Collision,
            episode: EpisodeRule { ticks, end_when: None, traffic_lights: false, ..scenario.episode.clone() },
            oracle: None,
            ..scenario.clone()
        };
        let mut free = scenario.clone();
        let fastest = || Cruise::new(CruiseKeys { limit_share: 1.0, ..CruiseKeys::default() });
        free.cast.vehicles[0].policy = Arc::new(move || Box::new(fastest()));
        let origin = Origin { id: RunId::default(), block: 0, run: 0, needs: None, ..origin.clone() };
        let (scenario, free) = (Arc::new(scenario), Arc::new(free));
        Self { origin, town: town.into(), policy: policy.into(), scenario, free, starts: 0 }
    }
}
