use super::PedestrianEnv;
use crate::env::reward::{Hit, HitClass};
use crate::env::{Ending, Judgement, Outcome, RewardRule, Situation};
use crate::sim::Contact;
use learn::Step;

/// The end of a decision: its situation and reward, and the outcome of an episode that is over.
impl PedestrianEnv {
    /// Computes the reward of the decision, and ends the episode when it is over.
    pub(super) fn settle(&mut self, contact: Option<Contact>) -> Step {
        self.episode.state_hashes.mark(self.episode.digest);
        self.measure_robustness();
        let (rule, reward) = (&self.scenario.episode, &self.scenario.reward);
        let hit = contact.filter(|contact| contact.pedestrian_at_ego().is_some());
        let judgement = hit.and_then(|_| self.judgement()).unwrap_or_default();
        let situation = Situation {
            preventability: judgement.preventability,
            avoidable_speed: judgement.avoidable_speed,
            margin: judgement.margin,
            warning: judgement.warning,
            seen: judgement.seen,
            ..self.situation(contact.as_ref())
        };
        let lost = || rule.end_when.as_ref().is_some_and(|condition| situation.satisfies(condition));
        let worth = |formula| RewardRule::worth(formula, &situation, &self.robustness);
        let mut is_fault = false;
        let (earned, ending) = match (hit, contact) {
            (Some(hit), _) => {
                let (front, moving) = (hit.is_front(rule.front_half_angle), hit.impact_speed > rule.moving_above);
                // A hit that does not count is no goal of a search or a training.
                let counts = self.episode.left_out.is_none();
                let judged = Hit { front, moving, judgement };
                is_fault = counts && judged.is(HitClass::Fault);
                let earned = if counts { worth(reward.for_hit(&judged)) } else { 0.0 };
                let ending = Ending::Touch { front, moving, impact_speed: hit.impact_speed, bearing: hit.bearing };
                (earned, Some(ending))
            }
            (None, Some(_)) => (worth(reward.step.as_ref()), Some(Ending::OtherContact)),
            (None, None) if lost() || self.is_test_over() => {
                (worth(reward.step.as_ref()) + worth(reward.lost.as_ref()), Some(Ending::Lost))
            }
            (None, None) if self.world.ticks >= rule.ticks => {
                (worth(reward.step.as_ref()) + worth(reward.timeout.as_ref()), Some(Ending::Timeout))
            }
            (None, None) => (worth(reward.step.as_ref()), None),
        };
        let counts = ending.is_some() && self.episode.left_out.is_none();
        let violated = reward.violated.iter().filter(|(place, _)| counts && self.violates_paid(*place));
        let earned = earned + violated.map(|(_, formula)| worth(Some(formula))).sum::<f64>();
        // A goal takes the place of the reward.
        let earned = match (self.scenario.criterion.requirement(), ending) {
            (None, _) => earned,
            (Some(_), None) => 0.0,
            (Some(_), Some(_)) if self.episode.left_out.is_some() => 0.0,
            (Some(_), Some(_)) => self.goal_reward().unwrap_or(0.0),
        };
        self.episode.reward += earned;
        self.episode.is_fault = is_fault;
        if let Some(ending) = ending {
            self.finish(ending, contact.as_ref());
            self.faults_in_a_row = 0;
        }
        let truncated = ending == Some(Ending::Timeout);
        Step { reward: earned, terminated: ending.is_some() && !truncated, truncated }
    }

    /// Whether the scenario is the test of a protocol and that test is over.
    pub(super) fn is_test_over(&self) -> bool {
        let test = self.scenario.spawn.target_walk.as_ref();
        test.is_some_and(|walk| walk.is_over(self.world.ego(), &self.world.pedestrians[0]))
    }

    /// The judgement of the hit that has just happened, if the reward depends on it.
    fn judgement(&self) -> Option<Judgement> {
        let (oracle, trace) = (self.scenario.oracle.as_ref()?, self.trace.as_ref()?);
        Some(oracle.judge(&trace.main_pair(&self.scenario)))
    }

    /// Records the outcome of the episode.
    pub(super) fn finish(&mut self, ending: Ending, contact: Option<&Contact>) {
        if !matches!(ending, Ending::Error(_) | Ending::ControllerError(_)) {
            self.conclude_requirements();
        }
        let hit = matches!(ending, Ending::Touch { .. });
        let struck = contact.and_then(Contact::pedestrian_at_ego);
        let place = |number: usize| self.world.pedestrians[number].state.pose.position();
        let on_crosswalk = struck.is_some_and(|number| self.world.town.is_on_crosswalk(place(number)));
        self.episode.outcome = Some(Outcome {
            spawn: self.episode.spawn,
            start: self.episode.start,
            run_up: self.episode.run_up,
            left_out: self.episode.left_out,
            ending,
            reward: self.episode.reward,
            ticks: self.world.ticks,
            duration: self.elapsed(contact),
            least_gap: if hit { 0.0 } else { self.episode.least_gap },
            on_crosswalk,
            last_mode: self.policies[0].mode(),
            digest: self.episode.digest,
            state_hashes: self.episode.state_hashes,
        });
    }

    /// The situation of the ego and the pedestrian that it touched, or the first pedestrian when it touched none.
    pub(super) fn situation(&self, contact: Option<&Contact>) -> Situation {
        let hit = contact.filter(|contact| contact.pedestrian_at_ego().is_some());
        self.situation_of(hit.and_then(Contact::pedestrian_at_ego).unwrap_or(0), contact)
    }

    /// The situation of the ego and a pedestrian.
    pub(super) fn situation_of(&self, struck: usize, contact: Option<&Contact>) -> Situation {
        let hit = contact.filter(|contact| contact.pedestrian_at_ego().is_some());
        let (ego, pedestrian) = (&self.world.ego().state, &self.world.pedestrians[struck].state);
        let local = ego.pose.to_local(pedestrian.pose.position());
        let (ahead, aside) = hit.map_or((local.x, local.y), |hit| (hit.ahead, hit.aside));
        let motion = self.motions.get(struck);
        Situation {
            v_c: hit.map_or(0.0, |hit| hit.impact_speed),
            bearing: hit.map_or_else(|| libm::atan2(aside, ahead), |hit| hit.bearing),
            distance: (ahead * ahead + aside * aside).sqrt(),
            ahead,
            aside,
            ego_speed: hit.map_or(ego.speed, |hit| hit.impact_speed),
            walking_speed: pedestrian.speed(),
            elapsed: self.elapsed(contact),
            facing: {
                let seen = pedestrian.pose.to_local(ego.pose.position());
                libm::atan2(seen.y, seen.x)
            },
            turn: self.walks.turns[struck],
            pace: self.walks.commands[struck].speed,
            miss_distance: if hit.is_some() { 0.0 } else { self.episode.least_gap },
            min_ttc: motion.map_or(0.0, |motion| motion.min_ttc),
            ego_deceleration: motion.map_or(0.0, |motion| motion.ego_deceleration),
            walking_acceleration: motion.map_or(0.0, |motion| motion.walking_acceleration),
            walking_turn: motion.map_or(0.0, |motion| motion.walking_turn),
            ..self.signals.as_ref().map_or_else(Situation::default, |signals| *signals.now())
        }
    }

    /// Time until now, or until a touch within the last tick (s).
    pub(super) fn elapsed(&self, contact: Option<&Contact>) -> f64 {
        let before = f64::from(self.world.ticks.saturating_sub(1)) * self.world.dt;
        contact.map_or(self.world.elapsed(), |contact| before + contact.fraction * self.world.dt)
    }
}
