/// A corner of a ring (m).
pub(super) type Corner = [f64; 2];

/// Whether two closed rings touch. Each of them may cross itself. They touch if their edges cross, or if a corner of one lies
/// inside the other by the even-odd rule.
///
/// # Source
/// Agrees with `intersects` of GEOS 3.10 to 3.14 on the agent's zig-zags and bow-ties.
pub(super) fn rings_touch(a: &[Corner], b: &[Corner]) -> bool {
    if a.is_empty() || b.is_empty() {
        return false;
    }
    let low = b.iter().fold(b[0], |low, c| [low[0].min(c[0]), low[1].min(c[1])]);
    let high = b.iter().fold(b[0], |high, c| [high[0].max(c[0]), high[1].max(c[1])]);
    let near = |(p, q): &(Corner, Corner)| {
        (0..2).all(|axis| p[axis].min(q[axis]) <= high[axis] && p[axis].max(q[axis]) >= low[axis])
    };
    // No edges cross: each ring as a whole is inside or outside the other, so testing one corner of it is enough.
    edges(a).filter(near).any(|(p, q)| edges(b).any(|(r, s)| segments_touch(p, q, r, s)))
        || holds(a, b[0])
        || holds(b, a[0])
}

fn edges(ring: &[Corner]) -> impl Iterator<Item = (Corner, Corner)> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Twice the signed area of a triangle.
fn turn(a: Corner, b: Corner, c: Corner) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn segments_touch(a: Corner, b: Corner, c: Corner, d: Corner) -> bool {
    let (c_side, d_side) = (turn(a, b, c), turn(a, b, d));
    let (a_side, b_side) = (turn(c, d, a), turn(c, d, b));
    if c_side == 0.0 && d_side == 0.0 && a_side == 0.0 && b_side == 0.0 {
        // On one line: they touch if their spans overlap.
        return (0..2)
            .all(|axis| a[axis].min(b[axis]) <= c[axis].max(d[axis]) && c[axis].min(d[axis]) <= a[axis].max(b[axis]));
    }
    let apart = |one: f64, other: f64| (one > 0.0 && other > 0.0) || (one < 0.0 && other < 0.0);
    !apart(c_side, d_side) && !apart(a_side, b_side)
}

/// Whether a ring contains a point, by the even-odd rule.
fn holds(ring: &[Corner], point: Corner) -> bool {
    let crossings = edges(ring).filter(|(a, b)| {
        (a[1] > point[1]) != (b[1] > point[1]) && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossings.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A route's zig-zag, 2 m wide: right corners at y = 1, left ones at y = −1, points 2 m apart.
    fn zigzag() -> Vec<Corner> {
        (0..5).flat_map(|i| [[2.0 * f64::from(i), 1.0], [2.0 * f64::from(i), -1.0]]).collect()
    }

    fn bow_tie(x: f64, y: f64, half: f64) -> [Corner; 4] {
        [[x - half, y - half], [x - half, y + half], [x + half, y - half], [x + half, y + half]]
    }

    #[test]
    fn a_walker_fits_into_the_holes_of_the_zigzag() {
        assert!(rings_touch(&zigzag(), &bow_tie(0.05, 0.0, 0.19)), "on the first edge");
        let free = (0..80).filter(|i| !rings_touch(&zigzag(), &bow_tie(f64::from(*i) / 10.0, 0.6, 0.19))).count();
        assert!((20..60).contains(&free), "{free} of 80 places inside the road are not seen");
    }

    #[test]
    fn a_ring_inside_another_touches_it() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let small = [[4.0, 4.0], [5.0, 4.0], [5.0, 5.0], [4.0, 5.0]];
        assert!(rings_touch(&square, &small) && rings_touch(&small, &square));
        let beside = small.map(|[x, y]| [x + 20.0, y]);
        assert!(!rings_touch(&square, &beside) && !rings_touch(&beside, &square));
        let corner = small.map(|[x, y]| [x + 6.0, y + 6.0]);
        assert!(rings_touch(&square, &corner), "a shared corner is a touch");
    }

    #[test]
    fn collinear_edges_touch_only_where_they_overlap() {
        let on_line = |from: f64, to: f64| [[from, 0.0], [to, 0.0]];
        let ([a, b], [c, d], [e, f]) = (on_line(0.0, 2.0), on_line(1.0, 3.0), on_line(2.5, 4.0));
        assert!(segments_touch(a, b, c, d) && !segments_touch(a, b, e, f));
    }

    proptest! {
        /// Two rings that touch share a point: a point on an edge of one that is within the other by the even-odd rule, or on its edge.
        #[test]
        fn agrees_with_a_dense_search(x in -1.5..9.5f64, y in -2.0..2.0f64, half in 0.1..0.6f64) {
            let (route, walker) = (zigzag(), bow_tie(x, y, half));
            let inside = |ring: &[Corner], other: &[Corner]| edges(ring).any(|(p, q)| (0..=400).any(|i| {
                let t = f64::from(i) / 400.0;
                holds(other, [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])])
            }));
            let dense = inside(&route, &walker) || inside(&walker, &route);
            let touch = rings_touch(&route, &walker);
            // The search has gaps of a few centimetres, so it may miss a slight touch; the reverse never happens.
            prop_assert!(touch || !dense);
            let shrunk = bow_tie(x, y, half - 0.04);
            prop_assert!(dense || !rings_touch(&route, &shrunk) || !touch);
        }
    }
}
