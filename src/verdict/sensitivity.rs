use base::seed::Seed;
use rand::RngExt;

use super::encounter::Encounter;
use super::trial::FreeRun;
use road::geometry::Vector;
use world::av::reference_drivers::{BrakeProfile, DelayedBrake, Gate};

/// How much an answer rests on what nobody knows exactly: in how many variations a careful human avoids the touch.
///
/// A thousand variations draw from these ranges, equally, from a named stream: fifty times an offset of the pedestrian in both directions and how much farther from it the car must stay,
/// and for each twenty times the reaction time and the deceleration. Those in which the recorded car does not touch say nothing and are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sensitivity {
    /// The variations, of 1,000, with a touch of the recorded car.
    pub variations: u32,
    /// Those in which the human avoids it.
    pub avoided: u32,
}

impl Sensitivity {
    /// The numbers of places of the pedestrian that are drawn, and of drivers for each.
    const PLACES: u32 = 50;
    const DRIVERS: u32 = 20;
    /// Reaction time (s), from that of an attentive human to that of one who is surprised.
    pub const REACTION: (f64, f64) = (0.75, 1.5);
    /// Deceleration (m/s²), from a wet road to that of an emergency brake; never above the car's.
    pub const BRAKING: (f64, f64) = (5.0, 8.3);
    /// Distance that must be left (m).
    pub const MARGIN: (f64, f64) = (0.0, 0.2);
    /// Offset of the pedestrian (m).
    pub const OFFSET: f64 = 0.1;
    /// Time before the touch (s) that is varied: the gate opens later at any speed up to 40 m/s.
    const LASTS: f64 = 8.0;

    /// Varies an encounter.
    pub(super) fn new(encounter: &Encounter<'_>) -> Self {
        let encounter = &encounter.last(Self::LASTS);
        let mut stream = Seed::root(0).child("judge").child("variations").stream();
        let (mut variations, mut avoided) = (0, 0);
        let mut draw = |(low, high): (f64, f64)| stream.random_range(low..=high);
        for _ in 0..Self::PLACES {
            let (offset, margin) = ((-Self::OFFSET, Self::OFFSET), draw(Self::MARGIN));
            let mut varied = encounter.moved(Vector::new(draw(offset), draw(offset)));
            let free = FreeRun::new(&mut varied);
            if free.trial.is_avoided() {
                continue;
            }
            varied.radius += margin;
            // All have one gate, and so notice the pedestrian at one time.
            let noticed = free.noticed(&varied, &DelayedBrake::careful_human());
            for _ in 0..Self::DRIVERS {
                let profile = BrakeProfile { wait: draw(Self::REACTION), ramp: 0.6, full: draw(Self::BRAKING) };
                let driver = DelayedBrake::new(Some(Gate::CAREFUL), profile);
                variations += 1;
                avoided += u32::from(free.braked(&mut varied, driver, noticed).is_avoided());
            }
        }
        Self { variations, avoided }
    }

    /// The share of variations in which the human avoids it (%).
    pub fn percent(&self) -> f64 {
        100.0 * f64::from(self.avoided) / f64::from(self.variations.max(1))
    }
}
