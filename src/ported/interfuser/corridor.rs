use super::EgoVector;
use super::forecast::{Forecast, HORIZONS};
use super::image::{Bounds, Image, Rectangle, in_crop};

/// The number of points of the route for the planner.
pub const WAYPOINTS: usize = 10;
/// Maximum spacing of the path (m).
const PRECISION: f64 = 0.2;
/// The maximum number of points between two waypoints. No plan needs as many; a position with an error of kilometres does.
const MAX_BETWEEN: usize = 10_000;
/// Half extents of the ego in the planner (m), before the margin.
const EGO: EgoVector = EgoVector::new(2.45, 1.0);
/// The last points of a path have no direction.
const UNDIRECTED: usize = 2;

/// The ego's path through a forecast, place by place.
///
/// The tested box is multiplied by a direction that is not normalised. On a path with points every 0.2 m it is
/// about 1.4 m long and 0.6 m wide (halves), smaller than the car.
///
/// # Source
/// InterFuser `team_code/interfuser_controller.py`, `downsample_waypoints` and `get_max_safe_distance`.
#[derive(Debug, Clone)]
pub(super) struct Corridor {
    /// Half extents of the ego with the margin (m).
    half: EgoVector,
    /// Share of the ego's box that may be covered.
    overlap: f64,
    path: Vec<EgoVector>,
    ego: Image,
}

impl Corridor {
    /// Makes one for an ego with this room ahead and aside (m); `overlap` is the share of its box that may be covered.
    pub fn new(margin: [f64; 2], overlap: f64) -> Self {
        Self {
            half: EGO + EgoVector::from(margin),
            overlap,
            // Ten waypoints on a road make about 75 points.
            path: Vec::with_capacity(256),
            ego: Image::default(),
        }
    }

    /// Builds a dense path through the waypoints; returns its number of points.
    pub fn follow(&mut self, waypoints: &[EgoVector; WAYPOINTS]) -> usize {
        self.path.clear();
        let mut last = EgoVector::zeros();
        self.path.push(last);
        for &waypoint in waypoints {
            let distance = length(waypoint - last);
            if distance > PRECISION {
                let between = ((distance / PRECISION) as usize).min(MAX_BETWEEN);
                let step = (waypoint - last) / (between as f64 + 1.0);
                self.path.extend((1..=between).map(|index| last + step * index as f64));
            }
            self.path.push(waypoint);
            last = waypoint;
        }
        self.path.len()
    }

    /// How far (m) the ego can go at each horizon before it would be in another's box. The places are those of all
    /// times, the boxes those of one time.
    pub fn safe_distances(&mut self, forecast: &Forecast) -> [f64; HORIZONS.len()] {
        let places = self.path.len() - UNDIRECTED;
        let free = length(self.path[places - 1]);
        let images: [Option<&Image>; HORIZONS.len()] = std::array::from_fn(|horizon| forecast.image(horizon));
        let mut distances = images.map(|image| if image.is_none() { free } else { 0.0 });
        let mut open = images;
        for place in 0..places {
            if open.iter().all(Option::is_none) {
                break;
            }
            let centre = self.path[place];
            let direction = (self.path[place + 1] + self.path[place + 2]) / 2.0 - centre;
            let corners = Rectangle { centre, direction, half: self.half }.corners();
            let bounds = Bounds::around(&corners);
            let near = open.iter().flatten().any(|image| image.bounds().meets(&bounds));
            // Most places are far from all boxes; then it is enough to know that a part of the ego's box is in the image.
            let pixels = if near || !corners.iter().any(|&corner| in_crop(corner)) {
                self.ego.clear();
                self.ego.fill(&corners);
                self.ego.crop_pixels()
            } else {
                1
            };
            for (slot, distance) in open.iter_mut().zip(&mut distances) {
                let Some(image) = *slot else { continue };
                let common = if near { image.common_crop_pixels(&self.ego) } else { 0 };
                // Outside of the image the share is 0/0, which counts as blocked.
                if f64::from(common) / f64::from(pixels) < self.overlap {
                    *distance = distance.max(length(centre));
                } else {
                    *slot = None;
                }
            }
        }
        distances
    }
}

fn length(vector: EgoVector) -> f64 {
    (vector.x * vector.x + vector.y * vector.y).sqrt()
}
