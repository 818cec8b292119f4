use super::LocalSimulation;
use super::touched::{Severity, Touched, Touches};
use crate::{MOVING_ABOVE, Scenario};
use world::sim::Contact;

/// An episode goes on for this time after the car has touched somebody (s): as long as a verdict lets the pedestrian go on.
const GOES_ON: f64 = 5.0;

impl Scenario {
    /// The most ticks that are simulated after the last one of an episode, to see whether the car touches another pedestrian.
    pub fn most_ticks_beyond(&self) -> u32 {
        let is_open = self.cast.pedestrians.len() > 1 && self.external_world.is_none();
        if is_open { (GOES_ON / self.episode.tick) as u32 } else { 0 }
    }
}

/// The first touch does not hide a second: whom the car has touched leaves the world, and the others keep their commands. The episode is that of
/// the worst touch; of equal ones, of the first.
impl LocalSimulation {
    /// Whether the episode goes on after this tick, since the car has touched a pedestrian and may touch another. At its end the simulation is
    /// in the tick of the worst touch.
    pub(super) fn goes_on(&mut self) -> bool {
        // What comes after the end of the road, or beside it, does not count.
        if self.touches.is_some() && self.observers.road.left_out.is_some() {
            self.go_back();
            return false;
        }
        while let Some((hit, number)) = self.actions.contact.and_then(|hit| Some((hit, hit.pedestrian_at_ego()?))) {
            if self.touches.is_none() && !self.has_others(number) {
                return false;
            }
            let severity = self.severity(&hit);
            if self.touches.as_ref().is_none_or(|touches| touches.worst.severity < severity) {
                let (world, actions, observers) = (self.world.clone(), self.actions.clone(), self.observers.clone());
                let until = self.world.ticks + (GOES_ON / self.world.dt) as u32;
                let until =
                    self.touches.as_ref().map_or(until.min(self.scenario.episode.ticks), |touches| touches.until);
                self.touches = Some(Touches { until, worst: Touched { severity, world, actions, observers } });
            }
            if severity == Severity::Fault || !self.has_others(number) {
                break;
            }
            self.world.pedestrians[number].strike();
            self.actions.contact = self.world.first_contact();
            self.observers.touch(number, self.actions.contact);
        }
        let Some(touches) = &self.touches else { return false };
        let is_over = self.actions.contact.is_some() || self.world.ticks >= touches.until;
        if is_over {
            self.go_back();
        }
        !is_over
    }

    /// Goes back to the tick of the worst touch. Returns false if there was none.
    pub(super) fn go_back(&mut self) -> bool {
        let Some(Touches { worst, .. }) = self.touches.take() else { return false };
        self.ticks_beyond = self.world.ticks - worst.world.ticks;
        (self.world, self.actions, self.observers) = (worst.world, worst.actions, worst.observers);
        true
    }

    /// Whether the car can touch a pedestrian beside this one. In another simulator nobody can leave the world.
    fn has_others(&self, touched: usize) -> bool {
        let mut pedestrians = self.world.pedestrians.iter().enumerate();
        self.bridge.is_none() && pedestrians.any(|(number, each)| number != touched && each.is_present)
    }

    fn severity(&self, hit: &Contact) -> Severity {
        let judgement = self.observers.judgement(&self.scenario).unwrap_or_default();
        match () {
            () if hit.impact_speed <= MOVING_ABOVE => Severity::Bump,
            () if judgement.fault => Severity::Fault,
            () if judgement.preventable => Severity::Preventable,
            () => Severity::Collision,
        }
    }
}
