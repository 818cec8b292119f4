use crate::env::PolicyMaker;
use crate::falsifier::Controller;

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

/// The weights of a driver's reward. The first four count by the second; each of their measures is at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveReward {
    /// Speed along the route as a share of the limit; what is above the limit counts against it five times.
    pub progress: f64,
    /// Against it: jerk, lateral acceleration, hard braking and turns of the wheel.
    pub comfort: f64,
    /// Against it: the distance from the route.
    pub lane: f64,
    /// Against it: standing without a road user or a light ahead.
    pub standing: f64,
    /// Against it, once: a collision, half as much again at 5 m/s and twice as much at 10 m/s; and leaving the route, which ends the episode.
    pub collision: f64,
}

/// All but the teacher.
impl std::fmt::Debug for DriveRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { demonstrations, hold, walkers, cars, reward, .. } = self;
        (demonstrations, hold, walkers, cars, reward).fmt(f)
    }
}
