//! Potential-based shaping: it guides the learner and does not change the optimal policies.
//!
//! Every decision earns F = γ Φ(s′) − Φ(s) in addition to its reward, where Φ of a terminal state is 0. Over an episode from s₀
//! that ends after T decisions the discounted sum telescopes,
//!
//! ```text
//! Σ γᵗ F(sₜ, sₜ₊₁) = γᵀ Φ(s_T) − Φ(s₀) = −Φ(s₀),
//! ```
//!
//! for every sequence of actions. So every policy's value is V(s) − Φ(s), all policies keep their order in every state, and a
//! policy is optimal with shaping if and only if it is optimal without. An episode that is cut off keeps Φ(s_T): its critic's
//! value estimates the rewards that would have followed, which is V(s_T) − Φ(s_T).
//!
//! # Source
//! Ng, Harada and Russell, *Policy invariance under reward transformations*, ICML 1999; for the end of episodes Grzes,
//! *Reward shaping in episodic reinforcement learning*, AAMAS 2017.

use super::env::Step;

/// Returns what a step earns in addition to its reward, from the potentials before and after it.
pub fn shaping(before: f64, after: f64, step: Step, gamma: f64) -> f64 {
    let after = if step.terminated { 0.0 } else { after };
    gamma * after - before
}
