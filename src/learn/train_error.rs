//! Why training ends early.

use std::fmt;

/// Why training ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// A number was infinite or not a number.
    #[error(
        "the {quantity} was not finite in update {update}: the training has come apart; a smaller `learning_rate`, fewer `epochs` or \
         smaller rewards may help"
    )]
    NonFinite {
        /// The update, from 1.
        update: u64,
        /// The quantity that was not finite.
        quantity: Quantity,
    },
    /// The observer asked to stop.
    #[error("stopped after update {update}")]
    Stopped {
        /// The last update that was completed, from 1.
        update: u64,
    },
}

/// A number that training requires to be finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// An observation of an environment, in `f32`.
    Observation,
    /// A reward of an environment.
    Reward,
    /// An action of the policy.
    Action,
    /// The loss on a minibatch.
    Loss,
    /// The divergence between old and new policy on a minibatch.
    Divergence,
    /// The norm of the gradient on a minibatch.
    Gradient,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Observation => "observation",
            Self::Reward => "reward",
            Self::Action => "action",
            Self::Loss => "loss",
            Self::Divergence => "divergence",
            Self::Gradient => "gradient",
        })
    }
}
