use episode::{Abilities, ExternalWorld};

/// What a reader of a recheck must know.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RecheckNote {
    #[error("stopped: failures that were not met: {failures}")]
    Left { failures: u64 },
    #[error("stopped: the fixed list that was under way is left out, and those after it")]
    ListLeft,
    #[error(
        "the old driver cannot be run as it was ({reason}): its ends are those of the report, recorded commands of evaluations are not known, and \
         the crossings have only the new driver"
    )]
    OldDriverGone { reason: String },
    #[error("`{driver}` is not among the new drivers and is left out; `--driver {driver}=NAME` names its new version")]
    NoPartner { driver: String },
    #[error(
        "failures of searches that are met by their recorded commands alone: {failures}; the search chose commands, not a pedestrian that could walk again"
    )]
    CommandsAlone { failures: u64 },
    #[error(
        "failures of the report that end otherwise now although the old driver drives: {failures}; another version of the program made the report, or the driver does not drive the same way twice; `falsify replay --all` shows them"
    )]
    OtherNow { failures: u64 },
    #[error("failures that cannot be repeated and are left out, since their commands are damaged: {failures}")]
    Damaged { failures: u64 },
    #[error(
        "the new drivers drive in `{name}` ({version}); starts, pedestrians, collisions and verdicts are those of the report"
    )]
    Elsewhere { name: String, version: String },
    /// What a new driver lacks in its simulator.
    #[error("{said}")]
    Lacks { said: String },
    #[error("the fixed list is left out in another simulator; `--starts N` has it there, from N starts")]
    NoFixedList,
    #[error(
        "a driver, a pedestrian or the world failed as a program; first in {first}. Ten failures in a row end the episodes with a driver"
    )]
    Failed {
        /// The first of the failures, with what failed and why.
        first: String,
    },
    #[error("episodes that have another start with the new driver and are left out: {encounters}")]
    OtherStart { encounters: u64 },
}

impl RecheckNote {
    /// Whether the user stopped.
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Left { .. } | Self::ListLeft)
    }

    /// The note about another simulator that was asked who it is.
    pub fn elsewhere(world: &ExternalWorld) -> Self {
        let Abilities { name, version, .. } = world.abilities.clone().unwrap_or_default();
        Self::Elsewhere { name, version }
    }
}
