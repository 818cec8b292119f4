//! Likelihoods and covers: how often their bounds hold.
#![expect(clippy::print_stderr, reason = "a comparison prints how close it came")]

mod likelihood;
mod cover;
