use super::pid::Gains;
use base::choice;

choice! {
    /// The version of LAV's agent.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Version {
        /// The agent of the paper.
        V1 = "v1",
        /// The agent of the leaderboard.
        #[default]
        V2 = "v2",
        /// The fast variant of the leaderboard's agent, which differs here in the detections that its detector accepts.
        V2Fast = "v2_fast",
    }
}

/// The number of points of the longest plan.
pub(super) const MAX_HORIZON: usize = 20;

/// The figures in which the agents differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Traits {
    /// Points of plans and forecasts, 0.25 s apart.
    pub horizon: usize,
    /// The index of the plan's point to steer for, by command.
    pub aim: [usize; 6],
    /// Share of the plan's speed that is driven, by command.
    pub speed_ratio: [f64; 6],
    /// Gains of the wheel.
    pub turn: Gains,
    /// The classifier brakes above this score.
    pub brake_score: f64,
    /// Distance of plan and forecast that counts as a collision (m).
    pub collision: f64,
    /// The same for road users that are predicted to stand.
    pub collision_standing: f64,
    /// Whether it creeps after a long stop.
    pub creeps: bool,
    /// The number of strongest peaks of each detection map that are evaluated.
    pub peaks: usize,
    /// Their least score, exclusive.
    pub peak_score: f64,
    /// The fast variant's gates of size and range.
    pub fast_gates: bool,
    /// Vehicles up to this distance were labelled when the detector was trained (m).
    pub labelled_within: f64,
    /// Whether it perceives the speeds of others.
    pub senses_speed: bool,
}

const V1: Traits = Traits {
    horizon: 10,
    aim: [4; 6],
    speed_ratio: [1.0; 6],
    turn: Gains { proportional: 1.0, integral: 0.5, differential: 0.2 },
    brake_score: 0.3,
    collision: 2.0,
    collision_standing: 2.0,
    creeps: false,
    peaks: 20,
    peak_score: 0.2,
    fast_gates: false,
    labelled_within: 15.0,
    senses_speed: false,
};

const V2: Traits = Traits {
    horizon: MAX_HORIZON,
    aim: [4, 4, 4, 3, 6, 6],
    speed_ratio: [0.8, 0.8, 0.8, 0.6, 0.8, 0.8],
    turn: Gains { proportional: 0.8, integral: 0.5, differential: 0.2 },
    brake_score: 0.1,
    collision: 2.5,
    collision_standing: 1.0,
    creeps: true,
    peaks: 15,
    peak_score: 0.1,
    fast_gates: false,
    labelled_within: 25.0,
    senses_speed: true,
};

const V2_FAST: Traits = Traits { peak_score: 0.2, fast_gates: true, ..V2 };

impl Version {
    pub(super) fn traits(self) -> &'static Traits {
        match self {
            Self::V1 => &V1,
            Self::V2 => &V2,
            Self::V2Fast => &V2_FAST,
        }
    }
}
