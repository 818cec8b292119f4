use super::crosswalks::CrosswalkKeys;
use super::guarded::{Guarded, LaneGuard};
use super::lane_follower::{Intent, LaneKeys};
use super::reference_drivers::{BrakeProfile, DelayedBrake, Gate, OwnMotion, ReferenceDriver, Threat};
use super::route_trace::RouteTrace;
use super::{Actor, DrivingMode, Perception};
use crate::sim::{ActorId, Control};
use base::keys;

keys! {
    /// The careful human, with UN R157's times and brake, who decides in a verdict what was preventable, as a driver. Weaken it to see what the verdict
    /// makes of it.
    pub struct CarefulHumanKeys = "careful_human" {
        ..lane: LaneKeys,
        /// Time for which it evaluates a risk before it reacts.
        evaluation: f64 as non_negative(TIME) = "0.4 s",
        /// Time from none to full braking.
        ramp: f64 as non_negative(TIME) = "0.6 s",
        /// How far it sees a pedestrian; 0 m for a driver that sees no pedestrian.
        range: f64 as non_negative(LENGTH) = "200 m",
        ..at_crosswalks: CrosswalkKeys,
    }
}

/// The careful human of the verdicts as a driver under test: UN R157's, at the gate of [`DelayedBrake`].
///
/// It drives its lane, notices a pedestrian that is on course into it when the gate opens, brakes after its evaluation and its reaction, and goes on
/// once no pedestrian is on course or in its path. Somebody for whom it has braked is evaluated as long as it sees them: they may turn. Where the reference knows what the recorded car did next, it does not; so it notices a pedestrian
/// within 0.2 m and 0.1 s of the gate, and for any push on the accelerator that it may want.
///
/// # Source
/// UN R157, annex 3: 0.4 s of evaluation, 0.75 s of reaction, 0.6 s to 0.774 g. What it does at rest is our own.
#[derive(Debug, Clone)]
pub struct CarefulHuman {
    brake: DelayedBrake,
    /// How far ahead of the bumper it sees a pedestrian (m).
    range: f64,
    /// Time for which it evaluates a risk (s).
    evaluation: f64,
    /// The pedestrians that it notices now.
    noticed: Vec<ActorId>,
    /// Those for whom it has braked and whom it has seen ever since.
    watched: Vec<ActorId>,
}

/// Time from the end of its evaluation until it begins to brake (s), and its full braking (m/s²): 0.774 g.
const REACTION: f64 = 0.75;
const FULL_BRAKING: f64 = 7.593;
/// How much farther to the side (m) and ahead in time (s) than the reference it looks.
const ASIDE: f64 = 0.2;
const EARLIER: f64 = 0.1;
/// Lengths of its lane after which it looks straight ahead, as the verdict does after the end of the path that the car drove (m).
const STRAIGHT: [f64; 7] = [f64::INFINITY, 0.0, 3.0, 6.0, 10.0, 15.0, 22.0];
/// The accelerations that it may want within the next two seconds (m/s²).
const PUSHES: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];
/// At rest it waits for a pedestrian that is on course or in its path, and that it would reach within this time (s).
const MAX_TIME_TO_COLLISION: f64 = 5.0;

impl CarefulHuman {
    pub fn new(keys: CarefulHumanKeys) -> Guarded<Self> {
        let wait = keys.evaluation + REACTION;
        let profile = BrakeProfile { wait, ramp: keys.ramp, full: FULL_BRAKING };
        let brake = DelayedBrake::new(Some(Gate::CAREFUL), profile);
        let human =
            Self { brake, range: keys.range, evaluation: keys.evaluation, noticed: Vec::new(), watched: Vec::new() };
        Guarded::new(human, keys.lane, keys.at_crosswalks)
    }

    /// A pedestrian in the frame of its lane, which goes straight on after some length (m), after this time (s).
    fn threat(
        &self,
        (trace, perception): (&RouteTrace, &Perception<'_>),
        actor: &Actor,
        straight: f64,
        after: f64,
    ) -> Option<Threat> {
        let ego = &perception.ego;
        let actor = trace.locate_straight_after(straight, actor)?;
        let place = actor.place + actor.velocity * after;
        let gap = place.x - ego.speed() * after - ego.half.x - actor.reach.x;
        let side = if place.y > 0.0 { 1.0 } else { -1.0 };
        let threat = Threat {
            gap,
            length: 2.0 * actor.reach.x,
            offset: place.y.abs(),
            reach: ego.half.y + actor.reach.y + ASIDE,
            along: actor.velocity.x,
            towards: -side * actor.velocity.y,
        };
        (gap.max(0.0) < self.range && gap > -2.0 * (ego.half.x + actor.reach.x)).then_some(threat)
    }

    /// Looks which pedestrians it notices in this tick.
    fn look(&mut self, trace: &RouteTrace, perception: &Perception<'_>) {
        let mut noticed = std::mem::take(&mut self.noticed);
        noticed.clear();
        let length = 2.0 * perception.ego.half.x;
        let speed = perception.ego.speed();
        let wants_more = speed < perception.speed_limit;
        let owns = PUSHES.map(|push| if wants_more { push } else { 0.0 });
        let brake = perception.blueprint.greatest_deceleration();
        let owns = owns.map(|intended| OwnMotion { speed, acceleration: 0.0, intended, length, brake });
        let notices = |own: &OwnMotion, threat: &Threat| {
            let is_awaited = own.stands()
                && threat.time_to_collision(own) <= MAX_TIME_TO_COLLISION
                && (threat.aside() <= 0.0 || threat.is_on_course(own));
            is_awaited || self.brake.notices(own, threat)
        };
        let is_noticed = |actor: &&Actor| {
            let times = || [0.0, perception.dt, EARLIER].into_iter();
            let views = STRAIGHT.into_iter().flat_map(|straight| times().map(move |after| (straight, after)));
            let mut threats =
                views.filter_map(|(straight, after)| self.threat((trace, perception), actor, straight, after));
            threats.any(|threat| owns.iter().any(|own| notices(own, &threat)))
        };
        let seen = perception.pedestrians.iter().filter(|actor| perception.in_sight(actor));
        noticed.extend(seen.filter(is_noticed).map(|actor| actor.id));
        self.noticed = noticed;
    }
}

impl LaneGuard for CarefulHuman {
    fn reset(&mut self) {
        self.brake.begin();
        self.watched.clear();
    }

    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode) {
        let stands = perception.ego.speed() <= OwnMotion::STANDING;
        let is_seen =
            |id: &ActorId| perception.pedestrians.iter().any(|actor| actor.id == *id && perception.in_sight(actor));
        self.watched.retain(is_seen);
        self.look(trace, perception);
        if stands && self.noticed.is_empty() {
            self.brake.begin();
        }
        if self.noticed.iter().any(|id| self.watched.contains(id)) {
            self.brake.skip(self.evaluation);
        }
        let Some(braking) = self.brake.next(!self.noticed.is_empty(), stands, perception.dt) else {
            return (intent.control(intent.acceleration, perception), intent.mode);
        };
        self.watched.extend_from_slice(&self.noticed);
        self.watched.sort_unstable();
        self.watched.dedup();
        let control = match stands {
            true => Control { steer: intent.steer, ..Control::FULL_BRAKE },
            false => intent.control(intent.acceleration.min(-braking), perception),
        };
        (control, DrivingMode::EmergencyStop)
    }
}
