use super::carla_frame::{Cone, Direction, Location};
use super::obstacle::{EgoBody, Here};
use super::release::{RedLightRule, ReleaseTraits};
use road::RoadIndex;
use world::av::{Light, Perception};
use world::sim::LightColour;

/// A light counts within this distance of the ego's centre (m).
const REACH: f64 = 5.0;

/// The driving lane under a light's trigger box.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Approach {
    location: Location,
    forward: Direction,
    road: RoadIndex,
}

impl Approach {
    fn look_up(perception: &Perception<'_>, light: &Light) -> Option<Self> {
        let lane =
            Here::look_up(perception.town, perception.town.place_from(perception.place(), light.trigger.position()))?;
        Some(Self { location: lane.location, forward: Direction::new(&lane.pose), road: lane.waypoint.road })
    }
}

/// The red-light step and its memory.
#[derive(Debug, Clone, Default)]
pub(super) struct RedLights {
    approaches: Vec<Option<Approach>>,
    kept: Option<usize>,
    passed: Option<usize>,
}

impl RedLights {
    /// Forgets the last episode and looks up where the lights are.
    pub fn reset(&mut self, perception: &Perception<'_>) {
        self.kept = None;
        self.passed = None;
        self.look_up(perception);
    }

    /// Whether the agent must stop at a red light.
    pub fn stop(
        &mut self,
        traits: &ReleaseTraits,
        perception: &Perception<'_>,
        ego: &EgoBody,
        here: impl FnOnce() -> Option<Here>,
    ) -> bool {
        match traits.red_light {
            RedLightRule::Affected => self.affected(perception, here),
            RedLightRule::OwnTest => self.ahead(perception, ego, here),
        }
    }

    /// A light that was red when the ego was already in the junction counts as passed, and is ignored until it no longer affects the ego.
    fn affected(&mut self, perception: &Perception<'_>, here: impl FnOnce() -> Option<Here>) -> bool {
        let light = perception.affecting_light;
        let red =
            light.and_then(|index| perception.lights.get(index)).is_some_and(|light| light.colour == LightColour::Red);
        if red {
            if !here().is_some_and(|here| here.in_junction) {
                if self.passed != light {
                    return true;
                }
            } else {
                self.passed = light;
            }
        }
        if self.passed != light {
            self.passed = None;
        }
        false
    }

    /// A light once found is remembered while it is red.
    fn ahead(&mut self, perception: &Perception<'_>, ego: &EgoBody, here: impl FnOnce() -> Option<Here>) -> bool {
        let red = |index: usize| perception.lights.get(index).is_some_and(|light| light.colour == LightColour::Red);
        if self.kept.is_some_and(red) {
            return true;
        }
        self.kept = None;
        if self.approaches.len() != perception.lights.len() {
            self.look_up(perception);
        }
        let near = |approach: &Approach| approach.location.distance(ego.centre) <= REACH;
        let mut candidates = (0..self.approaches.len())
            .filter_map(|index| Some((index, self.approaches[index]?)))
            .filter(|(index, approach)| red(*index) && near(approach))
            .peekable();
        if candidates.peek().is_none() {
            return false;
        }
        let Some(here) = here() else { return false };
        let (x, y) = Direction::new(&here.pose).widened();
        let cone = Cone { tip: ego.centre, heading: ego.forward.widened(), reach: REACH, cosine: 0.0 };
        let found = candidates.find(|(_, approach)| {
            let (light_x, light_y) = approach.forward.widened();
            approach.road == here.waypoint.road && x * light_x + y * light_y >= 0.0 && cone.holds(approach.location)
        });
        self.kept = found.map(|(index, _)| index);
        self.kept.is_some()
    }

    fn look_up(&mut self, perception: &Perception<'_>) {
        self.approaches.clear();
        self.approaches.extend(perception.lights.iter().map(|light| Approach::look_up(perception, light)));
    }
}
