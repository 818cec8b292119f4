use serde::{Deserialize, Serialize};

use crate::{Spawn, StateHashes};
use base::choice;
use world::av::{DrivingMode, Fault};
use world::sim::ActorId;

choice! {
    /// Why an episode is in no rate, comparison, gate, search or list of failures: the driver was lost before a pedestrian had any part in it, or the
    /// map was at its end.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    pub enum LeftOut {
        /// The driver did not reach its start in the run-up.
        RunUp = "run_up",
        /// The centre of the car was outside all driving lanes before, or at the tick in which, a pedestrian came into sight for the first time.
        OffRoad = "off_road",
        /// The centre of the car was past the end of a lane that leads nowhere.
        RoadEnd = "road_end",
    }
}

/// Why an episode ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// A pedestrian and the ego touched: a collision if the ego moved, otherwise a bump.
    Touch {
        /// The number of the pedestrian in its cast.
        #[serde(default, skip_serializing_if = "is_first")]
        pedestrian: u8,
        /// Whether the pedestrian was within the front sector.
        front: bool,
        /// Whether the ego moved.
        moving: bool,
        /// Speed of the ego (m/s).
        impact_speed: f64,
        /// Bearing of the pedestrian from the ego's centre, positive to the left (rad).
        bearing: f64,
    },
    /// These two actors touched, of which one is not the ego or both are vehicles.
    OtherContact { pair: (ActorId, ActorId) },
    /// The `end_when` condition was true, or the test of a protocol was over.
    Lost,
    /// The episode reached its time limit.
    Timeout,
    /// The driver failed as a program, so how it would have driven is unknown. It may succeed another time, so this is not stored.
    #[serde(skip)]
    Error(Fault),
    /// The controller of the pedestrian failed as a program. As for a driver, this is not stored.
    #[serde(skip)]
    ControllerError(Fault),
    /// The other simulator in which the episode was to happen failed as a program. As for a driver, this is not stored.
    #[serde(skip)]
    WorldError(Fault),
}

/// Whether a pedestrian is the only one of a scenario without others; then its number is not stored.
fn is_first(pedestrian: &u8) -> bool {
    *pedestrian == 0
}

/// The outcome of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its start; after a run-up the ego's pose and speed are those that its driver reached.
    pub spawn: Spawn,
    /// A hash of the start as it was drawn, before the driver had any influence: equal for all drivers and controllers that meet it.
    pub start: u64,
    /// Ticks of the run-up; 0 without one.
    pub run_up: u32,
    /// Why it is in no rate; `None` if it counts.
    pub left_out: Option<LeftOut>,
    /// Why it ended.
    pub ending: Ending,
    /// Sum of the rewards.
    pub reward: f64,
    /// Ticks it lasted.
    pub ticks: u32,
    /// Time from its start to the touch or the end (s).
    pub duration: f64,
    /// Least distance from the pedestrian's disc to the ego's box (m); 0 at a touch.
    pub least_gap: f64,
    /// Whether the pedestrian was on a crosswalk at the touch; false without a touch.
    pub on_crosswalk: bool,
    /// The driver's action in the last tick: after a collision, that at the touch.
    pub last_mode: DrivingMode,
    /// A digest of every state of the episode: equal digests mean equal episodes.
    pub digest: u64,
    /// Hashes of the states along the episode. They show from where on two episodes differ.
    pub state_hashes: StateHashes,
}

impl Outcome {
    /// Whether the pedestrian and the ego touched.
    pub fn is_touch(&self) -> bool {
        matches!(self.ending, Ending::Touch { .. })
    }

    /// The actors that touched at its end; `None` if no two did.
    pub fn touched(&self) -> Option<(ActorId, ActorId)> {
        match self.ending {
            Ending::Touch { pedestrian, .. } => Some((ActorId::EGO, ActorId::Pedestrian(pedestrian))),
            Ending::OtherContact { pair } => Some(pair),
            _ => None,
        }
    }

    /// Whether the moving ego touched the pedestrian.
    pub fn is_collision(&self) -> bool {
        matches!(self.ending, Ending::Touch { moving: true, .. })
    }

    /// Whether the pedestrian touched the standing ego, which is not a failure.
    pub fn is_bump(&self) -> bool {
        matches!(self.ending, Ending::Touch { moving: false, .. })
    }

    /// Whether it is in rates, comparisons, gates, searches and lists of failures: no program failed, and it is not left out.
    pub fn counts(&self) -> bool {
        self.fault().is_none() && self.left_out.is_none()
    }

    /// The fault of the driver, of the controller or of the world, if it ended the episode.
    pub fn fault(&self) -> Option<Fault> {
        match self.ending {
            Ending::Error(fault) | Ending::ControllerError(fault) | Ending::WorldError(fault) => Some(fault),
            _ => None,
        }
    }

    /// Who failed as a program, and why, such as `the driver ended before it answered`; `None` for other endings.
    pub fn error(&self) -> Option<String> {
        match self.ending {
            Ending::Error(fault) => Some(format!("the driver {fault}")),
            Ending::ControllerError(fault) => Some(format!("the pedestrian {fault}")),
            Ending::WorldError(fault) => Some(format!("the world {fault}")),
            _ => None,
        }
    }

    /// Speed of the ego at the touch (m/s); `None` without one.
    pub fn impact_speed(&self) -> Option<f64> {
        match self.ending {
            Ending::Touch { impact_speed, .. } => Some(impact_speed),
            _ => None,
        }
    }
}

choice! {
    /// The side of the car that was hit.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Impact {
        /// Within the front sector.
        Front = "front",
        /// Beside it, to the car's left.
        Left = "left",
        /// Beside it, to the car's right.
        Right = "right",
        /// Within 60° of straight behind.
        Rear = "rear",
    }
}

impl Impact {
    /// The side where a pedestrian hit the car, from whether it was within the front sector and from its bearing from the car's centre
    /// (rad).
    pub fn new(front: bool, bearing: f64) -> Self {
        match bearing {
            _ if front => Self::Front,
            b if b.abs() >= 120_f64.to_radians() => Self::Rear,
            b if b > 0.0 => Self::Left,
            _ => Self::Right,
        }
    }

    /// That of an episode; `None` without a touch.
    pub fn of(outcome: &Outcome) -> Option<Self> {
        match outcome.ending {
            Ending::Touch { front, bearing, .. } => Some(Self::new(front, bearing)),
            _ => None,
        }
    }
}
