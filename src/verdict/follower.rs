use super::Encounter;
use super::trial::{Seen, Watch};
use episode::{Pair, RecordedActor};
use road::geometry::Point;
use world::av::reference_drivers::{BrakeProfile, DelayedBrake};
use world::sim::ActorId;

/// The greatest deceleration that is asked about (m/s²): no car brakes as hard.
const MAX_DECELERATION: f64 = 50.0;
/// The deceleration is known to this (m/s²).
const RESOLUTION: f64 = 0.001;

/// The car that follows the one under test, when a careful human brakes that one no harder than it must.
///
/// The human brakes from when braking is due, its reaction after the danger begins, with the least deceleration that avoids the pedestrian. A danger that could be seen
/// for long needs little. The follower drives as recorded until 0.75 s after the human begins to brake: UN R157's reaction time. Then it
/// brakes with a constant deceleration.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Follower {
    /// Its number among the vehicles.
    pub vehicle: u8,
    /// The least deceleration with which it stays behind both careful humans (m/s²); `None` if it touches one of them before it reacts, or with
    /// 50 m/s².
    pub deceleration: Option<f64>,
    /// The deceleration of a careful human in it (m/s²): 0.774 g, as far as its brake and the road allow.
    pub limit: f64,
}

/// The car under test from the tick on in which a careful human brakes it.
#[derive(Debug, Clone, Default)]
pub(super) struct Braked {
    /// The number of that tick.
    first: usize,
    /// How far it has come in each tick from there on (m).
    ways: Vec<f64>,
    last: Option<Point>,
    /// Whether it has stopped at the end of these.
    pub stopped: bool,
}

impl Watch for Braked {
    fn tick(&mut self, seen: &Seen) {
        let here = seen.outline.pose.position();
        let moved = self.last.map_or(0.0, |last| (here - last).norm());
        self.ways.push(self.ways.last().unwrap_or(&0.0) + moved);
        self.last = Some(here);
    }

    fn interferes(&mut self, tick: usize) {
        self.first = tick;
    }
}

/// A car behind, as recorded: its way on the path of the car under test (m) and its speed (m/s), tick by tick.
struct Recorded {
    ways: Vec<f64>,
    speeds: Vec<f64>,
    dt: f64,
}

impl Follower {
    /// Whether a careful human in it does not stay behind.
    pub fn touches(&self) -> bool {
        self.deceleration.is_none_or(|needed| needed > self.limit)
    }

    /// The one that follows in an encounter, with what careful humans make of the car under test; `None` without one.
    pub(super) fn behind(pair: &Pair<'_>, encounter: &Encounter<'_>, humans: &[Braked]) -> Option<Self> {
        let first = pair.len() - encounter.speeds.len();
        let path = &encounter.path;
        let along = |actor: &RecordedActor<'_>, tick| path.place(actor.state(tick).0.position(), 0.0);
        let follows = |actor: &RecordedActor<'_>| {
            let (pose, place) = (actor.state(first).0, along(actor, first));
            let is_behind = place.along + actor.half.x <= encounter.ways[0] - encounter.half.x;
            let is_on_path = place.aside.abs() < actor.half.y + encounter.half.y;
            is_behind && is_on_path && pose.forward().dot(&place.direction) > 0.0
        };
        let behind = others(pair).filter(follows);
        let nearest = behind.max_by(|one, other| along(one, first).along.total_cmp(&along(other, first).along))?;
        let ActorId::Vehicle(vehicle) = nearest.id else { return None };
        let recorded = Recorded {
            ways: (first..pair.len()).map(|tick| along(&nearest, tick).along).collect(),
            speeds: (first..pair.len()).map(|tick| nearest.state(tick).1).collect(),
            dt: pair.dt(),
        };
        let lengths = encounter.half.x + nearest.half.x;
        let rear = |human: &Braked| encounter.car(human.first, 0.0).way - lengths;
        let needed = humans.iter().map(|human| recorded.needed(human, rear(human)));
        let deceleration = needed.reduce(|one, other| Some(one?.max(other?))).flatten();
        let blueprint = &pair.scenario.cast.vehicles[usize::from(vehicle)].blueprint;
        let limit = BrakeProfile::careful_human(DelayedBrake::CAREFUL).full.min(blueprint.greatest_deceleration());
        Some(Self { vehicle, deceleration, limit })
    }
}

/// The other cars with drivers.
pub(super) fn others<'a>(pair: &Pair<'a>) -> impl Iterator<Item = RecordedActor<'a>> + use<'a> {
    let vehicles = &pair.scenario.cast.vehicles;
    pair.others().filter(|actor| match actor.id {
        ActorId::Vehicle(number) => !actor.is_parked && !vehicles[usize::from(number)].is_absent,
        ActorId::Pedestrian(_) => false,
    })
}

impl Recorded {
    /// The least deceleration with which it stays behind a car (m/s²). Its middle may come to `rear` when that car begins to brake (m).
    fn needed(&self, ahead: &Braked, rear: f64) -> Option<f64> {
        let Some(whole) = ahead.ways.last() else { return Some(0.0) };
        let reacts = ahead.first + (DelayedBrake::ATTENTIVE / self.dt).round() as usize;
        let end = rear + whole;
        let rear = |tick: usize| rear + ahead.ways.get(tick - ahead.first).unwrap_or(whole);
        if (ahead.first..=reacts).any(|tick| self.at(tick).0 > rear(tick)) {
            return None;
        }
        let (way, speed) = self.at(reacts);
        let stays_behind = |deceleration: f64| {
            let stop = way + speed * speed / (2.0 * deceleration);
            let reached = |tick: usize| {
                let time = ((tick - reacts) as f64 * self.dt).min(speed / deceleration);
                way + speed * time - deceleration * time * time / 2.0
            };
            let last = reacts.max(ahead.first + ahead.ways.len() - 1);
            (reacts..=last).all(|tick| reached(tick) <= rear(tick)) && (!ahead.stopped || stop <= end)
        };
        let (mut low, mut high) = (0.0, MAX_DECELERATION);
        if stays_behind(low) {
            return Some(low);
        }
        if !stays_behind(high) {
            return None;
        }
        while high - low > RESOLUTION {
            let middle = (low + high) / 2.0;
            *if stays_behind(middle) { &mut high } else { &mut low } = middle;
        }
        Some(high)
    }

    /// Its way (m) and its speed (m/s) at a tick. After the recording it keeps its speed.
    fn at(&self, tick: usize) -> (f64, f64) {
        let last = self.ways.len() - 1;
        let speed = self.speeds[tick.min(last)];
        (self.ways[tick.min(last)] + speed * tick.saturating_sub(last) as f64 * self.dt, speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both drive at 10 m/s. The one ahead brakes after 1 s with 5 m/s² and stops after 10 m. The other one drives on for 7.5 m, and has the gap and 2.5 m
    /// to stop in.
    #[test]
    fn the_follower_needs_the_deceleration_of_the_way_that_is_left() {
        let dt = 0.05;
        let way = |time: f64| 10.0 * time.min(2.0) - 2.5 * time.min(2.0) * time.min(2.0);
        let ways = (0..=40).map(|tick| way(f64::from(tick) * dt)).collect();
        let ahead = Braked { first: 20, ways, last: None, stopped: true };
        let needed = |gap: f64| {
            let ways: Vec<f64> = (0..=20).map(|tick| 10.0 * (f64::from(tick) * dt - 1.0) - gap - 4.5).collect();
            Recorded { speeds: vec![10.0; ways.len()], ways, dt }.needed(&ahead, -4.5)
        };
        for (gap, deceleration) in [(7.5, 5.0), (10.0, 4.0), (17.5, 2.5), (47.5, 1.0)] {
            let found = needed(gap).unwrap();
            assert!((found - deceleration).abs() < 0.01, "{gap} m: {found} and not {deceleration} m/s²");
        }
        // It has closed by 1.4 m when it reacts.
        assert_eq!(needed(1.3), None);
        // With 1.6 m it must be slower as fast as the one ahead is when it comes near.
        assert!(needed(1.6).unwrap() > 12.0, "{:?}", needed(1.6));
    }
}
