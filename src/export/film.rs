//! An episode as a film: frames from above, north up, and how long each is shown.

use super::Episode;
use super::canvas::{Canvas, Colour};
use super::episode::{Actor, Shape};
use super::lane_bounds::lane_bounds;
use road::geometry::{OrientedBox, Point, Pose, Vector};
use road::{LaneKind, Town};
use world::sim::ActorId;

/// Width and height of a frame (px); both even, as encoders want them.
pub(super) const SIZE: [usize; 2] = [720, 480];
/// The head with the text (px).
const HEAD: usize = 52;
/// The maximum duration that a film shows of an episode, up to its end (s).
const MAX_DURATION: f64 = 12.0;
/// The shortest time of a frame (s), and how long the last one is shown (s).
const MIN_FRAME: f64 = 0.04;
const LAST: f64 = 1.5;
/// Ground around the tracks (m), and the least width that is shown (m).
const MARGIN: f64 = 6.0;
const MIN_WIDTH: f64 = 36.0;
/// The maximum distance between two points of a lane's edge (m).
const STEP: f64 = 1.0;
/// The minimum radius of a pedestrian (px).
const MIN_RADIUS: f64 = 5.0;
/// The pedal from which a driver counts as braking.
const BRAKING: f64 = 0.1;

const GROUND: Colour = [226, 232, 220];
const SIDEWALK: Colour = [200, 198, 192];
const ROAD: Colour = [120, 124, 130];
const MARK: Colour = [214, 216, 220];
const HOUSE: Colour = [150, 132, 114];
const EGO: Colour = [34, 86, 196];
const WINDOW: Colour = [190, 214, 250];
const TRAFFIC: Colour = [70, 160, 180];
const PEDESTRIAN: Colour = [214, 48, 48];
const PAPER: Colour = [255, 255, 255];
const INK: Colour = [32, 36, 42];

/// All colours; others in a frame are mixtures of two of them.
pub(super) const COLOURS: [Colour; 11] =
    [PAPER, INK, GROUND, SIDEWALK, ROAD, MARK, HOUSE, EGO, WINDOW, TRAFFIC, PEDESTRIAN];

pub(super) struct Film<'a> {
    episode: &'a Episode<'a>,
    actors: Vec<Actor<'a>>,
    /// The ticks that are shown.
    ticks: Vec<usize>,
    /// The picture without actors.
    background: Canvas,
    headline: String,
}

impl<'a> Film<'a> {
    /// Chooses ticks and a place, and draws all that does not move.
    pub fn new(episode: &'a Episode<'a>) -> Self {
        let (last, dt) = (episode.ticks(), episode.dt());
        let every = (MIN_FRAME / dt).ceil().max(1.0) as usize;
        let count = (MAX_DURATION / dt / every as f64) as usize;
        let mut ticks: Vec<usize> = (0..=count).map_while(|back| last.checked_sub(back * every)).collect();
        ticks.reverse();
        let actors = episode.actors();
        let main = [&actors[0], &actors[episode.main_pedestrian()]];
        let places = || main.iter().flat_map(|actor| actor.track[ticks[0]..].iter().map(|at| at.pose.position()));
        let low = places().fold(Point::new(f64::MAX, f64::MAX), |a, b| a.inf(&b));
        let high = places().fold(Point::new(f64::MIN, f64::MIN), |a, b| a.sup(&b));
        let middle = Point::from((low.coords + high.coords) / 2.0);
        let [width, height] = [SIZE[0] as f64, (SIZE[1] - HEAD) as f64];
        let [across, up] = [high.x - low.x + 2.0 * MARGIN, high.y - low.y + 2.0 * MARGIN];
        let shown = MIN_WIDTH.max(across).max(up * width / height);
        let scale = width / shown;
        let corner = middle + Vector::new(-shown / 2.0, (height / 2.0 + HEAD as f64) / scale);
        let mut background = Canvas::new(SIZE, corner, scale, GROUND);
        draw_town(&mut background, &episode.scenario.town);
        for (actor, colour) in main.into_iter().zip([EGO, PEDESTRIAN]) {
            let way: Vec<Point> = actor.track[ticks[0]..].iter().map(|at| at.pose.position()).collect();
            background.draw(&[way], 2.0, colour, 0.4);
        }
        background.fill_head(HEAD, PAPER);
        let end = match episode.outcome.impact_speed() {
            Some(speed) => format!("collision at {speed:.1} m/s"),
            None => format!("no collision, least gap {:.2} m", episode.outcome.least_gap),
        };
        let verdict = episode.verdict.map(|verdict| verdict.word().to_owned());
        let headline = [Some(end), verdict].into_iter().flatten().collect::<Vec<_>>().join(", ");
        Self { episode, actors, ticks, background, headline: format!("{}  {headline}", episode.name) }
    }

    /// The number of frames.
    pub fn len(&self) -> usize {
        self.ticks.len()
    }

    /// The time from the start of the film to that of a frame (s); the end of the film for the number of frames.
    pub fn time(&self, frame: usize) -> f64 {
        let since = |tick: usize| (tick - self.ticks[0]) as f64 * self.episode.dt();
        match self.ticks.get(frame) {
            Some(tick) => since(*tick),
            None => since(self.episode.ticks()) + LAST,
        }
    }

    /// Draws a frame.
    pub fn frame(&self, frame: usize) -> Canvas {
        let tick = self.ticks[frame];
        let mut canvas = self.background.clone();
        for actor in &self.actors {
            let motion = &actor.track[tick];
            match (actor.shape, actor.id) {
                (Shape::Vehicle(_), ActorId::Vehicle(number)) => {
                    let brake = self.episode.trace.vehicle(usize::from(number))[tick].driven.control.brake;
                    let colour = if actor.id == ActorId::EGO { EGO } else { TRAFFIC };
                    draw_car(&mut canvas, &actor.outline(motion), colour, brake > BRAKING);
                }
                (Shape::Pedestrian(body), _) if body.target_box.is_some() => {
                    canvas.fill(&[actor.outline(motion).corners()], PEDESTRIAN, 1.0);
                }
                _ => {
                    let radius = (actor.size()[0] / 2.0).max(MIN_RADIUS * canvas.pixel());
                    canvas.fill_circle(motion.pose.position(), radius + canvas.pixel(), PAPER);
                    canvas.fill_circle(motion.pose.position(), radius, PEDESTRIAN);
                }
            }
        }
        let [ego, pedestrian] =
            [0, self.episode.main_pedestrian()].map(|actor| self.actors[actor].track[tick].velocity.norm());
        let time = tick as f64 * self.episode.dt();
        canvas.write(&self.headline, 8, 6, INK);
        canvas.write(&format!("{time:5.2} s"), 8, 30, INK);
        canvas.write(&format!("car {ego:4.1} m/s"), 168, 30, EGO);
        canvas.write(&format!("pedestrian {pedestrian:3.1} m/s"), 408, 30, PEDESTRIAN);
        canvas
    }
}

fn draw_car(canvas: &mut Canvas, outline: &OrientedBox, colour: Colour, brakes: bool) {
    let (pose, half) = (outline.pose, outline.half);
    // A part of the box between two shares of its length.
    let part = |from: f64, to: f64| {
        let middle = pose.to_world(Vector::new(half.x * (from + to) / 2.0, 0.0));
        OrientedBox::new(Pose::new(middle.x, middle.y, pose.yaw), half.x * (to - from) / 2.0, half.y * 0.86).corners()
    };
    canvas.fill(&[outline.corners()], colour, 1.0);
    canvas.fill(&[part(0.2, 0.55)], WINDOW, 1.0);
    if brakes {
        canvas.fill(&[part(-1.0, -0.84)], PEDESTRIAN, 1.0);
    }
}

fn draw_town(canvas: &mut Canvas, town: &Town) {
    let (mut walks, mut lanes, mut marks) = (Vec::new(), Vec::new(), Vec::new());
    for (start, kind) in town.lane_starts().filter(|(_, kind)| *kind != LaneKind::None) {
        let [left, right] = lane_bounds(town, start, STEP);
        let corners: Vec<Point> = left.iter().chain(right.iter().rev()).copied().collect();
        let driving = kind == LaneKind::Driving;
        if driving { &mut lanes } else { &mut walks }.push(corners);
        if driving && !town.is_junction(start) {
            marks.extend([left, right]);
        }
    }
    canvas.fill(&walks, SIDEWALK, 1.0);
    canvas.fill(&lanes, ROAD, 1.0);
    canvas.draw(&marks, 1.4, MARK, 0.8);
    let crosswalks: Vec<_> = town.crosswalks.iter().map(|walk| &walk.corners).collect();
    canvas.fill(&crosswalks, MARK, 0.6);
    let houses: Vec<_> = town.obstacles.iter().map(OrientedBox::corners).collect();
    canvas.fill(&houses, HOUSE, 1.0);
}
