use indicatif::HumanCount;
use serde::Serialize;

use crate::session::NewestUpdate;
use learn::UpdateLog;

/// What a training has learnt up to now, in the newest row of its learning curve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Learnt {
    pub updates: u64,
    /// The number of episodes that have ended.
    pub episodes: u64,
    /// The mean reward of the last episodes, up to 100 of them; `None` before the first has ended.
    pub mean_reward: Option<f64>,
    pub mean_length_decisions: Option<f64>,
    /// The share of them that ended in a collision, with actions drawn from the policy.
    pub collision_rate: Option<f64>,
    /// The share of them that ended in a fault of the driver; `None` where the reward asks for no judgement.
    pub fault_rate: Option<f64>,
}

impl Learnt {
    /// Follows a learning curve that has grown.
    pub fn follow(&mut self, curve: &[UpdateLog]) {
        let known = curve.iter().position(|log| log.update > self.updates).unwrap_or(curve.len());
        self.episodes += curve[known..].iter().map(|log| log.episodes as u64).sum::<u64>();
        if let Some(last) = curve.last() {
            self.updates = last.update;
            self.mean_reward = last.mean_reward;
            self.mean_length_decisions = last.mean_length;
            self.collision_rate = last.success_rate;
            self.fault_rate = last.fault_rate;
        }
    }

    /// Its reward, collisions and faults, for people; `None` before the first episode has ended.
    pub fn told(&self) -> Option<String> {
        let reward = self.mean_reward?;
        let rate = self.collision_rate?;
        let faults = self.fault_rate.map(|rate| format!(", {:.0} % faults", 100.0 * rate)).unwrap_or_default();
        Some(format!(
            "mean reward {reward:.3}, exploring: {:.0} % collisions{faults}, {} episodes",
            100.0 * rate,
            HumanCount(self.episodes)
        ))
    }
}

impl From<&NewestUpdate> for Learnt {
    fn from(newest: &NewestUpdate) -> Self {
        let &NewestUpdate { updates, episodes, mean_reward, collision_rate, fault_rate, .. } = newest;
        Self { updates, episodes, mean_reward, mean_length_decisions: None, collision_rate, fault_rate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(update: u64, episodes: usize) -> UpdateLog {
        UpdateLog { update, episodes, mean_reward: Some(0.5), success_rate: Some(0.25), ..UpdateLog::default() }
    }

    #[test]
    fn episodes_of_every_update_count_once() {
        let curve = [log(1, 3), log(2, 4), log(3, 1000)];
        let mut learnt = Learnt::default();
        learnt.follow(&curve[..1]);
        learnt.follow(&curve[..2]);
        learnt.follow(&curve[..2]);
        assert_eq!((learnt.updates, learnt.episodes), (2, 7));
        learnt.follow(&curve);
        assert_eq!(learnt.told().unwrap(), "mean reward 0.500, exploring: 25 % collisions, 1,007 episodes");
        let judged = Learnt { fault_rate: Some(0.04), ..learnt };
        assert_eq!(judged.told().unwrap(), "mean reward 0.500, exploring: 25 % collisions, 4 % faults, 1,007 episodes");
        assert_eq!(Learnt::default().told(), None);
    }
}
