use super::RoadMap;
use road::geometry::{Point, Vector};
use world::av::Actor;

/// Half extents of the only car that it knows (m). It is told this size of the ego, too: another one destroys the policy.
pub(super) const CAR: Vector = Vector::new(1.575, 0.7);

/// What the network gets at a step.
#[derive(Debug, Clone, Default)]
pub struct Observation {
    /// Goal ahead and to the left, signed speed, width, length, whether it touches another or an edge, and 0.
    pub ego: [f32; 7],
    /// Up to 63 rows: place ahead and to the left, width, length, cosine and sine of the relative heading, signed speed.
    pub others: Vec<[f32; 7]>,
    /// Up to 200 rows: middle ahead and to the left, half length, 0.001, cosine and sine of the relative direction, kind.
    pub road: Vec<[f32; 7]>,
}

impl Observation {
    /// Observes others within 50 m, in their order, and the first pieces of the road, at most this number.
    pub fn look(
        &mut self,
        ego: &Actor,
        goal: Point,
        others: impl Iterator<Item = Actor> + Clone,
        map: (&RoadMap, usize),
    ) {
        let (pose, outline) = (&ego.pose, ego.outline());
        let [ahead, left] = pose.axes();
        let row = |place: Point, direction: Vector, size: [f64; 2], last: f64| {
            let place = pose.to_local(place) * 0.02;
            [place.x, place.y, size[0], size[1], ahead.dot(&direction), left.dot(&direction), last].map(|x| x as f32)
        };
        let speed = |actor: &Actor| actor.speed().copysign(actor.velocity.dot(&actor.pose.forward())) / 100.0;
        let touches = map.0.touches_edge(&outline) || others.clone().any(|other| other.outline().overlaps(&outline));
        let (goal, flag) = (pose.to_local(goal) * 0.005, f64::from(u8::from(touches)));
        self.ego = [goal.x, goal.y, speed(ego), CAR.y / 7.5, CAR.x / 15.0, flag, 0.0].map(|x| x as f32);
        let near = others.filter(|other| (other.pose.position() - pose.position()).norm() <= 50.0).take(63);
        self.others.clear();
        self.others.extend(near.map(|other| {
            let size = [other.half.y / 7.5, other.half.x / 15.0];
            row(other.pose.position(), other.pose.forward(), size, speed(&other))
        }));
        self.road.clear();
        self.road.extend(map.0.around(pose.position(), 10).take(map.1).map(|(kind, [from, to])| {
            let (way, length) = (to - from, (to - from).norm());
            row(from + way / 2.0, way / length.max(1e-9), [length / 200.0, 0.001], f64::from(*kind))
        }));
    }
}
