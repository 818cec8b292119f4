use base::choice;
use world::av::reference_drivers::{DelayedBrake, FuzzySafety, ReferenceDriver, Rss};

choice! {
    /// The reference drivers for the verdict on every failure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Reference {
        /// A careful human with UN R157's times and brake, who evaluates the risk after the gate: it brakes 1.15 s later.
        CarefulHuman = "cc",
        /// The same, who has evaluated the risk when the gate opens: it brakes 0.75 s later.
        AttentiveHuman = "cc_attentive",
        /// The Fuzzy Safety Model.
        FuzzySafety = "fsm",
        /// RSS with the parameters of ad-rss-lib and CARLA, of a car that keeps to its path.
        Rss = "rss_straight",
        /// An emergency brake of 0.85 g, 0.35 s after the gate, with a ramp of 0.6 s.
        IdealBrake = "ideal",
        /// 0.85 g at once.
        Bound = "bound",
    }
}

/// How a reference driver is computed.
pub(super) enum Model {
    /// It brakes a fixed time after it has noticed the pedestrian.
    Delayed(DelayedBrake),
    /// It decides in each step.
    Other(Box<dyn ReferenceDriver>),
}

impl Reference {
    /// The number of reference drivers.
    pub const COUNT: usize = 6;

    /// What it is, for people.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::CarefulHuman => "careful human",
            Self::AttentiveHuman => "attentive human",
            Self::FuzzySafety => "fuzzy safety",
            Self::Rss => "RSS, straight",
            Self::IdealBrake => "ideal brake",
            Self::Bound => "0.85 g at once",
        }
    }

    /// Makes the driver.
    pub fn driver(self) -> Box<dyn ReferenceDriver> {
        match self.model() {
            Model::Delayed(driver) => Box::new(driver),
            Model::Other(driver) => driver,
        }
    }

    /// The time that it lets pass after it has noticed the pedestrian (s); 0 for one that decides in each step.
    pub(super) fn reaction(self) -> f64 {
        match self.model() {
            Model::Delayed(driver) => driver.profile.wait,
            Model::Other(_) => 0.0,
        }
    }

    pub(super) fn model(self) -> Model {
        match self {
            Self::CarefulHuman => Model::Delayed(DelayedBrake::careful_human()),
            Self::AttentiveHuman => Model::Delayed(DelayedBrake::attentive_human()),
            Self::FuzzySafety => Model::Other(Box::new(FuzzySafety::default())),
            Self::Rss => Model::Other(Box::new(Rss::default())),
            Self::IdealBrake => Model::Delayed(DelayedBrake::ideal()),
            Self::Bound => Model::Delayed(DelayedBrake::bound()),
        }
    }
}
