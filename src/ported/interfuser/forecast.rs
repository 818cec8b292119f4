use std::f64::consts::PI;

use super::EgoVector;
use super::detection::ObjectClass;
use super::image::{Image, Rectangle};
use super::object_map::{Cell, centre};

/// Times of the forecast images (s).
pub const HORIZONS: [f64; 6] = [0.0, 0.5, 0.75, 1.0, 1.5, 2.0];
/// Bikes are forecast to move at least at this speed (m/s).
const MIN_BIKE_SPEED: f64 = 4.0;
/// Minimum half width of boxes (m).
const MIN_HALF_WIDTH: f64 = 0.4;
/// Boxes with a smaller half length (m) are drawn twice as large.
const SMALL: f64 = 1.5;

/// The forecast places of all road users, one image for each of [`HORIZONS`]; all of them go straight on.
#[derive(Debug, Clone, Default)]
pub struct Forecast {
    images: [Image; HORIZONS.len()],
    /// Whether the planner's part of an image is black.
    clear: [bool; HORIZONS.len()],
}

impl Forecast {
    /// A forecast without road users.
    pub fn new() -> Self {
        Self { clear: [true; HORIZONS.len()], ..Self::default() }
    }

    /// Draws the detections.
    ///
    /// # Source
    /// InterFuser `team_code/render.py`.
    pub fn draw(&mut self, detections: &[Cell]) {
        for ((image, clear), time) in self.images.iter_mut().zip(&mut self.clear).zip(HORIZONS) {
            image.clear();
            for detection in detections {
                image.fill(&outline(detection, time).corners());
            }
            *clear = image.crop_pixels() == 0;
        }
    }

    /// The image of a horizon; `None` if it is empty.
    pub(super) fn image(&self, horizon: usize) -> Option<&Image> {
        (!self.clear[horizon]).then(|| &self.images[horizon])
    }
}

/// The box of a detection after some time (s).
fn outline(detection: &Cell, time: f64) -> Rectangle {
    let speed = match ObjectClass::of(detection) {
        ObjectClass::Bike => detection.speed.max(MIN_BIKE_SPEED),
        ObjectClass::Car | ObjectClass::Pedestrian => detection.speed,
    };
    let (right, forward) = centre(detection.row, detection.col);
    let (sin, cos) = libm::sincos(detection.theta * PI);
    let (right, forward) = (right + detection.dx + time * speed * cos, forward + detection.dy - time * speed * sin);
    let half = EgoVector::new(detection.half_length, detection.half_width.max(MIN_HALF_WIDTH));
    Rectangle {
        centre: EgoVector::new(right, -forward),
        direction: EgoVector::new(cos, sin),
        half: if detection.half_length < SMALL { half * 2.0 } else { half },
    }
}
