/// The number of errors that a controller remembers; before the first error they are zero.
const MEMORY: usize = 40;

/// Proportional, integral and differential gain, per tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gains {
    pub proportional: f64,
    pub integral: f64,
    pub differential: f64,
}

/// LAV's controller: `P e + I · mean(last 40 errors) + D (e − last e)`; it has no time step.
#[derive(Debug, Clone)]
pub(super) struct Pid {
    gains: Gains,
    errors: [f64; MEMORY],
    next: usize,
}

impl Pid {
    pub fn new(gains: Gains) -> Self {
        Self { gains, errors: [0.0; MEMORY], next: 0 }
    }

    /// Adds an error and returns the output.
    pub fn run(&mut self, error: f64) -> f64 {
        let last = self.errors[(self.next + MEMORY - 1) % MEMORY];
        self.errors[self.next] = error;
        self.next = (self.next + 1) % MEMORY;
        let mean = self.errors.iter().sum::<f64>() / MEMORY as f64;
        self.gains.proportional * error + self.gains.integral * mean + self.gains.differential * (error - last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_is_a_mean_over_forty_errors() {
        let mut pid = Pid::new(Gains { proportional: 0.0, integral: 1.0, differential: 0.0 });
        let outputs: Vec<f64> = (0..80).map(|_| pid.run(2.0)).collect();
        assert!((outputs[0] - 0.05).abs() < 1e-12 && (outputs[39] - 2.0).abs() < 1e-12);
        let last = (0..40).map(|_| pid.run(0.0)).last();
        assert_eq!(last, Some(0.0), "they are forgotten");
    }

    #[test]
    fn the_first_difference_is_to_zero() {
        let mut pid = Pid::new(Gains { proportional: 0.0, integral: 0.0, differential: 1.0 });
        assert_eq!((pid.run(0.5), pid.run(0.5), pid.run(0.0)), (0.5, 0.0, -0.5));
    }
}
