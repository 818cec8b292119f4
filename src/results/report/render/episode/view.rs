use std::ops::RangeInclusive;

use episode::{Frame, Pair, Scenario, Trace};
use road::geometry::{Point, Vector};
use verdict::Verdict;

/// Time shown before the start of the danger. In an episode without a collision: time around its least gap (s).
const BEFORE: f64 = 1.5;
/// The shortest and the longest part of an episode that is shown (s).
const SHORTEST: f64 = 3.0;
const LONGEST: f64 = 8.0;
/// Margin of ground around the actors, and the least ground that is shown (m).
const MARGIN: f64 = 5.0;
const LEAST: f64 = 24.0;

/// The part of an episode that a picture shows.
pub struct EpisodeView<'a> {
    pair: Pair<'a>,
    frames: Vec<Frame>,
    ticks: RangeInclusive<usize>,
    /// South-west corner and size of the visible ground (m).
    low: Point,
    size: Vector,
}

impl<'a> EpisodeView<'a> {
    /// Chooses the shown part: from a little before the danger to the touch, or the time around the least gap.
    pub fn new(scenario: &'a Scenario, trace: &'a Trace, verdict: Option<&Verdict>) -> Self {
        let (pair, dt) = (trace.main_pair(scenario), scenario.episode.tick);
        let frames: Vec<Frame> = pair.frames().collect();
        let (last, count) = (frames.len() - 1, |time: f64| (time / dt).round() as usize);
        let ticks = match verdict {
            Some(verdict) => {
                let shown = (verdict.warning + BEFORE).clamp(SHORTEST, LONGEST);
                last.saturating_sub(count(shown))..=last
            }
            None => {
                let gap = |tick: &usize| pair.gap(&frames[*tick]);
                let nearest = (0..=last).min_by(|one, other| gap(one).total_cmp(&gap(other))).unwrap_or(0);
                nearest.saturating_sub(count(SHORTEST))..=(nearest + count(SHORTEST)).min(last)
            }
        };
        let shown = &frames[ticks.clone()];
        let places = shown.iter().flat_map(|frame| {
            let corners = pair.outline(frame).corners();
            corners.into_iter().chain([frame.pedestrian.pose.position()])
        });
        let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
        for place in places {
            (low.x, low.y) = (low.x.min(place.x), low.y.min(place.y));
            (high.x, high.y) = (high.x.max(place.x), high.y.max(place.y));
        }
        let around = Vector::new(MARGIN, MARGIN);
        let wanted = high - low + around * 2.0;
        // Neither too flat nor too tall for a page.
        let size = Vector::new(wanted.x.max(LEAST).max(wanted.y * 0.85), wanted.y.max(LEAST * 0.6).max(wanted.x * 0.5));
        let middle = low + (high - low) / 2.0;
        Self { pair, frames, ticks, low: middle - size / 2.0, size }
    }

    /// The frames that are shown, each with its tick.
    pub fn shown(&self) -> impl Iterator<Item = (usize, &Frame)> {
        self.ticks.clone().zip(&self.frames[self.ticks.clone()])
    }

    /// First and last tick.
    pub fn span(&self) -> (usize, usize) {
        (*self.ticks.start(), *self.ticks.end())
    }

    /// The time of a tick (s).
    pub fn time(&self, tick: usize) -> f64 {
        tick as f64 * self.pair.dt()
    }

    /// The car and the pedestrian that are shown.
    pub fn pair(&self) -> &Pair<'a> {
        &self.pair
    }

    /// Height of the scene at a width (px).
    pub fn height(&self, width: f64) -> f64 {
        width * self.size.y / self.size.x
    }

    /// South-west corner and size of the visible ground (m).
    pub fn ground(&self) -> (Point, Vector) {
        (self.low, self.size)
    }

    pub fn frame(&self, tick: usize) -> &Frame {
        &self.frames[tick]
    }
}
