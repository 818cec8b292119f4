use crate::av::reference_drivers::{DelayedBrake, FuzzySafety, ReferenceDriver, Rss, Surprised};
use base::choice;

choice! {
    /// The reference drivers for the verdict on every failure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Reference {
        /// UN R157's careful human, who evaluates the risk after the gate: it brakes 1.15 s later.
        CarefulHuman = "cc",
        /// The same, who has evaluated the risk when the gate opens: it brakes 0.75 s later.
        AttentiveHuman = "cc_attentive",
        /// A human whose response depends on how abruptly the situation turns, after Waymo's NIEON.
        Surprised = "nieon_like",
        /// The careful human, who may also move to a side.
        SwervingHuman = "cc_swerve",
        /// The Fuzzy Safety Model.
        FuzzySafety = "fsm",
        /// The Fuzzy Safety Model, which may also move to a side.
        SwervingFuzzy = "fsm_swerve",
        /// RSS with the parameters of ad-rss-lib and CARLA.
        Rss = "rss",
        /// An emergency brake of 0.85 g, 0.35 s after the gate, with a ramp of 0.6 s.
        IdealBrake = "ideal",
        /// 0.85 g at once.
        Bound = "bound",
    }
}

/// How a reference driver is computed.
pub(super) enum Model {
    /// It brakes as this one does, and may also move to a side.
    Swerving(Reference),
    /// It brakes a fixed time after it has noticed the pedestrian.
    Delayed(DelayedBrake),
    /// It decides in each step.
    Other(Box<dyn ReferenceDriver>),
}

impl Reference {
    /// The number of reference drivers.
    pub const COUNT: usize = 9;
    /// The models of a human: a failure tells how many of them avoid it.
    pub const PANEL: [Self; 5] =
        [Self::CarefulHuman, Self::AttentiveHuman, Self::Surprised, Self::SwervingHuman, Self::SwervingFuzzy];

    /// Makes the driver; one that may move to a side stays on its path.
    pub fn driver(self) -> Box<dyn ReferenceDriver> {
        match self.model() {
            Model::Swerving(other) => other.driver(),
            Model::Delayed(driver) => Box::new(driver),
            Model::Other(driver) => driver,
        }
    }

    /// The time that it lets pass after it has noticed the pedestrian (s); 0 for one that decides in each step.
    pub(super) fn reaction(self) -> f64 {
        match self.model() {
            Model::Delayed(driver) => driver.profile.wait,
            Model::Swerving(_) | Model::Other(_) => 0.0,
        }
    }

    pub(super) fn model(self) -> Model {
        match self {
            Self::CarefulHuman => Model::Delayed(DelayedBrake::careful_human()),
            Self::AttentiveHuman => Model::Delayed(DelayedBrake::attentive_human()),
            Self::Surprised => Model::Other(Box::new(Surprised::default())),
            Self::SwervingHuman => Model::Swerving(Self::CarefulHuman),
            Self::FuzzySafety => Model::Other(Box::new(FuzzySafety::default())),
            Self::SwervingFuzzy => Model::Swerving(Self::FuzzySafety),
            Self::Rss => Model::Other(Box::new(Rss::default())),
            Self::IdealBrake => Model::Delayed(DelayedBrake::ideal()),
            Self::Bound => Model::Delayed(DelayedBrake::bound()),
        }
    }
}
