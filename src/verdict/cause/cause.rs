use crate::Traffic;
use world::av::{Fault, Weakness};

/// Maximum number of episodes of an explanation where the caller sets none.
pub const MAX_RUNS: u32 = 600;
/// The same for a program, of whose failures several are explained.
pub const MAX_RUNS_OF_PROGRAM: u32 = 200;
/// What of a driver is made perfect.
pub(super) const FACULTIES: [&str; 4] = ["perfect perception", "perfect prediction", "a perfect brake", "no delay"];

/// Why a driver failed, by runs with one thing changed. Times are before the touch, or before the end of the episode that violates a requirement (s).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cause {
    pub weakness: Weakness,
    /// Of [`Weakness`]: how much of it, such as the delay (s) or by how much the corridor is too narrow (m).
    pub amount: Option<f64>,
    /// The side of the car that the driver does not watch enough, if a [`Weakness::BlindSide`] is named: `left` or `right`.
    pub side: Option<&'static str>,
    /// Weaknesses of which the repair of each alone avoids the failure, as runs show: the named one, and the next in the order of the rules.
    pub enough: Vec<Weakness>,
    /// What times are before: `the collision`, or `the end of the episode` of a violation.
    pub end: &'static str,
    /// Which requirement is violated, when and by how much; `None` of a collision.
    pub violated: Option<String>,
    /// When full braking, comfortable braking and swerving help for the last time; `None` if they never do.
    pub last: [Option<f64>; 3],
    /// For how long the pedestrian was in sight without a break.
    pub seen: f64,
    /// When the driver's commands depend on the pedestrian for the first time; `None` if they are those of an empty road, bit for bit.
    pub reacted: Option<f64>,
    /// When it braked for the first time after that; `None` if it did not.
    pub braked: Option<f64>,
    /// Whether it stood shortly before, and at a red light.
    pub drove_off: Option<bool>,
    /// What of a driver was made perfect, one at a time, and whether that turns it. One that does not is left out if a stronger repair of the same is enough.
    pub faculties: Vec<(&'static str, bool)>,
    /// The smallest change of a setting of the driver or of its sensors that turns it, as all larger ones that were tried do; one that costs no faults in
    /// natural crossings comes first.
    pub setting: Option<TurnedBy>,
    /// The same of the world: a lower speed limit, a road with more friction.
    pub world: Option<TurnedBy>,
    /// What turns it if it is not there: the traffic lights, or an obstacle that hides the pedestrian.
    pub without: Option<String>,
    /// In how many of how many runs with other draws of the driver it avoids the failure; `None` if it draws nothing.
    pub draws: Option<[u32; 2]>,
    /// What was tried, each with whether it turns the failure.
    pub tried: Vec<(String, bool)>,
    /// The number of episodes that it took.
    pub runs: u32,
    /// Whether more runs were wanted than the limit allows. What was not asked by then is left out, and the weakness is
    /// [`Weakness::NotFound`] if the cause depends on that.
    pub is_cut: bool,
    /// Why there were no more runs before the limit: the driver failed as a program in one, which is no evidence.
    pub fault: Option<Fault>,
}

/// What is asked about a failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Questions {
    /// The weakness, and what would have helped when.
    Weakness,
    /// The settings too; `None` for a driver that cannot be copied, such as a program, which drives its run-up in each of about a hundred runs.
    OfCopied,
    /// The settings too, of every driver. Those of the world are left out for one that cannot be copied.
    All,
}

/// A setting with another value, with which a failure does not happen.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedBy {
    pub name: String,
    pub unit: &'static str,
    pub from: f64,
    pub to: f64,
    /// Natural crossings with the value before, and with the other.
    pub natural: [Traffic; 2],
}

/// How many episodes an explanation may take.
#[derive(Clone, Copy)]
pub struct RunLimit<'a> {
    pub max_runs: u32,
    /// Called before each episode after the first, which repeats the failure.
    pub ran: &'a dyn Fn(),
}

impl Default for RunLimit<'_> {
    fn default() -> Self {
        Self { max_runs: MAX_RUNS, ran: &|| () }
    }
}
