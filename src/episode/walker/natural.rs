use rand::RngExt;

use super::recorded_walking::PREFERRED;
use super::social_force::among_others;
use super::{RecordedWalking, WalkPolicy};
use crate::simulation::pursuit::across;
use crate::{Destination, Pair, Scene};
use base::seed::Stream;
use base::{choice, keys};
use road::geometry::{Point, Vector, wrap_angle};
use world::sim::{PedestrianBody, VehicleBlueprint, VehicleState, WalkCommand};

choice! {
    /// A recording of walking.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Recording {
        Dut = "dut",
        Vru = "vru",
    }
}

choice! {
    /// How large the gap before the car must be for a pedestrian that waits.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Gaps {
        Recorded = "recorded",
        Hcm = "hcm",
        HcmObserved = "hcm_observed",
    }
}

choice! {
    /// What keeps a pedestrian away from others.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Forces {
        Social = "social",
    }
}

/// Time that the Highway Capacity Manual adds to the time for the way (s), setting off and clearance at the end: what it proposes for designs, and what it
/// observed on average.
///
/// # Source
/// Highway Capacity Manual, 7th edition, equation 20-76 (critical headway of a pedestrian at an uncontrolled crossing: way by speed, and this time) and
/// exhibit 20-26, as two public implementations write them, which agree; the manual itself is not public.
const HCM_GAP: f64 = 3.0;
const HCM_OBSERVED_GAP: f64 = 0.0;

keys! {
    /// Crosses before the car as recorded pedestrians do. Its speed, its accepted gap, and its changes of speed and direction
    /// are drawn from their distributions.
    pub struct NaturalKeys = "natural" {
        /// Recording of the changes of speed and direction within a second: DUT (beside cars on a campus), or VRU (an urban
        /// junction), where they are twice as large.
        changes: Recording = "dut",
        /// Share of the pedestrians that wait until the gap before the car is large enough for them; the others set off at
        /// once.
        heed: f64 as share() = "100 percent",
        /// The time that must be left between the pedestrian, once out of the car's width, and the car: as recorded ones accepted it (DUT; median 6.4 s),
        /// or that of the Highway Capacity Manual's critical headway: 3 s as for designs (`hcm`), or 0 s, its observed mean (`hcm_observed`).
        gaps: Gaps = "recorded",
        /// The point to which it walks, and where it stays; `bus_stop` is the stop nearest to its start. Without it, it walks across the way of the car.
        /// It waits for a gap only if the car's way is between.
        destination: Option<Destination>,
        /// What keeps it away from other pedestrians, walls and cars while it walks: `social` forces, as Helbing and Molnár published them (1995). Without
        /// the key nothing does.
        forces: Option<Forces>,
    }
}

/// A pedestrian that crosses the road in front of the car as recorded ones walk: the natural baseline beside searches.
///
/// At the start of an episode it draws its preferred speed and its accepted gap. It crosses at a right angle to the car, away from the side
/// on which it stands. It sets off when the car would come to its line later than itself by at least the accepted gap, when the car has
/// passed, when the car stands, or when it is in the way of the car. A heedless pedestrian sets off at once. While it walks, its speed and its direction change with every
/// decision. The sizes of the changes are drawn from the recorded distributions. A change leads back towards the preferred speed and
/// towards the straight line with a probability that grows with the departure from it, so neither of them drifts.
///
/// Commands are cut to the speeds that the scenario allows. A gait that is slower than the changes weakens them.
#[derive(Debug, Clone)]
pub struct Natural {
    walking: RecordedWalking,
    /// The probability that a pedestrian waits for a gap.
    heed: f64,
    gaps: Gaps,
    destination: Option<Destination>,
    forces: Option<Forces>,
    stream: Option<Stream>,
    /// One for each pedestrian that it moves.
    walks: Vec<Walk>,
}

/// The walk of one pedestrian.
#[derive(Debug, Clone, Copy)]
struct Walk {
    /// Speed about which it walks (m/s).
    preferred: f64,
    /// The time that it wants to have crossed the car's middle line before the car comes (s); −∞ for a heedless one.
    gap: f64,
    /// The direction straight across (rad).
    across: f64,
    /// Its speed (m/s) and its direction from `across` (rad), once it has set off.
    walking: Option<(f64, f64)>,
}

impl Natural {
    pub fn from_keys(keys: NaturalKeys) -> Self {
        let walking = match keys.changes {
            Recording::Dut => RecordedWalking::DUT,
            Recording::Vru => RecordedWalking::VRU,
        };
        Self { gaps: keys.gaps, destination: keys.destination, forces: keys.forces, ..Self::new(walking, keys.heed) }
    }

    /// Makes one that waits for recorded gaps; `heed` is the probability that a pedestrian waits for a gap.
    pub fn new(walking: RecordedWalking, heed: f64) -> Self {
        let (destination, forces) = (None, None);
        Self { walking, heed, gaps: Gaps::Recorded, destination, forces, stream: None, walks: Vec::new() }
    }

    /// The walk of a pedestrian that has just appeared.
    fn first(&mut self, scene: &Scene<'_>, pedestrian: usize) -> Walk {
        let stream = self.stream.as_mut().expect("an episode has started");
        let preferred = self.walking.speed(stream);
        let recorded = self.walking.accepted_gap(stream);
        let gap = match self.gaps {
            Gaps::Recorded => recorded,
            Gaps::Hcm => HCM_GAP,
            Gaps::HcmObserved => HCM_OBSERVED_GAP,
        };
        let heeds = stream.random::<f64>() < self.heed;
        let here = scene.world.pedestrians[pedestrian].state.pose.position();
        let across = across(&scene.world.ego().state.pose, here);
        Walk { preferred, gap: if heeds { gap } else { f64::NEG_INFINITY }, across, walking: None }
    }
}

impl Default for Natural {
    /// Pedestrians as in the recording DUT, who all wait for a gap.
    fn default() -> Self {
        Self::new(RecordedWalking::DUT, 1.0)
    }
}

impl Walk {
    /// Whether its gap is large enough to set off, or it does not cross the way of the car.
    fn may_go(&self, scene: &Scene<'_>, pedestrian: usize, destination: Option<Point>) -> bool {
        let (ego, person) = (scene.world.ego(), &scene.world.pedestrians[pedestrian]);
        let place = person.state.pose.position();
        let aside = |place: Point| ego.state.pose.to_local(place).y;
        if destination.is_some_and(|there| aside(there) * aside(place) > 0.0) {
            return true;
        }
        gap(&ego.state, &ego.blueprint, &person.body, place, self.preferred).is_none_or(|gap| gap >= self.gap)
    }
}

/// The time that is left between a pedestrian who sets off now at a speed (m/s), once out of the car's width, and the car (s). `None` if it needs no
/// gap: the car has passed or stands, or the pedestrian is in its way.
fn gap(
    ego: &VehicleState,
    blueprint: &VehicleBlueprint,
    body: &PedestrianBody,
    place: Point,
    speed: f64,
) -> Option<f64> {
    let place = ego.pose.to_local(place);
    let way = place.x - blueprint.half_length;
    let aside = blueprint.half_width + body.radius;
    if way <= 0.0 || ego.speed <= 0.1 || place.y.abs() < aside {
        return None;
    }
    // It has crossed when it is out of the car's width.
    Some(way / ego.speed - (place.y.abs() + aside) / speed)
}

/// Logarithm of the likelihood of decisions of the pedestrian of an episode among natural pedestrians of the recording DUT, over that of the likeliest walk: 0 at most.
///
/// The likeliest one accepts its gap surely, walks straight across at the mean speed and never changes. A first heading that is not straight across
/// counts as a change of heading within a second. A pedestrian slower than any preferred speed waits, until it has set off.
pub fn log_likelihood(pair: &Pair<'_>, decisions: &[WalkCommand]) -> f64 {
    let walking = RecordedWalking::DUT;
    let rule = &pair.scenario.episode;
    let seconds = f64::from(rule.hold) * rule.tick;
    let Some(first) = pair.walking.first() else { return 0.0 };
    let across = across(&pair.frame(0).ego.pose, first.pose.position());
    let (mut log, mut refused) = (0.0, 0.0_f64);
    // The preferred speed, then the speed and the direction of the last decision.
    let mut walk: Option<(f64, f64, f64)> = None;
    for (number, command) in decisions.iter().enumerate() {
        let turned = wrap_angle(command.heading - across);
        let frame = pair.frame((number * rule.hold as usize).min(pair.len() - 1));
        let place = frame.pedestrian.pose.position();
        let accepted = |speed: f64| {
            gap(&frame.ego, pair.blueprint, pair.body, place, speed).map_or(1.0, |gap| walking.accepts(gap))
        };
        match walk {
            None if command.speed < PREFERRED.0 => refused = refused.max(accepted(walking.speed.0)),
            None => {
                let chance = (accepted(command.speed) - refused).max(MIN_CHANCE);
                log += libm::log(chance) + walking.log_speed(command.speed);
                log += walking.log_change((0.0, turned), (0.0, 0.0), 1.0);
                walk = Some((command.speed, command.speed, turned));
            }
            Some((preferred, speed, direction)) => {
                let changes = (command.speed - speed, wrap_angle(turned - direction));
                log += walking.log_change(changes, (speed - preferred, direction), seconds);
                walk = Some((preferred, command.speed, turned));
            }
        }
    }
    log
}

/// Minimum probability that a gap is accepted: the recorded ones say nothing below it.
const MIN_CHANCE: f64 = 1e-6;

impl WalkPolicy for Natural {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
        self.walks.clear();
    }

    fn reseed(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let rule = &scene.scenario.episode;
        let seconds = f64::from(rule.hold) * rule.tick;
        for (place, (pedestrian, role)) in scene.controlled().enumerate() {
            if self.walks.len() <= place {
                let walk = self.first(scene, pedestrian);
                self.walks.push(walk);
            }
            let destination = self.destination.and_then(|destination| scene.place_of(destination, pedestrian));
            let walk = &mut self.walks[place];
            let stream = self.stream.as_mut().expect("an episode has started");
            walk.walking = match walk.walking {
                None if !walk.may_go(scene, pedestrian, destination) => None,
                None => Some((walk.preferred, 0.0)),
                Some((speed, turned)) => {
                    let (faster, turn) = self.walking.change(speed - walk.preferred, turned, seconds, stream);
                    Some(((speed + faster).max(0.0), turned + turn))
                }
            };
            let (low, high) = role.action.speed;
            let here = scene.world.pedestrians[pedestrian].state.pose.position();
            let way = destination.map(|there| there - here);
            let straight = way.map_or(walk.across, |way| libm::atan2(way.y, way.x));
            let (speed, turned) = walk.walking.unwrap_or((low, 0.0));
            // It does not walk beyond its destination.
            let mut speed = way.map_or(speed, |way| speed.min(way.norm() / seconds));
            let mut heading = wrap_angle(straight + turned);
            if self.forces.is_some() && walk.walking.is_some() {
                let wanted = Vector::new(libm::cos(heading), libm::sin(heading)) * speed;
                let velocity = among_others(scene, pedestrian, wanted, seconds);
                (heading, speed) = (libm::atan2(velocity.y, velocity.x), velocity.norm());
            }
            commands[pedestrian] = WalkCommand { heading, speed: speed.clamp(low, high) };
        }
    }

    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
