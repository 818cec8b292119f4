use base::keys;
use episode::PolicyMaker;
use episode::walker::Controller;

/// How a car learns to drive.
#[derive(Clone)]
pub struct DriveRule {
    /// The driver that it imitates first; other cars have it, too.
    pub teacher: PolicyMaker,
    /// The decisions in which it is imitated; 0 for none.
    pub demonstrations: u32,
    /// The ticks for which an action is kept while it learns by itself.
    pub hold: u32,
    /// Who walks, in turns.
    pub walkers: Vec<Controller>,
    /// The number of other cars, placed as the spawn rule places the ego.
    pub cars: usize,
    /// What it is paid for.
    pub reward: DriveReward,
}

keys! {
    /// The weights of a driver's reward. The first four count by the second; each of their measures is at most 1.
    #[derive(Copy)]
    pub struct DriveReward {
        /// Reward a second of driving at the limit along the route; less for less, and for more than the limit.
        progress: f64 as within(RATIO, 0.0, 1e6) = "0.1",
        /// Cost a second of full discomfort: jerk, lateral acceleration, hard braking and turns of the wheel.
        comfort: f64 as within(RATIO, 0.0, 1e6) = "0.1",
        /// Cost a second of a metre beside the route or more.
        lane: f64 as within(RATIO, 0.0, 1e6) = "0.05",
        /// Cost a second of standing without a road user or a light ahead.
        standing: f64 as within(RATIO, 0.0, 1e6) = "0.03",
        /// Cost of a collision at low speed, twice as much at 10 m/s; and of leaving the route.
        collision: f64 as within(RATIO, 0.0, 1e6) = "5",
    }
}

/// All but the teacher.
impl std::fmt::Debug for DriveRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { demonstrations, hold, walkers, cars, reward, .. } = self;
        (demonstrations, hold, walkers, cars, reward).fmt(f)
    }
}
