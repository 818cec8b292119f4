use crate::av::Actor;
use road::geometry::{Obstacles, OrientedBox, Point, Vector};

/// The targets of rays on an actor, as shares of its half width as the eye sees it.
const RAYS: [f64; 5] = [-0.8, -0.4, 0.0, 0.4, 0.8];

/// The share of an actor that an eye sees: the share of five rays to points across its outline that are not blocked.
///
/// Seen from above: every obstacle in between hides, however low. `half_width` is half the actor's width as the eye sees it (m).
pub fn visible_share<'a>(
    eye: Point,
    actor: &Actor,
    half_width: f64,
    obstacles: &Obstacles,
    others: impl Iterator<Item = &'a Actor> + Clone,
) -> f64 {
    let place = actor.pose.position();
    let across = across(eye, place) * half_width;
    let free = RAYS.iter().filter(|share| {
        let end = place + across * **share;
        let hides = |other: &Actor| other.outline().is_crossed_by(eye, end);
        !obstacles.blocks_sight(eye, end) && !others.clone().any(hides)
    });
    free.count() as f64 / RAYS.len() as f64
}

/// Half the width of a box as an eye sees it from afar (m).
pub fn half_width_of(outline: &OrientedBox, eye: Point) -> f64 {
    let across = across(eye, outline.pose.position());
    let [forward, left] = outline.pose.axes();
    outline.half.x * across.dot(&forward).abs() + outline.half.y * across.dot(&left).abs()
}

/// The unit vector across the line of sight.
fn across(eye: Point, place: Point) -> Vector {
    let line = (place - eye).try_normalize(1e-9).unwrap_or_else(Vector::x);
    Vector::new(-line.y, line.x)
}
