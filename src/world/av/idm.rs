use super::crosswalks::{self, CrosswalkKeys};
use super::give_way::GiveWayMemory;
use super::lane_keeping::Demand;
use super::path::HORIZON;
use super::{DrivingMode, DrivingPolicy, Path, Perception, lane_keeping};
use crate::sim::{Control, LightColour};
use base::keys;
use base::seed::Stream;
use road::geometry::{Point, Pose, wrap_angle};

keys! {
    /// The Intelligent Driver Model along its lane, with an emergency brake for actors in its way. It does not see through
    /// buildings.
    pub struct IdmKeys = "idm" {
        /// Share of the speed limit that it wants to drive.
        limit_share: f64 as share() = "0.9",
        /// Time gap that it keeps.
        time_headway: f64 as positive(TIME) = "1.5 s",
        /// Gap that it keeps at rest.
        least_gap: f64 as positive(LENGTH) = "2 m",
        /// Its greatest acceleration.
        acceleration: f64 as positive(ACCELERATION) = "1.5 m/s^2",
        /// Deceleration that it likes.
        comfortable_braking: f64 as positive(ACCELERATION) = "2 m/s^2",
        /// Maximum deceleration of the model, from which its emergency brake computes the stopping distance, too. That brakes fully: less
        /// makes it brake earlier, not more gently.
        max_deceleration: f64 as positive(ACCELERATION) = "8 m/s^2",
        /// Reaction time that its emergency brake allows for, though it has none: a longer one makes it brake
        /// earlier. `actuation_delay` is a true delay.
        reaction_allowance: f64 as non_negative(TIME) = "0.2 s",
        /// How far beside its body its corridor reaches.
        margin: f64 as non_negative(LENGTH) = "0.5 m",
        ..at_crosswalks: CrosswalkKeys,
    }
}

/// The Intelligent Driver Model along its lane, with an emergency brake for road users that enter its corridor.
///
/// Acceleration `a [1 − (v/v₀)⁴ − (s*/s)²]` with `s* = s₀ + max(0, v T + v Δv / (2 √(a b)))`.
///
/// | symbol | key | unit |
/// |---|---|---|
/// | a, b | `acceleration`, `comfortable_braking` | m/s² |
/// | T | `time_headway` | s |
/// | s₀ | `least_gap` | m |
/// | v₀ | share of the limit, less in bends | m/s |
/// | s, Δv | gap to and closing speed with the first road user in the corridor | m, m/s |
///
/// # Source
/// Treiber, Hennecke, Helbing, *Congested traffic states in empirical observations and microscopic simulations*, Phys.
/// Rev. E 62, 2000. The brake is our own: full force when the gap falls below the stopping distance at `max_deceleration`.
#[derive(Debug, Clone)]
pub struct Idm {
    keys: IdmKeys,
    path: Path,
    signs: GiveWayMemory,
    mode: DrivingMode,
}

/// Lateral acceleration in bends (m/s²).
const LATERAL: f64 = 2.0;

/// The first road user, red light or crosswalk in the corridor.
#[derive(Debug, Clone, Copy)]
struct Leader {
    gap: f64,
    speed: f64,
    kind: LeaderKind,
}

/// What a driver follows or stops for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LeaderKind {
    RoadUser,
    RedLight,
    /// With a pedestrian on it or about to use it.
    Crosswalk,
}

impl Idm {
    pub fn new(keys: IdmKeys) -> Self {
        Self { keys, path: Path::default(), signs: GiveWayMemory::default(), mode: DrivingMode::Cruise }
    }

    /// The acceleration of the model (m/s²).
    fn follow(&self, speed: f64, wanted: f64, leader: Option<Leader>) -> f64 {
        let free = (speed / wanted.max(0.1)).min(4.0);
        let free = free * free * free * free;
        let near = leader.map_or(0.0, |leader| {
            let dynamic = speed * self.keys.time_headway
                + speed * (speed - leader.speed)
                    / (2.0 * (self.keys.acceleration * self.keys.comfortable_braking).sqrt());
            let ratio = (self.keys.least_gap + dynamic.max(0.0)) / leader.gap.max(0.1);
            ratio * ratio
        });
        self.keys.acceleration * (1.0 - free - near)
    }

    /// The first of the actors, red lights and crosswalks in the corridor.
    fn leader(&self, perception: &Perception<'_>) -> Option<Leader> {
        let ego = &perception.ego;
        let corridor = ego.half.y + self.keys.margin;
        let chords = Chords::new(&self.path, ego.pose.position());
        let here = ego.pose.position();
        let actors = perception.pedestrians.iter().chain(perception.vehicles);
        // Of the bodies, only one that is nearer than those before it matters.
        let mut nearest = f64::INFINITY;
        let bodies = actors.filter_map(|actor| {
            let (place, within) = (actor.pose.position(), nearest + ego.half.x + actor.half.x);
            let (along, chord) = chords.place(&self.path, place, corridor + actor.half.y, within)?;
            let gap = along - ego.half.x - actor.half.x;
            // Few are in the corridor, and sight takes longer to find out.
            if gap <= -ego.half.x || !perception.in_sight(actor) {
                return None;
            }
            nearest = nearest.min(gap.max(0.0));
            let speed = actor.velocity.dot(&chord.forward());
            Some(Leader { gap: gap.max(0.0), speed: speed.max(0.0), kind: LeaderKind::RoadUser })
        });
        let lights = perception.lights.iter().filter(|light| light.colour == LightColour::Red).filter_map(|light| {
            let line = light.trigger.position();
            if (line - here).norm_squared() > 40.0 * 40.0 {
                return None;
            }
            let (along, chord) = chords.place(&self.path, line, 1.0, f64::INFINITY)?;
            let same_way = wrap_angle(chord.yaw - light.trigger.yaw).abs() < 1.0;
            (same_way && along > 0.0).then_some(Leader {
                gap: (along - ego.half.x + 1.0).max(0.0),
                speed: 0.0,
                kind: LeaderKind::RedLight,
            })
        });
        let yielding = self.keys.at_crosswalks.yields().then(|| crosswalks::gap(perception, &self.path)).flatten();
        let crosswalk = yielding.map(|gap| Leader { gap, speed: 0.0, kind: LeaderKind::Crosswalk });
        bodies.chain(lights).chain(crosswalk).min_by(|a, b| a.gap.total_cmp(&b.gap))
    }
}

/// How far along the path from abeam the ego its points are (m), and the longest way from one to the next (m).
struct Chords {
    along: [f64; HORIZON],
    longest: f64,
}

impl Chords {
    fn new(path: &Path, ego: Point) -> Self {
        let mut places = [0.0; HORIZON];
        // Kept in a register: in memory it would be written for each point.
        let mut longest: f64 = 0.0;
        if let Some(first) = path.points().next() {
            // The path's first point is the nearest to the ego, not the one abeam it.
            let mut along = -first.pose.to_local(ego).x;
            places[0] = along;
            for (place, step) in places[1..].iter_mut().zip(path.steps()) {
                longest = longest.max(step.length);
                along += step.length;
                *place = along;
            }
        }
        Self { along: places, longest }
    }

    /// How far along the path from abeam the ego a place is, and the start of its chord; `None` if it is more than `beside` (m) from the path, or
    /// clearly farther along it than `within` (m).
    fn place(&self, path: &Path, place: Point, beside: f64, within: f64) -> Option<(f64, Pose)> {
        let reach = beside + 1.05 * self.longest;
        let mut number = path.first_near(place, beside, reach);
        while number + 1 < path.points().len() && self.along[number] <= within + self.longest {
            let (last, next) = (&path.point(number).pose, &path.point(number + 1).pose);
            let (chord, offset) = (next.position() - last.position(), place - last.position());
            let away = offset.norm() - reach;
            if away > 0.0 {
                // So many points are too far away, too.
                number += ((away / self.longest) as usize).clamp(1, HORIZON);
                continue;
            }
            let length = chord.norm();
            let share = offset.dot(&chord) / (length * length);
            let aside = chord.perp(&offset) / length;
            // A little overlap closes the wedges at the outside of bends.
            if (-0.05..1.05).contains(&share) && aside.abs() <= beside {
                return Some((self.along[number] + share * length, *last));
            }
            number += 1;
        }
        None
    }
}

impl DrivingPolicy for Idm {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        speed / self.keys.limit_share
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.signs = GiveWayMemory::default();
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.path.advance(perception);
        let speed = perception.ego.speed();
        let braking = self.keys.comfortable_braking;
        let limit = lane_keeping::speed_for_limits(&self.path, perception, self.keys.limit_share, braking);
        let wanted = lane_keeping::speed_for_bends(&self.path, limit, LATERAL, braking);
        // For fewer actors it costs more than it saves.
        if perception.pedestrians.len() + perception.vehicles.len() > 3 {
            self.path.find_straight();
        }
        let leader = self.leader(perception);
        let steer = lane_keeping::steer(&self.path, perception);
        if let Some(leader) = leader.filter(|leader| leader.kind == LeaderKind::RoadUser) {
            let stopping = (speed * speed - leader.speed * leader.speed).max(0.0) / (2.0 * self.keys.max_deceleration);
            if speed > 0.1 && leader.gap <= stopping + speed * self.keys.reaction_allowance + 0.3 {
                self.mode = DrivingMode::EmergencyStop;
                return Control { throttle: 0.0, brake: 1.0, steer };
            }
        }
        let sign = self.signs.next(perception, &self.path);
        let lower = lane_keeping::lower_limit(&self.path, perception, self.keys.limit_share, braking);
        // The model brakes late for a speed that falls along the way.
        let before = |demand: Option<Demand>| demand.map_or(f64::INFINITY, |each| each.acceleration(speed, braking));
        let acceleration = self.follow(speed, wanted, leader).min(before(sign)).min(before(lower));
        self.mode = match leader {
            Some(leader) if acceleration < -0.2 || speed < 0.1 => {
                if leader.kind == LeaderKind::RedLight {
                    DrivingMode::RedLight
                } else {
                    DrivingMode::Yield
                }
            }
            _ if before(sign).is_finite() => DrivingMode::GiveWay,
            _ if wanted < 0.1 => DrivingMode::Arrived,
            _ if wanted < limit - 0.1 => DrivingMode::Turn,
            _ => DrivingMode::Cruise,
        };
        let pedals = perception.blueprint.pedals_for(acceleration.max(-self.keys.max_deceleration), speed);
        // The car is at rest and should not move: hold it.
        let brake = if speed < 0.05 && (acceleration <= 0.0 || wanted < 0.1) { 1.0 } else { pedals.brake };
        Control { throttle: pedals.throttle, brake, steer }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }
}
