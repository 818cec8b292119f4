use super::{DrivingMode, DrivingPolicy, Fault, Perception};
use crate::sim::Control;
use base::seed::Stream;

/// A driver whose commands take effect later: pedals and wheel follow a command after a dead time, in whole ticks.
///
/// Until its first command arrives, the car coasts with straight wheels.
pub struct ActuationDelay {
    driver: Box<dyn DrivingPolicy>,
    /// The dead time (s).
    delay: f64,
    /// The commands that have not taken effect, as a ring.
    waiting: Vec<Control>,
    /// The place of the oldest one.
    oldest: usize,
}

impl ActuationDelay {
    /// Delays the commands of a driver by a time (s), rounded to whole ticks.
    pub fn new(driver: Box<dyn DrivingPolicy>, delay: f64) -> Self {
        Self { driver, delay, waiting: Vec::new(), oldest: 0 }
    }
}

impl DrivingPolicy for ActuationDelay {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        let ticks = (self.delay / perception.dt).round() as usize;
        self.waiting.clear();
        self.waiting.resize(ticks, Control::default());
        self.oldest = 0;
        self.driver.reset(perception, stream);
    }

    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn prepare(&mut self, perception: &Perception<'_>) {
        self.driver.prepare(perception);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let command = self.driver.drive(perception);
        let Some(oldest) = self.waiting.get_mut(self.oldest) else { return command };
        let due = std::mem::replace(oldest, command);
        self.oldest = (self.oldest + 1) % self.waiting.len();
        due
    }

    fn mode(&self) -> DrivingMode {
        self.driver.mode()
    }

    fn fault(&self) -> Option<Fault> {
        self.driver.fault()
    }

    fn world_driver(&self) -> Option<&str> {
        self.driver.world_driver()
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        let (driver, waiting) = (self.driver.snapshot()?, self.waiting.clone());
        Some(Box::new(Self { driver, waiting, ..*self }))
    }

    fn reseed(&mut self, stream: Stream) {
        self.driver.reseed(stream);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(Self::new(self.driver.clone_for_batch()?, self.delay)))
    }

    fn batch_size(&self) -> usize {
        self.driver.batch_size()
    }
}
