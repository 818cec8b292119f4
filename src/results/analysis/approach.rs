use world::env::{Frame, Pair};

/// Position of the pedestrian relative to the car at a time, and speed of the car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Distance of the pedestrian ahead of the car's centre (m).
    pub ahead: f64,
    /// Distance of the pedestrian to the left of the car's axis (m).
    pub left: f64,
    /// Speed of the car (m/s).
    pub speed: f64,
}

impl Station {
    fn new(frame: &Frame) -> Self {
        let place = frame.ego.pose.to_local(frame.pedestrian.pose.position());
        Self { ahead: place.x, left: place.y, speed: frame.ego.speed }
    }

    fn mix(self, other: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Self {
            ahead: mix(self.ahead, other.ahead),
            left: mix(self.left, other.left),
            speed: mix(self.speed, other.speed),
        }
    }
}

/// The last [`Approach::WINDOW`] before a touch: the track of the pedestrian in the frame of the car, which moves and turns with the car,
/// and the speed of the car.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// One station every [`Approach::STEP`], the last one at the touch. Stations before the episode have the values of its start.
    pub stations: [Station; Self::STATIONS],
}

impl Approach {
    /// The length of the time before the touch that it covers (s).
    pub const WINDOW: f64 = 3.0;
    /// Time between two stations (s).
    pub const STEP: f64 = Self::WINDOW / (Self::STATIONS - 1) as f64;
    const STATIONS: usize = 7;

    /// The end of an episode; `None` if the two did not touch.
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        let contact = pair.contact?;
        let touch = (pair.len().checked_sub(2)?) as f64 + contact.fraction;
        let stations = std::array::from_fn(|i| {
            let back = (Self::STATIONS - 1 - i) as f64 * Self::STEP / pair.dt();
            let tick = (touch - back).max(0.0);
            let first = (tick.floor() as usize).min(pair.len() - 2);
            Station::new(&pair.frame(first)).mix(Station::new(&pair.frame(first + 1)), tick - first as f64)
        });
        Some(Self { stations })
    }

    /// The distance of two approaches (m): the root of a mean over the stations. Its terms are the squared distance between the positions
    /// plus the squared difference of the speeds; 1 m/s counts as 1 m.
    pub fn distance(&self, other: &Self) -> f64 {
        let apart = |(a, b): (&f64, &f64)| (a - b) * (a - b);
        self.features().iter().zip(&other.features()).map(apart).sum::<f64>().sqrt()
    }

    /// A point. The Euclidean distance of two such points is the [`Approach::distance`] of their approaches.
    pub(super) fn features(&self) -> Vec<f64> {
        let scale = 1.0 / (Self::STATIONS as f64).sqrt();
        let numbers = self.stations.iter().flat_map(|station| [station.ahead, station.left, station.speed]);
        numbers.map(|number| number * scale).collect()
    }
}
