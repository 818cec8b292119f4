use super::ExportError;
use episode::{Outcome, Scenario, Trace};
use road::geometry::{OrientedBox, Pose, Vector, wrap_angle};
use road::{LaneFilter, Place, Town, TrafficLight};
use verdict::Verdict;
use world::sim::{ActorId, LightColour, PedestrianBody, VehicleBlueprint, VehicleState};

/// The height of a car (m); the world is flat, so its cars have none.
///
/// # Source
/// Dumps of a running CARLA 0.9.1x: the box of `vehicle.tesla.model3`.
pub(super) const CAR_HEIGHT: f64 = 1.488;

/// The height of obstacles (m), which have none in the simulator: they hide a pedestrian, and a driver's eyes are lower.
pub(super) const OBSTACLE_HEIGHT: f64 = 3.0;

/// The share of the largest square that does not graze a car.
///
/// # Source
/// Measured with esmini 3.6 in two failures: it still finds a touch at 0.96 of that square, and none at 0.94.
const GRAZE: f64 = 0.94;

/// An episode that was repeated: the input of every exporter.
#[derive(Debug, Clone, Copy)]
pub struct Episode<'a> {
    /// Its name, `RUN:EPISODE`.
    pub name: &'a str,
    /// The controller, the place and the driver, in words.
    pub title: &'a str,
    /// The logical scenario.
    pub scenario: &'a Scenario,
    /// The track of each actor.
    pub trace: &'a Trace,
    pub outcome: &'a Outcome,
    /// The verdict of the reference drivers; `None` without a collision.
    pub verdict: Option<&'a Verdict>,
    /// Why the driver failed, in a sentence; `None` if that is not known.
    pub cause: Option<&'a str>,
}

/// The shape of an actor.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape<'a> {
    Vehicle(&'a VehicleBlueprint),
    Pedestrian(&'a PedestrianBody),
}

/// An actor after a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    /// The middle of its box.
    pub pose: Pose,
    /// The heading without jumps: it differs from that of the tick before by at most π (rad).
    pub heading: f64,
    /// Velocity (m/s).
    pub velocity: Vector,
    /// Height of the ground (m): of a car the mean of those under its axles.
    pub ground: f64,
    /// Rotation about the axis to the left (rad): positive where the nose of a car is lower than its rear.
    pub pitch: f64,
}

/// An actor with its track.
#[derive(Debug, Clone)]
pub(super) struct Actor<'a> {
    pub id: ActorId,
    /// Its role in the cast, with a number where others have it, too: `ego`, `child`, `crowd`, `crowd_2`, ….
    pub name: String,
    pub shape: Shape<'a>,
    /// Whether the ego has touched it before the touch that counts: it lies there.
    pub is_struck: bool,
    /// At the start, and after each tick; never empty.
    pub track: Vec<Motion>,
}

impl<'a> Episode<'a> {
    /// All actors: the ego, the other vehicles, the pedestrians.
    pub(super) fn actors(&self) -> Vec<Actor<'a>> {
        let Self { scenario, trace, .. } = *self;
        // ScenarioRunner knows the ego by this name.
        let mut taken = vec!["hero".to_owned()];
        let names = scenario.cast.actors().map(|actor| {
            let role = scenario.cast.name(actor);
            let other = (2..).map(|number| format!("{role}_{number}"));
            let mut names = std::iter::once(role.to_string()).chain(other);
            let name = names.find(|name| !taken.contains(name)).unwrap_or_default();
            taken.push(name.clone());
            name
        });
        let vehicles = scenario.cast.vehicles.iter().enumerate().map(|(number, role)| {
            let states = trace.vehicle(number).iter().map(|frame| {
                let VehicleState { pose, speed, ground, .. } = frame.state;
                (pose, pose.forward() * speed, ground)
            });
            let track = track(&scenario.town, states, role.blueprint.wheelbase);
            (ActorId::Vehicle(number as u8), Shape::Vehicle(&role.blueprint), track)
        });
        let pedestrians = scenario.cast.pedestrians.iter().enumerate().map(|(number, role)| {
            let states = trace.pedestrian(number).iter().map(|state| (state.pose, state.velocity, state.ground));
            let track = track(&scenario.town, states, 0.0);
            (ActorId::Pedestrian(number as u8), Shape::Pedestrian(&role.body), track)
        });
        let all = vehicles.chain(pedestrians).zip(names);
        let is_struck = |id| match id {
            ActorId::Pedestrian(number) => !trace.is_present(number.into(), self.ticks()),
            ActorId::Vehicle(_) => false,
        };
        all.map(|((id, shape, track), name)| Actor { id, name, shape, is_struck: is_struck(id), track }).collect()
    }

    /// The pedestrian that the verdict is about: the one that the ego touched, or the first: its place among [`Episode::actors`].
    pub(super) fn main_pedestrian(&self) -> usize {
        let struck = self.trace.contact().and_then(|contact| contact.pedestrian_at_ego()).unwrap_or(0);
        self.scenario.cast.vehicles.len() + struck
    }

    /// The traffic lights that work.
    pub(super) fn lights(&self) -> &'a [TrafficLight] {
        if self.trace.lights().is_some() { &self.scenario.town.traffic_lights } else { &[] }
    }

    /// The colours of a traffic light from the start of the episode on, each with its number of ticks. They repeat after the last one; a
    /// period that is not a whole number of ticks is rounded to one.
    pub(super) fn phases(&self, light: &TrafficLight) -> Vec<(LightColour, usize)> {
        let mut phases: Vec<(LightColour, usize)> = Vec::new();
        let Some(clock) = self.trace.lights() else { return phases };
        for tick in 0..self.ticks_in(clock.period(light)) {
            let colour = clock.after(tick as f64 * self.dt()).colour(light);
            match phases.last_mut().filter(|(last, _)| *last == colour) {
                Some((_, ticks)) => *ticks += 1,
                None => phases.push((colour, 1)),
            }
        }
        phases
    }

    /// The number of ticks in a time (s), at least one.
    pub(super) fn ticks_in(&self, time: f64) -> usize {
        ((time / self.dt()).round() as usize).max(1)
    }

    /// Checks that no traffic light works, for a format without phases of lights whose driver would obey them.
    ///
    /// # Errors
    /// The lights, by name.
    pub(super) fn without_lights(&self, format: &'static str) -> Result<(), ExportError> {
        if !self.lights().is_empty() {
            let what =
                "the phases of the traffic lights, which an ego of the user would obey: use xosc-1.3 or commonroad";
            return Err(ExportError::NotRepresentable { format, what: what.to_owned() });
        }
        Ok(())
    }

    /// Checks that the road has no friction of its own, for an ego that another program drives.
    ///
    /// # Errors
    /// The friction, by name.
    pub(super) fn without_friction(&self, format: &'static str) -> Result<(), ExportError> {
        let grip = self.scenario.cast.vehicles[0].blueprint.grip;
        if grip.is_finite() {
            let what = format!("the friction of the road ({grip:.1} m/s²), which an ego of the user would feel");
            return Err(ExportError::NotRepresentable { format, what });
        }
        Ok(())
    }

    /// The tick after which the pedestrian of the verdict moves, and the way to it from the ego's reference point then (m).
    ///
    /// # Errors
    /// The pedestrian never moves.
    pub(super) fn release(
        &self,
        format: &'static str,
        reference: impl Fn(&Motion) -> [f64; 3],
    ) -> Result<(usize, [f64; 3]), ExportError> {
        let actors = self.actors();
        let track = &actors[self.main_pedestrian()].track;
        let moves = |pair: &[Motion]| (pair[1].pose.position() - pair[0].pose.position()).norm() > 1e-9;
        let Some(first) = track.windows(2).position(moves) else {
            let what = "the release of a pedestrian that stands still".to_owned();
            return Err(ExportError::NotRepresentable { format, what });
        };
        let [x, y, z] = reference(&actors[0].track[first]);
        let Motion { pose: place, ground, .. } = track[first];
        Ok((first, [place.x - x, place.y - y, ground - z]))
    }

    /// Length of a tick (s).
    pub(super) fn dt(&self) -> f64 {
        self.scenario.episode.tick
    }

    /// The time of a tick (ns).
    pub(super) fn nanos(&self, tick: usize) -> u64 {
        (tick as f64 * self.dt() * 1e9).round() as u64
    }

    pub(super) fn ticks(&self) -> usize {
        self.trace.vehicle(0).len().saturating_sub(1)
    }

    /// The name as a part of file names: `RUN-EPISODE`.
    pub(super) fn stem(&self) -> String {
        self.name.replace(|character: char| !character.is_ascii_alphanumeric(), "-")
    }

    /// What happened, in a line: name, digest, outcome, verdict.
    pub(super) fn summary(&self) -> String {
        let struck: Vec<String> =
            self.actors().into_iter().filter(|actor| actor.is_struck).map(|actor| actor.name).collect();
        let before = match struck.is_empty() {
            true => String::new(),
            false => format!(", after touching {}, who lie there", struck.join(" and ")),
        };
        let end = match self.outcome.impact_speed() {
            Some(speed) => format!("collision at {speed:.2} m/s"),
            None => format!("no collision, least gap {:.2} m", self.outcome.least_gap),
        };
        let verdict = self.verdict.map(|verdict| format!(", {}", verdict.word())).unwrap_or_default();
        let cause = self.cause.map(|cause| format!(". {cause}")).unwrap_or_default();
        format!("{} ({}), digest {:016x}: {end}{before}{verdict}{cause}", self.name, self.title, self.outcome.digest)
    }

    /// The first tick at which the ego's box overlaps a box of this size (m) around the middle of a pedestrian, given by its place among the
    /// actors: the touch as programs see it that know boxes only.
    pub(super) fn touch_of_boxes(actors: &[Actor], place: usize, [length, width, _]: [f64; 3]) -> Option<usize> {
        let (ego, pedestrian) = (&actors[0], &actors[place]);
        let outline = |motion: &Motion| OrientedBox::new(motion.pose, length / 2.0, width / 2.0);
        let mut ticks = ego.track.iter().zip(&pedestrian.track);
        ticks.position(|(ego_at, pedestrian_at)| ego.outline(ego_at).overlaps(&outline(pedestrian_at)))
    }

    /// Length, width and height (m) of the box that represents an actor, given by its place, in programs that know boxes only.
    ///
    /// For a disc it is the square around it, whose corners touch at most 0.21 diameters before the disc does. A pedestrian that passes the
    /// ego closely may graze it with a corner much earlier; then it is the largest square that does not.
    pub(super) fn box_of(&self, actors: &[Actor], place: usize) -> [f64; 3] {
        let [length, width, height] = actors[place].size();
        let scaled = |share: f64| [length * share, width * share, height];
        let hit = self.outcome.is_collision();
        let touch = |share: f64| Self::touch_of_boxes(actors, place, scaled(share));
        let too_early = |share: f64| touch(share).is_some_and(|tick| !hit || tick + 1 < self.ticks());
        let disc = matches!(actors[place].shape, Shape::Pedestrian(body) if body.target_box.is_none());
        if !disc || !too_early(1.0) {
            return scaled(1.0);
        }
        // The square within the disc never touches first.
        let (mut low, mut high) = (std::f64::consts::FRAC_1_SQRT_2, 1.0);
        for _ in 0..20 {
            let middle = (low + high) / 2.0;
            if too_early(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        // That of the verdict touches.
        let touches = hit && place == self.main_pedestrian();
        scaled(if touches && touch(low * GRAZE).is_none() { 1.0 } else { low * GRAZE })
    }
}

impl Actor<'_> {
    /// Length, width and height (m). A disc has those of the square around it.
    pub(super) fn size(&self) -> [f64; 3] {
        match self.shape {
            Shape::Vehicle(blueprint) => [2.0 * blueprint.half_length, 2.0 * blueprint.half_width, CAR_HEIGHT],
            Shape::Pedestrian(body) => [2.0 * body.half().x, 2.0 * body.half().y, 2.0 * body.half_height],
        }
    }

    /// The box of the actor.
    pub(super) fn outline(&self, motion: &Motion) -> OrientedBox {
        let [length, width, _] = self.size();
        OrientedBox::new(motion.pose, length / 2.0, width / 2.0)
    }
}

/// The track of a body on axles this far apart (m), from its poses, velocities, and heights of its level.
fn track(town: &Town, states: impl Iterator<Item = (Pose, Vector, f64)>, wheelbase: f64) -> Vec<Motion> {
    let flat = town.roads.iter().all(|road| road.plan_view.elevation().cubics().is_empty());
    let height = |place: Place| {
        let lane = if flat { None } else { town.nearest_lane(place, LaneFilter::Any) };
        lane.map_or(0.0, |lane| town.elevation(lane))
    };
    let mut heading: Option<f64> = None;
    states
        .map(|(pose, velocity, level)| {
            let unwrapped = heading.map_or(pose.yaw, |before| before + wrap_angle(pose.yaw - before));
            heading = Some(unwrapped);
            let axle = |ahead: f64| height(Place::on(pose.to_world(Vector::new(ahead, 0.0)), level));
            let [rear, front] = [-wheelbase / 2.0, wheelbase / 2.0].map(axle);
            let pitch = libm::atan2(rear - front, wheelbase);
            Motion { pose, heading: unwrapped, velocity, ground: (rear + front) / 2.0, pitch }
        })
        .collect()
}
