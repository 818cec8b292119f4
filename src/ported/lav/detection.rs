use super::frame::{EgoPoint, PIXELS_PER_METRE};
use super::version::{Traits, Version};

/// Side of the map (px).
const SIDE: f64 = 320.0;
/// The ego on the map (px).
const EGO: (f64, f64) = (160.0, 280.0);
/// A peak is the maximum value within this distance (px).
const PEAK_REACH: f64 = 3.0;
/// A peak within this distance of the ego is the ego (px).
const EGO_RADIUS: f64 = 2.0;
/// The range of the fast variant (px).
const FAST_RADIUS: f64 = 120.0;
/// Minimum half length of a vehicle (px).
const MIN_HALF_LENGTH: f64 = 0.4;
/// Minimum half width of anything, except in the fast variant (px).
const MIN_HALF_WIDTH: f64 = 0.8;

/// The map a peak is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BlobKind {
    /// Pedestrians: LAV does not react to them.
    Pedestrian,
    /// Vehicles, and pedestrians that are mistaken for one.
    Vehicle,
}

/// The trace of a body on the detection map: a bell around a pixel, `score · exp(−d²)` with d in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blob {
    /// The map it is on.
    pub kind: BlobKind,
    /// Column of its middle (px).
    pub column: f64,
    /// Row of its middle (px), counted from the far end.
    pub row: f64,
    /// Height of the bell, 0 to 1.
    pub score: f64,
    /// Half of its length (px).
    pub half_length: f64,
    /// Half of its width (px).
    pub half_width: f64,
    /// Yaw relative to the ego (rad), clockwise.
    pub yaw: f64,
}

impl Blob {
    /// The blob of a body at a place with half extents in metres; it falls into one pixel of 0.25 m.
    pub fn of_body(kind: BlobKind, place: EgoPoint, yaw: f64, half_length: f64, half_width: f64, score: f64) -> Self {
        Self {
            kind,
            column: (EGO.0 + PIXELS_PER_METRE * place.right).round(),
            row: (EGO.1 + PIXELS_PER_METRE * place.back).round(),
            score,
            half_length: PIXELS_PER_METRE * half_length,
            half_width: PIXELS_PER_METRE * half_width,
            yaw,
        }
    }

    /// Its maximum value in the window around a peak.
    fn reaches(&self, peak: &Self) -> f64 {
        let outside = |mine: f64, its: f64| ((mine - its).abs() - PEAK_REACH).max(0.0);
        let (columns, rows) = (outside(self.column, peak.column), outside(self.row, peak.row));
        self.score * libm::exp(-(columns * columns + rows * rows))
    }

    fn pixels_from_ego(&self) -> f64 {
        let (columns, rows) = (self.column - EGO.0, self.row - EGO.1);
        (columns * columns + rows * rows).sqrt()
    }
}

/// A detection of LAV's detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// The peak.
    pub blob: Blob,
    /// Its place, to a quarter of a metre.
    pub place: EgoPoint,
}

/// The steps after LAV's detection network: peaks, gates, order.
#[derive(Debug, Clone)]
pub struct Detector {
    traits: &'static Traits,
    found: Vec<Detection>,
}

impl Detector {
    /// The detector of a version.
    pub fn new(version: Version) -> Self {
        Self { traits: version.traits(), found: Vec::with_capacity(64) }
    }

    /// The detections among these blobs: pedestrians first, then by score, the best one first.
    ///
    /// # Source
    /// `extract_peak` and `det_inference` of LAV. Where bells overlap, the map has the greater value.
    pub fn detect(&mut self, blobs: &[Blob]) -> &[Detection] {
        self.found.clear();
        let on_map = |value: f64| (0.0..SIDE).contains(&value);
        for blob in blobs {
            let peak = on_map(blob.column) && on_map(blob.row) && blob.score > self.traits.peak_score;
            let beaten = |other: &Blob| other.kind == blob.kind && other.reaches(blob) > blob.score;
            if peak && !blobs.iter().any(beaten) {
                let place =
                    EgoPoint::new((blob.column - EGO.0) / PIXELS_PER_METRE, (blob.row - EGO.1) / PIXELS_PER_METRE);
                self.found.push(Detection { blob: *blob, place });
            }
        }
        let order = |found: &Detection| (found.blob.kind, -found.blob.score);
        self.found.sort_unstable_by(|a, b| {
            let ((kind, score), (its_kind, its_score)) = (order(a), order(b));
            kind.cmp(&its_kind).then(score.total_cmp(&its_score))
        });
        let (traits, mut rank, mut kind) = (self.traits, 0, None);
        self.found.retain(|found| {
            rank = if kind == Some(found.blob.kind) { rank + 1 } else { 0 };
            kind = Some(found.blob.kind);
            rank < traits.peaks && passes(traits, &found.blob)
        });
        &self.found
    }
}

/// The gates of size and distance.
fn passes(traits: &Traits, blob: &Blob) -> bool {
    let away = blob.pixels_from_ego();
    let vehicle = blob.kind == BlobKind::Vehicle;
    let too_small = if traits.fast_gates {
        vehicle && blob.half_length.max(blob.half_width) < MIN_HALF_LENGTH
    } else {
        (vehicle && blob.half_length < MIN_HALF_LENGTH) || blob.half_width < MIN_HALF_WIDTH
    };
    !too_small && away > EGO_RADIUS && !(traits.fast_gates && away >= FAST_RADIUS)
}
