/// The number of errors that are averaged.
const WINDOW: usize = 40;

/// A controller whose integral is the mean over a window that is initially full of zeros.
///
/// # Source
/// InterFuser `team_code/interfuser_controller.py`, `PIDController`.
#[derive(Debug, Clone)]
pub(super) struct Pid {
    gains: [f64; 3],
    window: [f64; WINDOW],
    /// Index of the newest error.
    newest: usize,
}

impl Pid {
    /// Makes one with proportional, integral and derivative gains.
    pub fn new(gains: [f64; 3]) -> Self {
        Self { gains, window: [0.0; WINDOW], newest: WINDOW - 1 }
    }

    /// The output for an error; call it once per tick.
    pub fn step(&mut self, error: f64) -> f64 {
        let before = self.window[self.newest];
        self.newest = (self.newest + 1) % WINDOW;
        self.window[self.newest] = error;
        let [proportional, integral, derivative] = self.gains;
        let mean = self.window.iter().sum::<f64>() / WINDOW as f64;
        proportional * error + integral * mean + derivative * (error - before)
    }
}
