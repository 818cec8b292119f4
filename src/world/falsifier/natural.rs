use rand::RngExt;

use super::{RecordedWalking, WalkPolicy};
use crate::env::Scene;
use crate::geometry::wrap_angle;
use crate::sim::WalkCommand;
use base::seed::Stream;
use base::{choice, keys};

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
    stream: Option<Stream>,
    /// One for each pedestrian of the episode.
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
        Self { gaps: keys.gaps, ..Self::new(walking, keys.heed) }
    }

    /// Makes one that waits for recorded gaps; `heed` is the probability that a pedestrian waits for a gap.
    pub fn new(walking: RecordedWalking, heed: f64) -> Self {
        Self { walking, heed, gaps: Gaps::Recorded, stream: None, walks: Vec::new() }
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
        let (ego, here) = (&scene.world.ego().state.pose, scene.world.pedestrians[pedestrian].state.pose.position());
        let aside = ego.to_local(here).y;
        let across = ego.left() * if aside > 0.0 { -1.0 } else { 1.0 };
        let across = libm::atan2(across.y, across.x);
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
    /// Whether its gap is large enough to set off.
    fn may_go(&self, scene: &Scene<'_>, pedestrian: usize) -> bool {
        let world = scene.world;
        let (ego, person) = (world.ego(), &world.pedestrians[pedestrian]);
        let place = ego.state.pose.to_local(person.state.pose.position());
        let way = place.x - ego.blueprint.half_length;
        if way <= 0.0 || ego.state.speed <= 0.1 {
            return true;
        }
        let aside = ego.blueprint.half_width + person.body.radius;
        if place.y.abs() < aside {
            return true;
        }
        // It has crossed when it is out of the car's width.
        let beyond = place.y.abs() + aside;
        way / ego.state.speed - beyond / self.preferred >= self.gap
    }
}

impl WalkPolicy for Natural {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
        self.walks.clear();
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let rule = &scene.scenario.episode;
        let seconds = f64::from(rule.hold) * rule.tick;
        for (pedestrian, command) in commands.iter_mut().enumerate() {
            if self.walks.len() <= pedestrian {
                let walk = self.first(scene, pedestrian);
                self.walks.push(walk);
            }
            let walk = &mut self.walks[pedestrian];
            let stream = self.stream.as_mut().expect("an episode has started");
            walk.walking = match walk.walking {
                None if !walk.may_go(scene, pedestrian) => None,
                None => Some((walk.preferred, 0.0)),
                Some((speed, turned)) => {
                    let (faster, turn) = self.walking.change(speed - walk.preferred, turned, seconds, stream);
                    Some(((speed + faster).max(0.0), turned + turn))
                }
            };
            let (low, high) = scene.scenario.cast.pedestrians[pedestrian].action.speed;
            let (speed, turned) = walk.walking.unwrap_or((low, 0.0));
            *command = WalkCommand { heading: wrap_angle(walk.across + turned), speed: speed.clamp(low, high) };
        }
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
