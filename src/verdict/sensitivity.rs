use base::seed::{Seed, Stream};
use rand::RngExt;

use super::encounter::Encounter;
use super::trial::{FreeRun, Trial};
use super::{Label, Reference};
use road::geometry::Vector;
use world::av::reference_drivers::{BrakeProfile, DelayedBrake, Gate};

/// How much an answer rests on what nobody knows exactly: in how many variations a careful human avoids the touch.
///
/// Each variation draws from these ranges, equally, from a named stream: the reaction time, the deceleration, how much farther from the pedestrian the car must stay, and an offset of
/// the pedestrian in both directions. Variations in which the recorded car does not touch say nothing and are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sensitivity {
    /// The variations with a touch of the recorded car.
    pub variations: u32,
    /// Those in which the human avoids it.
    pub avoided: u32,
    /// Whether the careful drivers together say the same at all offsets within the noise of the recording.
    pub is_steady: bool,
}

impl Sensitivity {
    /// The number of variations that are drawn.
    pub const DRAWN: u32 = 1000;
    /// Reaction time (s), from that of an attentive human to that of one who is surprised.
    pub const REACTION: (f64, f64) = (0.75, 1.5);
    /// Deceleration (m/s²), from a wet road to that of an emergency brake; never above the car's.
    pub const BRAKING: (f64, f64) = (5.0, 8.3);
    /// Distance that must be left (m).
    pub const MARGIN: (f64, f64) = (0.0, 0.2);
    /// Offset of the pedestrian (m), at least.
    pub const OFFSET: f64 = 0.1;
    /// Time before the touch (s) that is varied: the gate opens later at any speed up to 40 m/s.
    const LASTS: f64 = 8.0;
    /// The offsets within the noise that are tried, and the share of them that may differ.
    const OFFSETS: u32 = 40;
    const MAX_DIFFERENT: u32 = 2;

    /// Varies an encounter; `noise` is the standard deviation of the recorded positions (m) after they were smoothed.
    pub(super) fn new(encounter: &Encounter<'_>, noise: f64, is_preventable: bool) -> Self {
        let encounter = &encounter.last(Self::LASTS);
        let mut stream = Seed::root(0).child("judge").child("variations").stream();
        let (mut variations, mut avoided) = (0, 0);
        for _ in 0..Self::DRAWN {
            let mut draw = |(low, high): (f64, f64)| stream.random_range(low..=high);
            let (reaction, full, margin) = (draw(Self::REACTION), draw(Self::BRAKING), draw(Self::MARGIN));
            let most = Self::OFFSET.max(2.0 * noise);
            let moved = Vector::new(draw((-most, most)), draw((-most, most)));
            let mut varied = encounter.moved(moved);
            let free = FreeRun::new(&mut varied);
            if free.trial.is_avoided() {
                continue;
            }
            varied.radius += margin;
            let driver = DelayedBrake::new(Some(Gate::CAREFUL), BrakeProfile { wait: reaction, ramp: 0.6, full });
            variations += 1;
            let noticed = free.noticed(&varied, &driver);
            avoided += u32::from(free.braked(&mut varied, driver, noticed).is_avoided());
        }
        let is_steady =
            noise <= 0.0 || Self::differ(encounter, noise, is_preventable, &mut stream) <= Self::MAX_DIFFERENT;
        Self { variations, avoided, is_steady }
    }

    /// At how many offsets within the noise the careful drivers say something else.
    fn differ(encounter: &Encounter<'_>, noise: f64, is_preventable: bool, stream: &mut Stream) -> u32 {
        let most = 2.0 * noise;
        let differs = |_| {
            let moved = Vector::new(stream.random_range(-most..=most), stream.random_range(-most..=most));
            let mut varied = encounter.moved(moved);
            let avoids = |reference: Reference| Trial::new(&mut varied, &mut *reference.driver()).is_avoided();
            Label::careful().into_iter().all(avoids) != is_preventable
        };
        (0..Self::OFFSETS).map(differs).map(u32::from).sum()
    }

    /// The share of variations in which the human avoids it (%).
    pub fn percent(&self) -> f64 {
        100.0 * f64::from(self.avoided) / f64::from(self.variations.max(1))
    }
}
