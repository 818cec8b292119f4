use super::motion::Motion;
use super::requirement_watch::RequirementWatch;
use super::road_watch::RoadWatch;
use super::signal_meter::SignalMeter;
use super::tally::Tally;
use crate::scenario::reward::is_about_motion;
use crate::scenario::signal::{Wanted, is_measured};
use crate::{Judgement, Observer, Scenario, Scene, Situation, Trace};
use world::sim::{Contact, World};

/// All that watches a running episode. What nobody asks for is absent.
#[derive(Debug, Clone)]
pub(super) struct Observers {
    pub(super) tally: Tally,
    pub(super) road: RoadWatch,
    /// The motion of each pedestrian with the ego; empty if no formula depends on it.
    motions: Vec<Motion>,
    /// The signals that formulas name.
    signals: Option<SignalMeter>,
    pub(super) requirements: RequirementWatch,
    /// The episode so far, if the reward depends on the judgement of a hit, or several pedestrians can be hit.
    trace: Option<Trace>,
}

/// Samples of an episode for which memory is reserved; longer episodes reserve more once.
pub(super) const MAX_RESERVED: u32 = 4096;

impl Observers {
    pub(super) fn new(scenario: &Scenario, world: &World) -> Self {
        let rule = &scenario.episode;
        let samples = rule.ticks.min(MAX_RESERVED) as usize + 1;
        let is_motion_asked = scenario.reward.needs_motion() || rule.end_when.as_ref().is_some_and(is_about_motion);
        let asked = if is_motion_asked { world.pedestrians.len() } else { 0 };
        let is_judged = scenario.oracle.is_some() && (scenario.reward.needs_judgement() || world.pedestrians.len() > 1);
        Self {
            tally: Tally::new(),
            road: RoadWatch::new(rule.count_all),
            motions: (0..asked).map(|number| Motion::new(world, number)).collect(),
            signals: wanted(scenario).map(|wanted| SignalMeter::new(wanted, world, samples)),
            requirements: RequirementWatch::new(scenario, samples),
            trace: is_judged.then(|| Trace::new(scenario)),
        }
    }

    /// Before an episode.
    pub(super) fn clear(&mut self, scenario: &Scenario) {
        (self.tally, self.road) = (Tally::new(), RoadWatch::new(scenario.episode.count_all));
    }

    /// Tick 0: the pedestrians have appeared.
    pub(super) fn begin(&mut self, scene: &Scene<'_>) {
        self.tally.begin(scene.world);
        for (pedestrian, motion) in self.motions.iter_mut().enumerate() {
            *motion = Motion::new(scene.world, pedestrian);
        }
        if let Some(trace) = &mut self.trace {
            trace.begin(scene);
        }
        self.begin_samples(scene);
        self.road.begin(scene.world);
    }

    /// A decision has been taken.
    pub(super) fn decide(&mut self, scene: &Scene<'_>) {
        self.motions.iter_mut().for_each(Motion::begin_decision);
        if let Some(trace) = &mut self.trace {
            trace.decide(scene);
        }
        // It may have moved the target of a test to its start.
        if scene.world.ticks == 0 {
            self.begin_samples(scene);
        }
    }

    /// A tick has been simulated.
    #[inline]
    pub(super) fn tick(&mut self, scene: &Scene<'_>) {
        self.motions.iter_mut().for_each(|motion| motion.tick(scene.world));
        self.tally.tick(scene.world);
        if let Some(signals) = &mut self.signals {
            signals.tick(scene.world, scene.contact());
            self.sample(scene);
        }
        self.road.tick(scene.world);
        if let Some(trace) = &mut self.trace {
            trace.tick(scene);
        }
    }

    /// The car has touched a pedestrian, who leaves the world. `next` is the next touch in the same tick.
    pub(super) fn touch(&mut self, pedestrian: usize, next: Option<Contact>) {
        if let Some(trace) = &mut self.trace {
            trace.touch(pedestrian, next);
        }
    }

    /// All ticks of a decision have been simulated.
    pub(super) fn settle(&mut self) {
        self.tally.settle();
        self.requirements.settle();
    }

    /// The judgement of the hit that has just happened, if it is asked for.
    pub(super) fn judgement(&self, scenario: &Scenario) -> Option<Judgement> {
        let (oracle, trace) = (scenario.oracle.as_ref()?, self.trace.as_ref()?);
        Some(oracle.judge(&trace.main_pair(scenario)))
    }

    fn begin_samples(&mut self, scene: &Scene<'_>) {
        if let Some(signals) = &mut self.signals {
            signals.begin(scene.world);
        }
        self.requirements.clear();
        self.sample(scene);
        self.requirements.settle();
    }

    fn sample(&mut self, scene: &Scene<'_>) {
        if !self.requirements.is_idle() {
            let number = SignalMeter::pedestrian(scene.world, scene.contact());
            self.requirements.push(scene, number, &self.sampled(scene, number));
        }
    }

    /// The variables that requirements name.
    fn sampled(&self, scene: &Scene<'_>, number: usize) -> Situation {
        let Some(signals) = &self.signals else { return Situation::default() };
        let wanted = signals.wanted();
        let is_placed = wanted.bearing || wanted.distance || wanted.ahead || wanted.aside || wanted.facing;
        if is_placed || wanted.turn || wanted.pace || wanted.miss_distance {
            return self.situation_of(scene, number);
        }
        let hit = scene.hit();
        Situation {
            ego_speed: hit.map_or(scene.world.ego().state.speed, |hit| hit.impact_speed),
            walking_speed: scene.world.pedestrians[number].state.speed(),
            elapsed: scene.elapsed(),
            ..*signals.now()
        }
    }

    /// The situation of the ego and the pedestrian that it touched, or the first pedestrian if it touched none.
    pub(super) fn situation(&self, scene: &Scene<'_>) -> Situation {
        self.situation_of(scene, scene.hit().and_then(Contact::pedestrian_at_ego).unwrap_or(0))
    }

    fn situation_of(&self, scene: &Scene<'_>, number: usize) -> Situation {
        let hit = scene.hit();
        let (ego, pedestrian) = (&scene.world.ego().state, &scene.world.pedestrians[number].state);
        let local = ego.pose.to_local(pedestrian.pose.position());
        let (ahead, aside) = hit.map_or((local.x, local.y), |hit| (hit.ahead, hit.aside));
        let motion = self.motions.get(number);
        Situation {
            v_c: hit.map_or(0.0, |hit| hit.impact_speed),
            bearing: hit.map_or_else(|| libm::atan2(aside, ahead), |hit| hit.bearing),
            distance: (ahead * ahead + aside * aside).sqrt(),
            ahead,
            aside,
            ego_speed: hit.map_or(ego.speed, |hit| hit.impact_speed),
            walking_speed: pedestrian.speed(),
            elapsed: scene.elapsed(),
            facing: {
                let seen = pedestrian.pose.to_local(ego.pose.position());
                libm::atan2(seen.y, seen.x)
            },
            turn: scene.actions.turns[number],
            pace: scene.actions.commands[number].speed,
            miss_distance: if hit.is_some() { 0.0 } else { self.tally.least_gap },
            min_ttc: motion.map_or(0.0, |motion| motion.min_ttc),
            ego_deceleration: motion.map_or(0.0, |motion| motion.ego_deceleration),
            walking_acceleration: motion.map_or(0.0, |motion| motion.walking_acceleration),
            walking_turn: motion.map_or(0.0, |motion| motion.walking_turn),
            ..self.signals.as_ref().map_or_else(Situation::default, |signals| *signals.now())
        }
    }
}

/// The signals that the formulas of a scenario name and that are measured in every tick; `None` if there are none, and no requirements.
fn wanted(scenario: &Scenario) -> Option<Wanted> {
    let end = scenario.episode.end_when.iter();
    let formulas = || scenario.reward.formulas().chain(end.clone());
    let requirements = || scenario.requirements.iter().chain(&*scenario.reward.requirements);
    let wanted = Wanted::new(|id| {
        is_measured(id) && formulas().any(|formula| formula.mentions(&|other| other == id))
            || requirements().any(|each| each.requirement.mentions(&|other| other == id))
    });
    let has_requirements = requirements().next().is_some();
    (has_requirements || wanted != Wanted::default()).then_some(wanted)
}
