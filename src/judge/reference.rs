use crate::av::reference_drivers::{DelayedBrake, FuzzySafety, ReferenceDriver, Rss};

/// The reference drivers for the verdict on every failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reference {
    /// UN R157's careful human, 1.15 s after the start of the danger.
    CarefulHuman,
    /// The same, 0.75 s after the time to collision fell to 2 s.
    CarefulHumanAtTwoSeconds,
    /// The Fuzzy Safety Model.
    FuzzySafety,
    /// RSS with the parameters of ad-rss-lib and CARLA.
    Rss,
    /// An emergency brake of 0.85 g after 0.35 s, with a ramp of 0.6 s.
    IdealBrake,
    /// 0.85 g at once.
    Bound,
}

impl Reference {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::CarefulHuman,
        Self::CarefulHumanAtTwoSeconds,
        Self::FuzzySafety,
        Self::Rss,
        Self::IdealBrake,
        Self::Bound,
    ];

    /// The prefix of its columns.
    pub fn name(self) -> &'static str {
        match self {
            Self::CarefulHuman => "cc",
            Self::CarefulHumanAtTwoSeconds => "cc_2s",
            Self::FuzzySafety => "fsm",
            Self::Rss => "rss",
            Self::IdealBrake => "ideal",
            Self::Bound => "bound",
        }
    }

    /// Makes the driver.
    pub fn driver(self) -> Box<dyn ReferenceDriver> {
        match self {
            Self::CarefulHuman => Box::new(DelayedBrake::careful_human()),
            Self::CarefulHumanAtTwoSeconds => Box::new(DelayedBrake::careful_human_at_two_seconds()),
            Self::FuzzySafety => Box::new(FuzzySafety::default()),
            Self::Rss => Box::new(Rss::default()),
            Self::IdealBrake => Box::new(DelayedBrake::ideal()),
            Self::Bound => Box::new(DelayedBrake::bound()),
        }
    }
}
