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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_terminated_episode_earns_the_same_from_any_of_its_states(
            potentials in prop::collection::vec(-5.0..5.0, 2..30), rewards in prop::collection::vec(-2.0..2.0, 30),
            gamma in 0.0..=1.0,
        ) {
            let last = potentials.len() - 2;
            let (mut plain, mut shaped): (f64, f64) = (0.0, 0.0);
            for t in (0..=last).rev() {
                let step = Step { reward: rewards[t], terminated: t == last, truncated: false };
                let beside: f64 = shaping(potentials[t], potentials[t + 1], step, gamma);
                plain = step.reward + gamma * plain;
                shaped = step.reward + beside + gamma * shaped;
                // In every state and for every sequence, the value with shaping is the value without it minus the potential.
                prop_assert!((shaped - (plain - potentials[t])).abs() < 1e-9, "{shaped} {plain} {}", potentials[t]);
            }
        }

        #[test]
        fn an_episode_that_is_cut_off_differs_by_the_potential_as_well(
            potentials in prop::collection::vec(-5.0..5.0, 2..30), beyond in -3.0..3.0, gamma in 0.0..=1.0,
        ) {
            // The rewards that would have followed are worth `beyond`; with shaping, `beyond` minus the potential there.
            let last = potentials.len() - 2;
            let (mut plain, mut shaped): (f64, f64) = (beyond, beyond - potentials[last + 1]);
            for t in (0..=last).rev() {
                let step = Step { reward: 1.0, terminated: false, truncated: t == last };
                plain = 1.0 + gamma * plain;
                shaped = 1.0 + shaping(potentials[t], potentials[t + 1], step, gamma) + gamma * shaped;
            }
            prop_assert!((shaped - (plain - potentials[0])).abs() < 1e-9);
        }
    }
}
