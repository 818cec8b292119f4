use super::controller::{CarlaControl, Controller};
use super::decision::Decision;
use super::obstacle::{EgoBody, Here, ObstacleTest};
use super::planner::Planner;
use super::polygon::Corner;
use super::profile::{Profile, ProfileTraits};
use super::red_light::RedLights;
use super::release::{Release, ReleaseTraits};
use super::way_finding::WayFinding;
use base::seed::Stream;
use road::{RoadOption, RoutePoint};
use world::av::{DrivingMode, DrivingPolicy, Perception};
use world::sim::Control;

/// Before a turn the agent stays this far below the limit (km/h).
const TURN_BELOW_LIMIT: f64 = 5.0;
const KMH: f64 = 3.6;

/// Which agent it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AgentConfig {
    /// The release of CARLA that it comes from.
    pub release: Release,
    /// Its driving profile.
    pub profile: Profile,
    /// How it finds its way without a plan.
    pub way: WayFinding,
}

/// CARLA's `BehaviorAgent`.
///
/// Without a plan it finds its own way, according to [`AgentConfig::way`].
///
/// Its speed limit is [`Perception::carla_limit`]: 30 km/h before the first speed sign, then that of the last sign. CARLA ignores limits of lanes
/// and road types. Stop and yield signs do not stop it.
///
/// # Source
/// CARLA `Vehicle/WheeledVehicleAIController.h`, `Traffic/SpeedLimitComponent.cpp`; `agents/navigation/behavior_agent.py` checks red lights alone.
#[derive(Debug, Clone)]
pub struct BehaviorAgent {
    config: AgentConfig,
    traits: ReleaseTraits,
    profile: ProfileTraits,
    planner: Planner,
    controller: Controller,
    red_lights: RedLights,
    route: Vec<Corner>,
    mode: DrivingMode,
    decision: Decision,
}

/// The agent's intention after it has checked its surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Intent {
    Stop(DrivingMode),
    /// Towards a speed (km/h).
    Drive(DrivingMode, f64),
}

impl BehaviorAgent {
    /// Makes an agent without a way until [`DrivingPolicy::reset`].
    pub fn new(config: AgentConfig) -> Self {
        Self {
            config,
            traits: config.release.traits(),
            profile: config.profile.traits(),
            planner: Planner::default(),
            controller: Controller::default(),
            red_lights: RedLights::default(),
            route: Vec::with_capacity(128),
            mode: DrivingMode::default(),
            decision: Decision::default(),
        }
    }

    pub fn config(&self) -> &AgentConfig {
        &self.config
    }

    /// Gives it a route instead of its own way; at the route's end it brakes and stays. Call it after
    /// [`DrivingPolicy::reset`].
    pub fn set_plan(&mut self, route: impl IntoIterator<Item = RoutePoint>) {
        self.planner.follow(&self.traits, route);
    }

    /// The planned route ahead; for the oldest release without the five points in its buffer.
    pub fn plan(&self) -> impl ExactSizeIterator<Item = &RoutePoint> {
        self.planner.points().map(|planned| &planned.point)
    }

    /// The reasons for its last [`DrivingPolicy::drive`].
    pub fn decision(&self) -> &Decision {
        &self.decision
    }

    fn arrive(&mut self) -> CarlaControl {
        self.mode = DrivingMode::Arrived;
        CarlaControl { brake: 1.0, ..CarlaControl::default() }
    }

    /// Checks its surroundings, in CARLA's order. `limit` and `speed` in km/h.
    fn intend(&mut self, perception: &Perception<'_>, ego: &EgoBody, limit: f64, speed: f64) -> Intent {
        let mut known = None;
        let mut here = || *known.get_or_insert_with(|| Here::look_up(perception.town, perception.place()));
        if self.red_lights.stop(&self.traits, perception, ego, &mut here) {
            self.decision.red_light = true;
            return Intent::Stop(DrivingMode::RedLight);
        }
        let cruise = self.profile.max_speed.min(limit - self.profile.below_limit);
        let reach = self.profile.min_reach.max(limit / 3.0);
        // In most ticks no road user is near, so no look-up is needed.
        let mut everybody = perception.pedestrians.iter().chain(perception.vehicles);
        if everybody.any(|actor| ego.may_reach(actor, reach))
            && let Some(here) = here()
        {
            self.route.clear();
            let mut test = ObstacleTest {
                traits: &self.traits,
                perception,
                ego,
                here: &here,
                planner: &self.planner,
                reach,
                route: &mut self.route,
            };
            if let Some(hit) = test.find_walker() {
                self.decision.walker = Some(hit.distance);
                if hit.gap < self.profile.braking_distance {
                    return Intent::Stop(DrivingMode::EmergencyStop);
                }
            }
            if let Some((hit, vehicle)) = test.find_vehicle() {
                self.decision.vehicle = Some(hit.distance);
                if hit.gap < self.profile.braking_distance {
                    return Intent::Stop(DrivingMode::EmergencyStop);
                }
                let target = self.profile.following_speed(hit.gap, speed, vehicle.speed() * KMH).min(cruise);
                return Intent::Drive(DrivingMode::Follow, target);
            }
        }
        // The queue is in the state that the planner left in the last tick.
        let steps = (limit / 10.0).max(0.0) as usize;
        let turn_ahead = self.planner.ahead(steps).is_some_and(|planned| {
            planned.point.is_junction && matches!(planned.point.option, RoadOption::Left | RoadOption::Right)
        });
        if turn_ahead && self.traits.slows_for_turns {
            return Intent::Drive(DrivingMode::Turn, self.profile.max_speed.min(limit - TURN_BELOW_LIMIT));
        }
        Intent::Drive(DrivingMode::Cruise, cruise)
    }

    /// Runs the planner once; `None` at the end of the route.
    fn follow_route(
        &mut self,
        perception: &Perception<'_>,
        ego: &EgoBody,
        speed: f64,
        target_speed: f64,
    ) -> Option<CarlaControl> {
        let target = self.planner.run(&self.traits, perception.town, ego.centre, speed / KMH)?;
        Some(self.controller.run(&self.traits, &perception.ego.pose, target, speed, target_speed))
    }
}

impl DrivingPolicy for BehaviorAgent {
    /// Its profile subtracts from the limit, and has a maximum speed.
    fn speed_limit_for(&self, speed: f64) -> f64 {
        speed + self.profile.below_limit / KMH
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        let (start, lanes) = (perception.start_lane(), perception.route);
        self.planner.begin(&self.traits, self.config.way, perception.town, start, lanes, stream);
        self.controller.reset();
        self.red_lights.reset(perception);
        self.mode = DrivingMode::default();
        self.decision = Decision::default();
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let ego = EgoBody::new(&perception.ego);
        let speed = perception.ego.speed() * KMH;
        // The server gives the limit in 32 bits; that also turns 8.33 m/s into 30 km/h.
        let limit = f64::from((perception.carla_limit() * KMH) as f32);
        self.decision = Decision::default();
        let intent = self.intend(perception, &ego, limit, speed);
        let (control, target_speed) = match intent {
            Intent::Stop(mode) => {
                self.mode = mode;
                self.decision.emergency = true;
                // The planner does not run, and the wheels are straightened.
                (CarlaControl { throttle: 0.0, brake: self.traits.emergency_brake, steer: 0.0 }, limit)
            }
            Intent::Drive(mode, target_speed) => {
                self.mode = mode;
                let mut control = self.follow_route(perception, &ego, speed, target_speed);
                if self.traits.repeats_planner && mode != DrivingMode::Cruise {
                    control = self.follow_route(perception, &ego, speed, target_speed);
                }
                (control.unwrap_or_else(|| self.arrive()), target_speed)
            }
        };
        self.decision.target_speed = target_speed / KMH;
        self.controller.overruled(&self.traits, control.steer);
        Control { throttle: control.throttle, brake: control.brake, steer: -control.steer }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.planner.reseed(stream);
    }
}
