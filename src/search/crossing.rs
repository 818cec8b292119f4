use base::seed::Stream;
use episode::Scene;
use episode::walker::WalkPolicy;
use road::geometry::{Point, Vector};
use world::sim::{Gait, WalkCommand};

/// How a pedestrian crosses in front of a car: the goal of a [`Crossing`]. Every number is a share from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Its speed, from the least above a stroll to the greatest that it can choose.
    pub pace: f64,
    /// The point of the car that it aims at, across the bumper: 0 is the corner on its own side at the start, 1 the other.
    pub aim: f64,
    /// How deep in the car that point is: 0 is at the bumper, 1 at the middle of the car.
    pub depth: f64,
    /// Its direction: 0.5 is straight across the car's path, 0 is 75° towards the car, 1 is 75° away from it.
    pub slant: f64,
    /// Its time in hand (s, from −0.5 to 2.5): it sets off this long before the last moment at which it would still meet the car.
    pub hurry: f64,
    /// Its reaction to the car: below one half it keeps its line. At one half it walks straight at the car, and the more it leads the nearer
    /// this is to 1: then it walks to where the two would meet.
    pub pursuit: f64,
}

impl Goal {
    /// The number of components.
    pub const DIM: usize = 6;
    /// Walks at once and as fast as it can to where it would meet the middle of the car: the controller `intercept`.
    pub const INTERCEPT: Self = Self { pace: 1.0, aim: 0.5, depth: 1.0, slant: 0.5, hurry: 1.0, pursuit: 1.0 };

    /// Walks at once and as fast as it can straight at the middle of the car: the controller `homing`.
    pub const HOMING: Self = Self { pursuit: 0.5, ..Self::INTERCEPT };

    /// The goal of these components, each cut to 0 .. 1.
    pub fn new(components: [f64; Self::DIM]) -> Self {
        let [pace, aim, depth, slant, hurry, pursuit] = components.map(|share| share.clamp(0.0, 1.0));
        Self { pace, aim, depth, slant, hurry, pursuit }
    }

    pub fn components(&self) -> [f64; Self::DIM] {
        [self.pace, self.aim, self.depth, self.slant, self.hurry, self.pursuit]
    }
}

/// Crosses the car's path towards a point of its front: a pedestrian with a plan of six numbers instead of a network.
///
/// It waits until it has to set off, then walks on a straight line at one speed, or pursues the car. It assumes that the car keeps its
/// velocity, and looks again at every decision until it sets off. Several pedestrians have a goal each.
#[derive(Debug, Clone)]
pub struct Crossing {
    /// One for each pedestrian that it moves, or one for all.
    goals: Vec<Goal>,
    walks: Vec<Walk>,
}

/// The walk of one pedestrian.
#[derive(Debug, Clone, Copy, Default)]
struct Walk {
    /// The side of the car on which it started: 1 for the left, −1 for the right.
    side: Option<f64>,
    /// The heading in which it set off (rad).
    line: Option<f64>,
}

/// The slowest pace, as a share of the greatest speed.
const STROLL: f64 = 0.25;
/// The greatest slant (rad).
const SLANT: f64 = 75.0 * std::f64::consts::PI / 180.0;
/// The time in hand (s) at shares of 0 and 1.
const HURRY: (f64, f64) = (-0.5, 2.5);

impl Crossing {
    /// All pedestrians with the same goal.
    pub fn new(goal: Goal) -> Self {
        Self::joint(&[goal])
    }

    /// Each pedestrian with a goal of its own; further ones have the last.
    pub fn joint(goals: &[Goal]) -> Self {
        Self { goals: goals.to_vec(), walks: Vec::new() }
    }
}

impl Walk {
    fn command(&mut self, goal: &Goal, scene: &Scene<'_>, pedestrian: usize) -> WalkCommand {
        let world = scene.world;
        let (walker, ego) = (&world.pedestrians[pedestrian], world.ego());
        let pose = &ego.state.pose;
        let (low, high) = scene.scenario.cast.pedestrians[pedestrian].action.speed;
        let speed = (high * (STROLL + (1.0 - STROLL) * goal.pace)).max(low);
        let here = walker.state.pose.position();
        let side = *self.side.get_or_insert(if pose.to_local(here).y > 0.0 { 1.0 } else { -1.0 });
        let (half_length, half_width) = (ego.blueprint.half_length, ego.blueprint.half_width);
        let across = side * (1.0 - 2.0 * goal.aim) * half_width;
        let point = Vector::new((1.0 - goal.depth) * half_length, across);
        let aim = pose.to_world(point);
        let wanted = if goal.pursuit >= 0.5 {
            scene.meeting(pedestrian, aim, speed, 2.0 * goal.pursuit - 1.0)
        } else if let Some(line) = self.line {
            WalkCommand { heading: line, speed }
        } else {
            let slant = (2.0 * goal.slant - 1.0) * SLANT;
            let heading = pose.forward() * libm::sin(slant) - pose.left() * (side * libm::cos(slant));
            WalkCommand { heading: libm::atan2(heading.y, heading.x), speed }
        };
        if self.line.is_some() || must_go(goal, scene, pedestrian, aim, &wanted) {
            self.line = Some(wanted.heading);
            return wanted;
        }
        WalkCommand { heading: wanted.heading, speed: low }
    }
}

/// Whether a pedestrian has to set off in order to meet the car.
fn must_go(goal: &Goal, scene: &Scene<'_>, pedestrian: usize, aim: Point, wanted: &WalkCommand) -> bool {
    if goal.hurry >= 1.0 {
        return true;
    }
    // A body that needs time to its speed loses half of that time.
    let delay = match scene.scenario.cast.pedestrians[pedestrian].body.gait {
        Gait::Carla { ramp, .. } => ramp / 2.0,
        Gait::Inertial { acceleration, .. } => wanted.speed / acceleration / 2.0,
    };
    let ego = &scene.world.ego().state;
    let here = scene.world.pedestrians[pedestrian].state.pose.position();
    let local = ego.pose.to_local(here) - ego.pose.to_local(aim);
    let across = Vector::new(libm::cos(wanted.heading), libm::sin(wanted.heading));
    let (along, aside) = (across.dot(&ego.pose.forward()), across.dot(&ego.pose.left()));
    // Time to reach the aimed point's path, and where along it that is.
    let walk = if aside.abs() > 1e-3 { (-local.y / aside / wanted.speed).max(0.0) + delay } else { delay };
    let meeting = local.x + along * wanted.speed * (walk - delay).max(0.0);
    let drive = meeting / ego.speed.max(0.1);
    let hurry = HURRY.0 + (HURRY.1 - HURRY.0) * goal.hurry;
    drive <= walk + hurry
}

impl WalkPolicy for Crossing {
    fn begin(&mut self, _: Stream) {
        self.walks.clear();
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        for (place, (pedestrian, _)) in scene.controlled().enumerate() {
            if self.walks.len() <= place {
                self.walks.push(Walk::default());
            }
            if let Some(goal) = self.goals.get(place).or(self.goals.last()) {
                commands[pedestrian] = self.walks[place].command(goal, scene, pedestrian);
            }
        }
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
