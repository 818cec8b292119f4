//! The last observations side by side.

/// The last observations of an episode, the oldest first; zeros fill the places before its start.
///
/// A policy trained with `PpoConfig::frame_stack` expects this instead of a single observation.
///
/// # Source
/// `VecFrameStack` of stable-baselines3.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameStack {
    frame_dim: usize,
    stacked: Vec<f64>,
}

impl FrameStack {
    /// Makes room for this number of observations of `frame_dim` components each.
    pub fn new(frame_dim: usize, frames: usize) -> Self {
        Self { frame_dim, stacked: vec![0.0; frame_dim * frames] }
    }

    /// Starts an episode with its first observation.
    pub fn begin(&mut self, frame: &[f64]) {
        self.stacked.fill(0.0);
        self.push(frame);
    }

    /// Adds an observation and drops the oldest.
    pub fn push(&mut self, frame: &[f64]) {
        self.stacked.copy_within(self.frame_dim.., 0);
        let newest = self.stacked.len() - self.frame_dim;
        self.stacked[newest..].copy_from_slice(frame);
    }

    /// Returns the observations, the oldest first.
    pub fn as_slice(&self) -> &[f64] {
        &self.stacked
    }

    /// Replaces the content, by one of equal length.
    pub(super) fn restore(&mut self, stacked: &[f64]) {
        self.stacked.copy_from_slice(stacked);
    }
}
