use super::{Actor, Path, Perception};
use road::geometry::{Point, Vector};

/// A path as a line with lengths along it, measured from abeam the ego, for drivers with forecasts.
#[derive(Debug, Clone, Default)]
pub struct RouteTrace {
    stations: Vec<Station>,
}

/// A point of the line and the unit vector to the next one.
#[derive(Debug, Clone, Copy)]
struct Station {
    along: f64,
    place: Point,
    direction: Vector,
}

/// The place and motion of an object, along the line and to the left of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnTrace {
    /// How far ahead of the ego's middle (m) and to the left of the line (m).
    pub place: Vector,
    /// Velocity along and across the line (m/s).
    pub velocity: Vector,
    /// Half of its extent along and across the line (m).
    pub reach: Vector,
}

impl RouteTrace {
    /// Builds the line from the path that is ahead of the ego now.
    pub fn follow(&mut self, path: &Path, perception: &Perception<'_>) {
        self.stations.clear();
        let mut points = path.points().map(|point| &point.pose);
        let Some(mut last) = points.next() else { return };
        let mut along = -last.to_local(perception.ego.pose.position()).x;
        for next in points {
            let chord = next.position() - last.position();
            let length = chord.norm();
            if length > 1e-6 {
                self.stations.push(Station { along, place: last.position(), direction: chord / length });
                along += length;
            }
            last = next;
        }
    }

    /// The place and the unit vector ahead of a car that has driven this far (m).
    pub fn at(&self, along: f64) -> Option<(Point, Vector)> {
        let after = self.stations.partition_point(|station| station.along <= along);
        let station = self.stations.get(after.saturating_sub(1))?;
        Some((station.place + station.direction * (along - station.along), station.direction))
    }

    /// The place and motion of an actor, relative to the piece of the line that is nearest to it.
    pub fn locate(&self, actor: &Actor) -> Option<OnTrace> {
        self.locate_with(actor.pose.position(), &actor.velocity, |ahead| reach_of(actor, ahead))
    }

    /// The place and motion (m/s) of a point, relative to the piece of the line that is nearest to it.
    pub fn locate_point(&self, place: Point, velocity: &Vector) -> Option<OnTrace> {
        self.locate_with(place, velocity, |_| Vector::zeros())
    }

    /// The place and motion of an actor as [`RouteTrace::locate`] gives them, if the line went straight on after this length (m).
    pub fn locate_straight_after(&self, length: f64, actor: &Actor) -> Option<OnTrace> {
        let known = self.stations.partition_point(|station| station.along <= length).max(1).min(self.stations.len());
        let reach = |ahead: &Vector| reach_of(actor, ahead);
        locate_with(&self.stations[..known], actor.pose.position(), &actor.velocity, reach)
    }

    fn locate_with(&self, place: Point, velocity: &Vector, reach: impl Fn(&Vector) -> Vector) -> Option<OnTrace> {
        locate_with(&self.stations, place, velocity, reach)
    }
}

fn locate_with(
    stations: &[Station],
    place: Point,
    velocity: &Vector,
    reach: impl Fn(&Vector) -> Vector,
) -> Option<OnTrace> {
    let mut best: Option<(f64, f64, &Station)> = None;
    for (index, station) in stations.iter().enumerate() {
        let offset = place - station.place;
        let next = stations.get(index + 1).map_or(f64::INFINITY, |next| next.along);
        // Before its first point the line is straight.
        let low = if index == 0 { f64::NEG_INFINITY } else { 0.0 };
        let share = offset.dot(&station.direction).clamp(low, next - station.along);
        let distance = (offset - station.direction * share).norm_squared();
        if best.is_none_or(|(nearest, ..)| distance < nearest) {
            best = Some((distance, share, station));
        }
    }
    let (_, share, station) = best?;
    let (ahead, offset) = (station.direction, place - station.place);
    let left = |vector: &Vector| ahead.perp(vector);
    Some(OnTrace {
        place: Vector::new(station.along + share, left(&offset)),
        velocity: Vector::new(ahead.dot(velocity), left(velocity)),
        reach: reach(&ahead),
    })
}

/// The distance from a place to a box at another place that points along a unit vector (m); 0 inside.
pub fn distance_to_box(place: Point, middle: Point, ahead: &Vector, half: &Vector) -> f64 {
    let offset = place - middle;
    let (x, y) = (offset.dot(ahead).abs() - half.x, ahead.perp(&offset).abs() - half.y);
    Vector::new(x.max(0.0), y.max(0.0)).norm()
}

/// The extent of an actor from its middle along a unit vector and across it (m); the radius of a disc if both half extents
/// are equal.
pub fn reach_of(actor: &Actor, ahead: &Vector) -> Vector {
    let half = actor.half;
    if half.x == half.y {
        return half;
    }
    let [forward, left] = actor.pose.axes();
    let on = |axis: &Vector| half.x * forward.dot(axis).abs() + half.y * left.dot(axis).abs();
    Vector::new(on(ahead), on(&Vector::new(-ahead.y, ahead.x)))
}
