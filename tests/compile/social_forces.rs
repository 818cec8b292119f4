//! Walkers by social forces beside those of JuPedSim: a free one, a corridor and bottlenecks.

use std::sync::Arc;

use base::seed::Seed;
use episode::walker::{Forces, Gaps, Natural, NaturalKeys, Recording, WalkPolicy};
use episode::{Controller, Destination, Draw, Observer, PedestrianRole, Placement, Trace, carry_out};
use road::geometry::{Obstacles, OrientedBox, Point, Pose};
use world::sim::{ActorStart, WalkCommand};

use crate::cast::{ahead, away, two_and_two};

/// The middle line of the walkers' ground, far from the street.
const MIDDLE: f64 = -80.0;
const TICK: f64 = 0.05;

/// Places in columns from x on, about the middle line (m): those of the recording.
fn grid(columns: u32, rows: u32, (apart, aside): (f64, f64), x: f64) -> Vec<Point> {
    let line = |row: u32| aside * (f64::from(row) - f64::from(rows - 1) / 2.0);
    (0..columns)
        .flat_map(|column| (0..rows).map(move |row| Point::new(x + apart * f64::from(column), line(row))))
        .collect()
}

/// A wall between two corners.
fn wall(a: (f64, f64), b: (f64, f64)) -> OrientedBox {
    OrientedBox::spanning(Point::new(a.0, MIDDLE + a.1), Point::new(b.0, MIDDLE + b.1))
}

/// The tracks of walkers from these places, every tick: to a point behind a door at x = 8 to 9 m, and from there on to one 90 m along x.
fn walk(starts: &[Point], walls: &[OrientedBox], forces: Option<Forces>, seconds: f64) -> Vec<Vec<Point>> {
    let mut scenario = two_and_two("blind", ("blind", ahead(80.0)), (away(), Controller::External));
    scenario.cast.vehicles.truncate(1);
    scenario.cast.vehicles[0].is_parked = true;
    scenario.obstacles = Arc::new(Obstacles::new(walls));
    scenario.episode.hold = 2;
    scenario.episode.ticks = (seconds / TICK) as u32;
    // The first is placed by the spawn rule, and only stands.
    let one = scenario.cast.pedestrian().clone();
    let first = PedestrianRole { controller: Controller::Fixed(WalkCommand::default()), ..one.clone() };
    let role = |place: &Point| {
        let start = ActorStart::standing(Pose::new(place.x, MIDDLE + place.y, 0.0));
        PedestrianRole { place: Placement::Fixed(start), ..one.clone() }
    };
    scenario.cast.pedestrians = std::iter::once(first).chain(starts.iter().map(role)).collect();
    let scenario = Arc::new(scenario);
    let mut walkers = [9.0, 90.0].map(|x| {
        let destination = Some(Destination::Point(Point::new(x, MIDDLE)));
        let keys = NaturalKeys { changes: Recording::Dut, heed: 0.0, gaps: Gaps::Recorded, destination, forces };
        Natural::from_keys(keys)
    });
    let mut env = scenario.simulation();
    let mut trace = Trace::new(&scenario);
    env.start(Draw::new(&Seed::root(1), 0));
    trace.begin(&env.scene());
    walkers.iter_mut().for_each(|walker| walker.begin(Seed::root(2).stream()));
    let mut commands = vec![WalkCommand::default(); starts.len() + 1];
    while env.outcome().is_none() {
        let mut onward = commands.clone();
        walkers[0].choose(&env.scene(), &mut commands);
        walkers[1].choose(&env.scene(), &mut onward);
        for (number, pedestrian) in env.scene().world.pedestrians.iter().enumerate() {
            if pedestrian.state.pose.x > 8.0 {
                commands[number] = onward[number];
            }
        }
        carry_out(&mut *env, &commands, &mut trace);
    }
    let track = |number| trace.pedestrian(number).iter().map(|state| state.pose.position()).collect();
    (1..=starts.len()).map(track).collect()
}

/// When a track passes a line across x (s).
fn crossing(track: &[Point], x: f64) -> Option<f64> {
    let before = track.windows(2).position(|two| two[0].x <= x && x < two[1].x)?;
    Some(TICK * (before as f64 + (x - track[before].x) / (track[before + 1].x - track[before].x)))
}

/// The mean speed between two lines (m/s).
fn speed(tracks: &[Vec<Point>], low: f64, high: f64) -> f64 {
    let time = |track: &Vec<Point>| crossing(track, high).unwrap() - crossing(track, low).unwrap();
    tracks.iter().map(|track| (high - low) / time(track)).sum::<f64>() / tracks.len() as f64
}

/// The recorded value of a case (`jupedsim/flow.csv`).
fn recorded(case: &str) -> f64 {
    let file = crate::repository().join("tests/reference/jupedsim/flow.csv");
    let text = std::fs::read_to_string(file).unwrap();
    let row = text.lines().find(|line| line.starts_with(case)).unwrap();
    row.rsplit(',').next().unwrap().parse().unwrap()
}

/// The least distance of two walkers in any tick before a time (m).
fn least_distance(tracks: &[Vec<Point>], seconds: f64) -> f64 {
    let pairs = (0..tracks.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    let ticks = (seconds / TICK) as usize;
    let distances =
        pairs.flat_map(|(one, other)| (0..ticks).map(move |tick| (tracks[one][tick] - tracks[other][tick]).norm()));
    distances.fold(f64::INFINITY, f64::min)
}

/// How many places of tracks are within walls.
fn within(tracks: &[Vec<Point>], walls: &[OrientedBox]) -> usize {
    tracks.iter().flatten().filter(|place| walls.iter().any(|wall| wall.distance_to(**place) <= 0.0)).count()
}

/// Both walk as fast as they want where there is room, and slow down by less than a tenth at 0.4 people a square metre. Nobody walks into a wall or
/// through others there.
#[test]
fn in_a_corridor_walkers_by_social_forces_walk_as_those_of_jupedsim() {
    assert_eq!(recorded("free"), 1.3, "a free walker is as fast as it wants");
    let slower = recorded("corridor") / recorded("free");
    let people = grid(6, 3, (2.5, 0.9), 1.0);
    let walls = [wall((-2.0, 1.5), (62.0, 1.8)), wall((-2.0, -1.8), (62.0, -1.5))];
    let among = walk(&people, &walls, Some(Forces::Social), 90.0);
    // The same draws without forces.
    let free = walk(&people, &[], None, 90.0);
    let ours = speed(&among, 20.0, 45.0) / speed(&free, 20.0, 45.0);
    assert!((0.9..1.02).contains(&(ours / slower)), "{ours} and {slower} of the free speed");
    assert_eq!(within(&among, &walls), 0);
    let least = least_distance(&among, 20.0);
    assert!(least > 0.15, "{least} m");
    let alone = walk(&people[..1], &walls, Some(Forces::Social), 90.0);
    let free = walk(&people[..1], &[], None, 90.0);
    let ratio = speed(&alone, 20.0, 45.0) / speed(&free, 20.0, 45.0);
    assert!((0.97..1.03).contains(&ratio), "a lone walker keeps its speed between walls: {ratio}");
}

/// Walkers of 1995 have no bodies, which push those of 2000 through a door, and draw speeds of their own. So the range is wide: 0.4 to 1 times the flow
/// of JuPedSim, whose growth with the width they share.
#[test]
fn through_a_door_walkers_by_social_forces_flow_at_the_pace_of_those_of_jupedsim_or_less() {
    let mut before = 0.0;
    for width in ["1.0", "1.2", "1.6", "2.0"] {
        let half = width.parse::<f64>().unwrap() / 2.0;
        let walls = [
            wall((-0.3, -3.3), (0.0, 3.3)),
            wall((0.0, 3.0), (8.0, 3.3)),
            wall((0.0, -3.3), (8.0, -3.0)),
            wall((8.0, half), (9.0, 3.3)),
            wall((8.0, -3.3), (9.0, -half)),
        ];
        let tracks = walk(&grid(6, 5, (0.8, 0.8), 1.5), &walls, Some(Forces::Social), 100.0);
        assert_eq!(within(&tracks, &walls), 0, "{width} m");
        let mut times: Vec<f64> = tracks.iter().filter_map(|track| crossing(track, 8.5)).collect();
        times.sort_by(f64::total_cmp);
        assert!(times.len() >= 25, "{} of 30 pass {width} m", times.len());
        let flow = 19.0 / (times[24] - times[5]);
        let ratio = flow / recorded(&format!("bottleneck,30,{width}"));
        assert!((0.4..1.0).contains(&ratio) && flow > before, "{width} m: {flow} people/s, {ratio} of JuPedSim's");
        before = flow;
    }
}
