//! Why training ends early.

use std::fmt;

use base::choice;

/// Why training ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    #[error(
        "the {quantity} was not finite in update {update}: the training has come apart; a smaller `learning_rate`, fewer `epochs` or \
         smaller rewards may help"
    )]
    NonFinite { update: u64, quantity: Quantity },
    #[error("stopped after update {update}")]
    Stopped {
        /// The last update that was completed, from 1.
        update: u64,
    },
}

choice! {
    /// A number that training requires to be finite.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Quantity {
        /// An observation of an environment, in `f32`.
        Observation = "observation",
        /// A reward of an environment.
        Reward = "reward",
        /// An action of the policy.
        Action = "action",
        /// The loss on a minibatch.
        Loss = "loss",
        /// The divergence between old and new policy on a minibatch.
        Divergence = "divergence",
        /// The norm of the gradient on a minibatch.
        Gradient = "gradient",
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
