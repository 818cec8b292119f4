use crate::{Scenario, Trace};
use road::geometry::{Pose, Vector};
use world::sim::ActorId;

/// An actor of a recorded episode.
#[derive(Debug, Clone, Copy)]
pub struct RecordedActor<'a> {
    pub id: ActorId,
    /// The name of its role.
    pub name: &'a str,
    /// Half extents along its heading and across it (m).
    pub half: Vector,
    /// Whether it is parked.
    pub is_parked: bool,
    trace: &'a Trace,
}

impl<'a> RecordedActor<'a> {
    pub(super) fn new(scenario: &'a Scenario, trace: &'a Trace, id: ActorId) -> Self {
        let (half, is_parked) = match id {
            ActorId::Vehicle(number) => {
                let role = &scenario.cast.vehicles[usize::from(number)];
                (Vector::new(role.blueprint.half_length, role.blueprint.half_width), role.is_parked)
            }
            ActorId::Pedestrian(number) => (scenario.cast.pedestrians[usize::from(number)].body.half(), false),
        };
        Self { id, name: scenario.cast.name(id), half, is_parked, trace }
    }

    /// Its pose and its speed (m/s) after a tick; tick 0 is the start.
    pub fn state(&self, tick: usize) -> (Pose, f64) {
        match self.id {
            ActorId::Vehicle(number) => {
                let state = &self.trace.vehicle(number.into())[tick].state;
                (state.pose, state.speed)
            }
            ActorId::Pedestrian(number) => {
                let state = &self.trace.pedestrian(number.into())[tick];
                (state.pose, state.speed())
            }
        }
    }

    /// Whether it was in the world after a tick, if its role was.
    pub fn is_present(&self, tick: usize) -> bool {
        match self.id {
            ActorId::Vehicle(_) => true,
            ActorId::Pedestrian(number) => self.trace.is_present(number.into(), tick),
        }
    }

    pub fn is_pedestrian(&self) -> bool {
        matches!(self.id, ActorId::Pedestrian(_))
    }
}
