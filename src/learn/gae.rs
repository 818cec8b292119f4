//! Generalised advantage estimation.

/// The recorded part of one environment's experience, one element per step.
#[derive(Debug, Clone, Copy)]
pub struct Trajectory<'a> {
    /// The rewards, with the critic's estimate already added where an episode was cut off.
    pub rewards: &'a [f64],
    /// The critic's values of the observations the decisions were taken from.
    pub values: &'a [f64],
    /// Whether the observation of a step is the first of an episode.
    pub episode_starts: &'a [bool],
    /// The critic's value of the observation after the last step.
    pub last_value: f64,
    /// Whether the last step ended an episode.
    pub last_done: bool,
}

/// Writes the advantages and the returns (advantage plus value) of a trajectory.
///
/// # Source
/// `RolloutBuffer.compute_returns_and_advantage` of stable-baselines3; Schulman et al. (2016), equation 16.
pub fn advantages_and_returns(
    trajectory: Trajectory<'_>,
    gamma: f64,
    lambda: f64,
    advantages: &mut [f64],
    returns: &mut [f64],
) {
    let mut next_value = trajectory.last_value;
    let mut next_is_new = trajectory.last_done;
    let mut advantage = 0.0;
    for at in (0..trajectory.rewards.len()).rev() {
        let alive = if next_is_new { 0.0 } else { 1.0 };
        let value = trajectory.values[at];
        let delta = trajectory.rewards[at] + gamma * next_value * alive - value;
        advantage = delta + gamma * lambda * alive * advantage;
        advantages[at] = advantage;
        returns[at] = advantage + value;
        next_value = value;
        next_is_new = trajectory.episode_starts[at];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// γ = 0.5, λ = 0.5, an episode that ends after the second of four steps.
    #[test]
    fn advantages_by_hand_do_not_cross_an_episode_boundary() {
        let trajectory = Trajectory {
            rewards: &[1.0, 2.0, 3.0, 4.0],
            values: &[0.5, 1.0, 1.5, 2.0],
            episode_starts: &[true, false, true, false],
            last_value: 8.0,
            last_done: false,
        };
        let (mut advantages, mut returns) = ([0.0; 4], [0.0; 4]);
        advantages_and_returns(trajectory, 0.5, 0.5, &mut advantages, &mut returns);
        // δ₃ = 4 + 4 − 2 = 6; δ₂ = 3 + 1 − 1.5 = 2.5; δ₁ = 2 − 1 = 1 (end of episode); δ₀ = 1 + 0.5 − 0.5 = 1.
        assert_eq!(advantages, [1.25, 1.0, 4.0, 6.0]);
        assert_eq!(returns, [1.75, 2.0, 5.5, 8.0]);

        advantages_and_returns(Trajectory { last_done: true, ..trajectory }, 0.5, 0.5, &mut advantages, &mut returns);
        assert_eq!(advantages, [1.25, 1.0, 3.0, 2.0]);
    }
}
