use super::{ActorId, Pedestrian, PedestrianBody, PedestrianState, Vehicle, VehicleBlueprint, VehicleState};
use road::LEVEL;
use road::geometry::{OrientedBox, Touch, first_touch, first_touch_of_boxes};

/// The first touch of a vehicle with a pedestrian or with another vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The vehicle, and the pedestrian or vehicle that touched it. Of two vehicles the first is the one with the smaller number.
    pub pair: (ActorId, ActorId),
    /// Its time, as a share of the tick from 0 to 1.
    pub fraction: f64,
    /// Bearing of the second's centre from the middle of the first's box (rad), positive to the left.
    pub bearing: f64,
    /// Distance of the second's centre ahead of the middle of the first's box (m).
    pub ahead: f64,
    /// Distance of the second's centre to the left of the first's axis (m).
    pub aside: f64,
    /// Speed of the first at that time (m/s).
    pub impact_speed: f64,
}

impl Contact {
    /// Whether the second was within the first's front sector of this half angle (rad).
    ///
    /// # Source
    /// The paper's commented text: −60° to 60° about the forward axis, from the centre; parts of the sides belong to it.
    pub fn is_front(&self, half_angle: f64) -> bool {
        self.bearing.abs() <= half_angle
    }

    /// The number of the pedestrian that touched the ego; `None` if other actors touched.
    pub fn pedestrian_at_ego(&self) -> Option<usize> {
        match self.pair {
            (ActorId::EGO, ActorId::Pedestrian(number)) => Some(number.into()),
            _ => None,
        }
    }

    /// Whether a vehicle and a pedestrian may have touched in the last tick of `dt` (s). If they are far apart nothing is computed:
    /// neither moves more than a few metres in a tick.
    #[inline]
    pub(super) fn is_pedestrian_near(vehicle: &Vehicle, pedestrian: &Pedestrian, dt: f64) -> bool {
        let (blueprint, body) = (&vehicle.blueprint, &pedestrian.body);
        let reach = blueprint.half_length + blueprint.half_width + body.reach() + 2.0;
        let moved = (vehicle.fastest() + pedestrian.before.speed() + pedestrian.state.speed()) * dt;
        let apart = (pedestrian.state.pose.position() - vehicle.state.pose.position()).norm_squared();
        apart <= (reach + moved) * (reach + moved) && (pedestrian.state.ground - vehicle.state.ground).abs() < LEVEL
    }

    /// Finds the first touch of a vehicle and a pedestrian in the last tick.
    pub(super) fn with_pedestrian(
        pair: (ActorId, ActorId),
        vehicle: &Vehicle,
        pedestrian: &Pedestrian,
    ) -> Option<Self> {
        let (cars, walkers) = ([&vehicle.before, &vehicle.state], [&pedestrian.before, &pedestrian.state]);
        let touch = touch_of_pedestrian(cars, &vehicle.blueprint, walkers, &pedestrian.body)?;
        Some(Self::new(pair, cars, &touch))
    }

    /// Finds the first touch of the ego and the first pedestrian between two instants, from their states at both.
    pub fn of_ego_in_step(
        ego: [&VehicleState; 2],
        blueprint: &VehicleBlueprint,
        pedestrian: [&PedestrianState; 2],
        body: &PedestrianBody,
    ) -> Option<Self> {
        let touch = touch_of_pedestrian(ego, blueprint, pedestrian, body)?;
        Some(Self::new((ActorId::EGO, ActorId::Pedestrian(0)), ego, &touch))
    }

    /// Whether two vehicles may have touched in the last tick of `dt` (s).
    #[inline]
    pub(super) fn is_vehicle_near(first: &Vehicle, second: &Vehicle, dt: f64) -> bool {
        let radius = |vehicle: &Vehicle| vehicle.blueprint.half_length + vehicle.blueprint.half_width;
        let reach = radius(first) + radius(second) + (first.fastest() + second.fastest()) * dt;
        let apart = (second.state.pose.position() - first.state.pose.position()).norm_squared();
        apart <= reach * reach && (second.state.ground - first.state.ground).abs() < LEVEL
    }

    /// Finds the first touch of two vehicles in the last tick.
    pub(super) fn with_vehicle(pair: (ActorId, ActorId), first: &Vehicle, second: &Vehicle) -> Option<Self> {
        let start = |vehicle: &Vehicle| vehicle.before.outline(&vehicle.blueprint);
        let touch = first_touch_of_boxes(&start(first), &first.outline(), &start(second), &second.outline())?;
        Some(Self::new(pair, [&first.before, &first.state], &touch))
    }

    fn new(pair: (ActorId, ActorId), [before, after]: [&VehicleState; 2], touch: &Touch) -> Self {
        Self {
            pair,
            fraction: touch.fraction,
            bearing: libm::atan2(touch.local.y, touch.local.x),
            ahead: touch.local.x,
            aside: touch.local.y,
            impact_speed: before.speed + (after.speed - before.speed) * touch.fraction,
        }
    }
}

/// The first touch of a vehicle and a pedestrian, from their states at the start and at the end of a tick.
fn touch_of_pedestrian(
    vehicle: [&VehicleState; 2],
    blueprint: &VehicleBlueprint,
    pedestrian: [&PedestrianState; 2],
    body: &PedestrianBody,
) -> Option<Touch> {
    let [start, end] = vehicle.map(|state| state.outline(blueprint));
    let [from, to] = pedestrian.map(|state| state.pose);
    match body.target_box {
        None => first_touch(from.position(), to.position(), body.radius, &start, &end),
        Some(half) => {
            let [before, after] = [from, to].map(|pose| OrientedBox { pose, half });
            first_touch_of_boxes(&start, &end, &before, &after)
        }
    }
}
