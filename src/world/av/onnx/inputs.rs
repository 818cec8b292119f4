use crate::av::view::View;
use road::geometry::{Pose, Vector, wrap_angle};

/// The content of an input of the network, with the number of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Speed, limit and light.
    Ego,
    /// The nearest road users, at most this number.
    Actors(usize),
    /// This number of points of the route.
    Route(usize),
}

impl Input {
    /// Its shape, and how many of its three lengths count.
    pub fn shape(self) -> ([usize; 3], usize) {
        match self {
            Self::Ego => ([1, 4, 0], 2),
            Self::Actors(rows) => ([1, rows, 8], 3),
            Self::Route(rows) => ([1, rows, 3], 3),
        }
    }

    /// Its numbers for a view, row by row.
    pub fn numbers(self, view: &View) -> Vec<f32> {
        let place = |pose: &Pose| {
            let local = view.ego.to_local(pose.position());
            [local.x, local.y, wrap_angle(pose.yaw - view.ego.yaw)]
        };
        let [forward, left] = view.ego.axes();
        let turned = |velocity: &Vector| [velocity.dot(&forward), velocity.dot(&left)];
        let numbers: Vec<f64> = match self {
            Self::Ego => {
                let (light, distance) = view.light_numbers();
                vec![view.speed, view.speed_limit, light, distance]
            }
            Self::Actors(rows) => (0..rows)
                .flat_map(|row| {
                    view.actors.get(row).map_or([0.0; 8], |seen| {
                        let ([x, y, yaw], [vx, vy]) = (place(&seen.pose), turned(&seen.velocity));
                        [1.0, x, y, yaw, vx, vy, 2.0 * seen.half.x, 2.0 * seen.half.y]
                    })
                })
                .collect(),
            Self::Route(rows) => {
                (0..rows).flat_map(|row| view.route.get(row).or(view.route.last()).map_or([0.0; 3], place)).collect()
            }
        };
        numbers.into_iter().map(|number| number as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::LightColour;

    #[test]
    fn numbers_are_in_the_frame_of_the_ego() {
        use crate::av::view::{Kind, LightAhead, Seen};
        let half_turn = std::f64::consts::PI;
        let view = View {
            ego: Pose::new(10.0, 5.0, half_turn / 2.0),
            speed: 8.0,
            speed_limit: 10.0,
            light: Some(LightAhead { colour: LightColour::Yellow, distance: 30.0 }),
            sign: None,
            actors: vec![Seen {
                id: 0,
                kind: Kind::Pedestrian,
                pose: Pose::new(8.0, 15.0, half_turn),
                velocity: Vector::new(1.5, 0.0),
                half: Vector::new(0.25, 0.25),
            }],
            route: vec![Pose::new(10.0, 6.0, half_turn / 2.0)],
            lanes: Vec::new(),
        };
        let near = |input: Input, wanted: &[f32]| {
            let numbers = input.numbers(&view);
            let same = numbers.len() == wanted.len() && numbers.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(same, "{numbers:?} instead of {wanted:?}");
        };
        near(Input::Ego, &[8.0, 10.0, 2.0, 30.0]);
        let quarter = half_turn as f32 / 2.0;
        let walker = [1.0, 10.0, 2.0, quarter, 0.0, -1.5, 0.5, 0.5];
        near(Input::Actors(2), &[walker, [0.0; 8]].concat());
        near(Input::Route(2), &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }
}
