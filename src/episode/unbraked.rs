use std::ops::ControlFlow;
use std::sync::Arc;

use crate::walker::Scripted;
use crate::{Scenario, evaluate};
use base::seed::Seed;
use world::av::{Cruise, CruiseKeys};

impl Scenario {
    /// The same with a driver that brakes for nobody, in our simulator and without further actors: what it passes says nothing of other drivers.
    pub fn unbraked(&self) -> Self {
        let mut scenario = Self { external_world: None, cast: self.cast.alone(0), ..self.clone() };
        scenario.cast.vehicles[0].policy = Arc::new(|| Box::new(Cruise::new(CruiseKeys::default())));
        scenario
    }

    /// Which cases of its test can fail: those that the driver of [`Scenario::unbraked`] does not pass. Empty without a test.
    pub fn decisive_cases(&self) -> Vec<bool> {
        let Some(walk) = &self.spawn.target_walk else { return Vec::new() };
        let scenario = Arc::new(Self { requirements: [].into(), ..self.unbraked() });
        let (cases, seed) = (walk.cases.len() as u32, Seed::root(0).child("unbraked"));
        let outcomes = evaluate(&mut Scripted, &scenario, cases, &seed, &seed, &mut |_| ControlFlow::Continue(()));
        let fails = |(case, outcome): (_, &crate::Outcome)| {
            let limit = walk.criterion.limit(walk.case(case).test_speed);
            outcome.counts()
                && outcome.impact_speed().is_some_and(|speed| walk.judged_speed(speed, walk.command()) > limit)
        };
        (0..).zip(&outcomes).map(fails).collect()
    }
}
