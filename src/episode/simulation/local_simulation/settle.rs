use super::LocalSimulation;
use crate::scenario::reward::{Hit, HitClass};
use crate::{Ending, MOVING_ABOVE, Outcome, RewardRule, Simulation, Situation};
use learn::Step;
use world::sim::Contact;

/// The end of a decision: its situation and reward, and the outcome of an episode that is over.
impl LocalSimulation {
    /// Computes the reward of the decision, and ends the episode when it is over.
    pub(super) fn settle(&mut self) -> Step {
        self.observers.settle();
        let (rule, reward) = (&self.scenario.episode, &self.scenario.reward);
        let scene = self.scene();
        let (contact, hit) = (scene.actions.contact, scene.hit());
        let judgement = hit.and_then(|_| self.observers.judgement(&self.scenario)).unwrap_or_default();
        let situation = Situation {
            preventability: judgement.preventability,
            avoidable_speed: judgement.avoidable_speed,
            margin: judgement.margin,
            warning: judgement.warning,
            seen: judgement.seen,
            ..self.observers.situation(&scene)
        };
        let lost = || rule.end_when.as_ref().is_some_and(|condition| situation.satisfies(condition));
        let worth = |formula| RewardRule::worth(formula, &situation, &self.observers.requirements.robustness);
        // What does not count is no goal of a search or a training.
        let counts = self.observers.road.left_out.is_none();
        let mut is_fault = false;
        let (earned, ending) = match (hit, contact) {
            (Some(hit), _) => {
                let (front, moving) = (hit.is_front(rule.front), hit.impact_speed > MOVING_ABOVE);
                let judged = Hit { front, moving, judgement };
                is_fault = counts && judged.is(HitClass::Fault);
                let earned = if counts { worth(reward.for_hit(&judged)) } else { 0.0 };
                let Contact { impact_speed, bearing, .. } = *hit;
                let pedestrian = hit.pedestrian_at_ego().unwrap_or_default() as u8;
                let ending = Ending::Touch { pedestrian, front, moving, impact_speed, bearing };
                (earned, Some(ending))
            }
            (None, Some(Contact { pair, .. })) => (worth(reward.step.as_ref()), Some(Ending::OtherContact { pair })),
            (None, None) if lost() || self.is_test_over() => {
                (worth(reward.step.as_ref()) + worth(reward.lost.as_ref()), Some(Ending::Lost))
            }
            (None, None) if self.world.ticks >= rule.ticks => {
                (worth(reward.step.as_ref()) + worth(reward.timeout.as_ref()), Some(Ending::Timeout))
            }
            (None, None) => (worth(reward.step.as_ref()), None),
        };
        let counts = ending.is_some() && counts;
        let violated =
            reward.violated.iter().filter(|(place, _)| counts && self.observers.requirements.violates_paid(*place));
        let earned = earned + violated.map(|(_, formula)| worth(Some(formula))).sum::<f64>();
        // A goal takes the place of the reward.
        let earned = match self.scenario.criterion.requirement() {
            None => earned,
            Some(_) if counts => self.observers.requirements.goal_reward().unwrap_or(0.0),
            Some(_) => 0.0,
        };
        self.episode.reward += earned;
        self.episode.is_fault = is_fault;
        self.episode.is_due = true;
        if let Some(ending) = ending {
            self.finish(ending);
        }
        let truncated = ending == Some(Ending::Timeout);
        Step { reward: earned, terminated: ending.is_some() && !truncated, truncated }
    }

    /// Ends an episode whose driver or world failed: the decision has no reward, and the rest of the episode is unknown.
    pub(super) fn give_up(&mut self, ending: Ending) -> Step {
        self.finish(ending);
        Step { reward: 0.0, terminated: false, truncated: true }
    }

    /// Whether the scenario is the test of a protocol and that test is over.
    pub(super) fn is_test_over(&self) -> bool {
        let test = self.scenario.spawn.target_walk.as_ref();
        test.is_some_and(|walk| walk.is_over(self.world.ego(), &self.world.pedestrians[0]))
    }

    /// Records the outcome of the episode.
    pub(super) fn finish(&mut self, ending: Ending) {
        if !matches!(ending, Ending::Error(_) | Ending::ControllerError(_) | Ending::WorldError(_)) {
            self.observers.requirements.conclude();
        }
        let (scene, tally) = (self.scene(), &self.observers.tally);
        let hit = matches!(ending, Ending::Touch { .. });
        let struck = scene.hit().and_then(Contact::pedestrian_at_ego);
        let place = |number: usize| self.world.pedestrians[number].state.place();
        let on_crosswalk = struck.is_some_and(|number| self.world.town.is_on_crosswalk(place(number)));
        self.episode.outcome = Some(Outcome {
            spawn: self.episode.spawn,
            start: self.episode.start,
            run_up: self.run_up.ticks,
            left_out: self.observers.road.left_out,
            ending,
            reward: self.episode.reward,
            ticks: self.world.ticks,
            duration: scene.elapsed(),
            least_gap: if hit { 0.0 } else { tally.least_gap },
            on_crosswalk,
            last_mode: self.actions.modes[0],
            digest: tally.digest,
            state_hashes: tally.state_hashes,
        });
    }
}
