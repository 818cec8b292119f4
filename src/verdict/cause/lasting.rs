use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Incident;
use base::seed::Stream;
use episode::{PolicyMaker, Scenario};
use world::av::{DrivingMode, DrivingPolicy, Fault, Perception};
use world::sim::Control;

/// A driver that cannot be copied, and drives in one simulation after another as it does in a campaign: its process is started once.
#[derive(Clone)]
struct Lasting(Arc<Mutex<Box<dyn DrivingPolicy>>>);

impl Incident {
    /// The same incident, whose repetitions share the process of its driver, if it has one.
    pub(super) fn lasting(&self) -> Self {
        let mut scenario = Scenario::clone(&self.scenario);
        let make = &mut scenario.cast.vehicles[0].policy;
        *make = lasting(make.clone());
        Self { scenario: Arc::new(scenario), ..self.clone() }
    }
}

fn lasting(make: PolicyMaker) -> PolicyMaker {
    let all: Mutex<Vec<Lasting>> = Mutex::default();
    Arc::new(move || {
        let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
        // In no simulation any more.
        if let Some(idle) = all.iter().find(|each| Arc::strong_count(&each.0) == 1) {
            return Box::new(idle.clone());
        }
        let driver = make();
        if driver.snapshot().is_some() || driver.world_driver().is_some() {
            return driver;
        }
        Box::new(all.push_mut(Lasting(Arc::new(Mutex::new(driver)))).clone())
    })
}

impl Lasting {
    fn driver(&self) -> MutexGuard<'_, Box<dyn DrivingPolicy>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl DrivingPolicy for Lasting {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.driver().reset(perception, stream);
    }

    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver().speed_limit_for(speed)
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        self.driver().prepare(perception);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.driver().drive(perception)
    }

    fn mode(&self) -> DrivingMode {
        self.driver().mode()
    }

    fn fault(&self) -> Option<Fault> {
        self.driver().fault()
    }

    fn reseed(&mut self, stream: Stream) {
        self.driver().reseed(stream);
    }
}
