use std::ops::ControlFlow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use base::seed::Seed;
use episode::walker::Natural;
use episode::{LeftOut, Outcome, Scenario, Trace, evaluate_observed};
use world::sim::ActorId;

/// A pedestrian whom the car passes with this gap (m) has nothing to do with it.
const SPARE: f64 = 2.0;
/// A car that has gone no farther (m) is still there.
const REST: f64 = 0.1;
/// A car is delayed that needs this much longer for its way (s).
const LATER: f64 = 1.0;

/// What a driver gives for safety: how far it gets without anybody, and how often it is delayed by somebody who has nothing to do with it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// Starts that count.
    pub starts: u64,
    /// The way of the car without anybody, and that of a car that drives as fast as limits and bends allow (m): sums over the starts, of their squares, and of
    /// their product.
    pub ways: [f64; 2],
    pub squares: [f64; 2],
    pub product: f64,
    /// Encounters with a natural pedestrian whom the car passes with 2 m or more to spare, as it drives without anybody.
    pub spared: u64,
    /// Those in which it needs a second longer for its way than without anybody.
    pub delayed: u64,
    /// Episodes in which a program failed.
    pub errors: u64,
}

/// Episodes that are kept at a time.
const TOGETHER: usize = 50;

/// A drive: where the car was, and how far it had come (m), after each tick.
struct Drive {
    outcome: Outcome,
    trace: Trace,
    way: Vec<f64>,
}

impl Price {
    /// That of the driver of a scenario, from the first starts of a seed. `free` is the same scenario with a driver that drives as fast as limits and bends
    /// allow. `None` if `stop` was true before the end; it gets the number of starts that are over.
    ///
    /// Each start has three episodes: with a natural pedestrian, without anybody, and without anybody with the other driver.
    pub fn new(
        scenario: &Arc<Scenario>,
        free: &Arc<Scenario>,
        starts: u32,
        seed: &Seed,
        stop: &mut dyn FnMut(u32) -> bool,
    ) -> Option<Self> {
        let empty = |scenario: &Scenario| {
            let cast = scenario.cast.without(ActorId::Pedestrian(0));
            Arc::new(Scenario { cast, ..scenario.clone() })
        };
        let (alone, free) = (empty(scenario), empty(free));
        let (starting, walking) = (seed.child("starts"), seed.child("walker"));
        let (mut price, mut episodes_over) = (Self::default(), 0);
        for first in (0..starts).step_by(TOGETHER) {
            let episodes = first..starts.min(first + TOGETHER as u32);
            let mut is_stopped = false;
            let mut go_on = |_: u32| {
                episodes_over += 1;
                is_stopped |= stop(episodes_over / 3);
                if is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let mut drives = [scenario, &alone, &free].map(|scenario| {
                let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| Drive::new(*outcome, trace.clone());
                let walker = &mut Natural::default();
                evaluate_observed(walker, scenario, episodes.clone(), &starting, &walking, note, &mut go_on).into_iter()
            });
            for _ in episodes {
                // It ends early, too, where the driver fails again and again.
                let [Some(met), Some(alone), Some(free)] = drives.each_mut().map(Iterator::next) else {
                    return (!is_stopped).then_some(price);
                };
                price.add(scenario, &met, &alone, &free);
            }
        }
        Some(price)
    }

    fn add(&mut self, scenario: &Scenario, met: &Drive, alone: &Drive, free: &Drive) {
        let drives = [met, alone, free].map(|drive| &drive.outcome);
        self.errors += drives.iter().filter(|outcome| outcome.fault().is_some()).count() as u64;
        // A car that leaves the road, or drives past its end, has no way that counts. One that is too slow for its run-up begins at rest.
        let is_lost = |outcome: &Outcome| matches!(outcome.left_out, Some(LeftOut::OffRoad | LeftOut::RoadEnd));
        if drives.iter().any(|outcome| outcome.fault().is_some()) || is_lost(&alone.outcome) || is_lost(&free.outcome) {
            return;
        }
        // Over the time that both drive.
        let ticks = alone.way.len().min(free.way.len()) - 1;
        let ways = [alone, free].map(|drive| drive.way[ticks]);
        self.starts += 1;
        for ((sum, squares), way) in self.ways.iter_mut().zip(&mut self.squares).zip(ways) {
            *sum += way;
            *squares += way * way;
        }
        self.product += ways[0] * ways[1];
        let pair = met.trace.pair(scenario, 0, 0);
        let (driving, dt) = (alone.trace.vehicle(0), scenario.episode.tick);
        let gap = pair.frames().zip(driving).map(|(frame, car)| {
            let outline = car.state.outline(pair.blueprint);
            frame.pedestrian.gap_to(&outline, pair.body)
        });
        if drives[0].counts() && gap.fold(f64::INFINITY, f64::min) >= SPARE {
            self.spared += 1;
            let end = *met.way.last().expect("there is a start");
            // A car that comes to rest there without anybody, too, is not delayed.
            let left = alone.way.partition_point(|way| *way <= end + REST);
            self.delayed += u64::from((met.way.len() - 1) as f64 * dt >= left as f64 * dt + LATER);
        }
    }

    /// The way of the car without anybody, as a share of the way of one that drives as fast as limits and bends allow, with its 95 % interval over starts; `None` without a way.
    ///
    /// # Source
    /// Variance of a ratio: Cochran, *Sampling Techniques* (1977), 2.11.
    pub fn progress(&self) -> Option<(f64, Option<(f64, f64)>)> {
        let ratio = (self.ways[1] > 0.0).then(|| self.ways[0] / self.ways[1])?;
        let n = self.starts as f64;
        let spread = self.squares[0] - 2.0 * ratio * self.product + ratio * ratio * self.squares[1];
        let error = (n * spread.max(0.0) / (n - 1.0)).sqrt() / self.ways[1];
        let ends = (self.starts > 1).then_some(((ratio - 1.96 * error).max(0.0), ratio + 1.96 * error));
        Some((ratio, ends))
    }

    /// The share of needlessly delayed encounters; `None` without any that is spared.
    pub fn needless(&self) -> Option<f64> {
        (self.spared > 0).then(|| self.delayed as f64 / self.spared as f64)
    }
}

impl Drive {
    fn new(outcome: Outcome, trace: Trace) -> Self {
        let frames = trace.vehicle(0);
        let mut way = Vec::with_capacity(frames.len());
        let mut sum = 0.0;
        for (place, frame) in frames.iter().enumerate() {
            let before = &frames[place.saturating_sub(1)].state;
            sum += (frame.state.pose.position() - before.pose.position()).norm();
            way.push(sum);
        }
        Self { outcome, trace, way }
    }
}
