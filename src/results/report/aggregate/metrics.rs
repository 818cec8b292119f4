use super::run_totals::RunRow;
use super::{Method, Rate};
use crate::record::metric;
use crate::record::{CellKey, Metric};
use crate::report::grouped::grouped;
use base::statistics::{ClusteredCount, wilson};
use world::judge::Label;

/// A cell, for people.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    pub key: CellKey,
    /// Whether its episodes are the cases of a test: its rates have no interval.
    pub is_of_cases: bool,
    pub runs: u32,
    /// The number of episodes in all runs that count: without those in which the driver failed as a program, and those that are left out.
    pub episodes: u32,
    /// The number of episodes in which the driver failed; no other figure counts them.
    pub errors: u32,
    /// Collisions of all episodes. This and the other rates have Wilson's interval over the starts, which the runs share.
    pub collision: Rate,
    /// Collisions and bumps of all episodes.
    pub touch: Rate,
    /// The share of these in the front sector.
    pub front: Rate,
    /// Reward of an episode.
    pub reward_sum: Rate,
    /// Length of an episode (s).
    pub length: Rate,
    /// Speed of the ego at a collision (m/s).
    pub impact_speed: Rate,
    /// Collisions in all runs.
    pub collisions: u32,
    /// Preventable collisions of all episodes.
    pub preventable: Rate,
    /// Preventable collisions of all collisions.
    pub preventable_share: Rate,
    /// Avoidable injury of an episode: the severe-injury risk that a careful human would have spared.
    pub injury: Rate,
    /// The number of faults.
    pub faults: u32,
    /// Faults of all episodes.
    pub fault: Rate,
    /// The number of touches with each label, in the order of [`Label::ALL`].
    pub labels: [u32; Label::COUNT],
    /// The number of collisions with a foreseeable pedestrian.
    pub foreseeable: u32,
    /// The number of collisions in which the pedestrian walked into the side or the rear.
    pub walked_into: u32,
    /// The number of episodes without error: those that count, and those that are left out.
    pub all: u32,
    /// The number of these that are left out.
    pub left_out: u32,
    /// The number of these in which the car drove past the end of the road.
    pub road_end: u32,
    /// The number of these whose start the driver did not reach.
    pub placed: u32,
    /// The number of these in which the car left the road.
    pub left_road: u32,
    /// The expected rate of collisions that a driver drawn at random would have avoided, of all episodes.
    pub expected_preventable: Rate,
    /// All metrics, in the order of [`metrics`](crate::record::metrics).
    pub metrics: Vec<(Metric, Measured)>,
}

/// A metric of a cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Measured {
    /// The sum over the runs.
    Count(u32),
    /// The mean over the runs; a rate has Wilson's interval of the sums over the starts, which the runs share.
    Average(Rate),
}

/// Aggregates runs to cells, in the order of first appearance. Episodes in which the driver failed are counted as `errors` and have no
/// influence on other figures.
pub fn cells(runs: &[RunRow]) -> Vec<Cell> {
    let cells = grouped(runs, |one, other| one.key.cell == other.key.cell);
    cells.iter().map(|runs| Cell::of(runs)).collect()
}

/// A metric over runs.
fn measured(metric: Metric, runs: &[&RunRow]) -> Measured {
    let by_run = |name: &str| -> Vec<f64> { runs.iter().filter_map(|run| run.value(name)).collect() };
    let sum = |count: metric::Count| by_run(count.name).iter().sum::<f64>() as u64;
    // The runs share their starts, so a start counts once.
    let starts = |count: metric::Count| ClusteredCount::from(sum(count)).of_clusters(runs.len() as f64);
    let average = Rate::of_runs(by_run(metric.name()));
    match metric {
        Metric::Count(count) => Measured::Count(sum(count) as u32),
        Metric::Mean(_) => Measured::Average(average),
        Metric::Rate(rate) => {
            let interval = || wilson(starts(rate.part), starts(rate.whole));
            let interval = (!runs[0].is_of_cases).then(interval);
            Measured::Average(average.within(interval, Method::Wilson))
        }
    }
}

impl Cell {
    fn of(runs: &[&RunRow]) -> Self {
        let metrics = runs[0].values.iter().map(|(metric, _)| (*metric, measured(*metric, runs))).collect();
        let is_of_cases = runs[0].is_of_cases;
        let cell =
            Self { key: runs[0].key.cell.clone(), is_of_cases, runs: runs.len() as u32, metrics, ..Self::default() };
        let count = |count: metric::Count| cell.count(count);
        let rate = |name: &str| cell.average(name).cloned().unwrap_or_default();
        Self {
            episodes: count(metric::EPISODES),
            errors: count(metric::ERRORS),
            collision: rate(metric::COLLISION_RATE.name),
            touch: rate(metric::TOUCH_RATE.name),
            front: rate(metric::FRONT_RATE.name),
            reward_sum: rate(metric::EPISODE_REWARD.name),
            length: rate(metric::EPISODE_LENGTH.name),
            impact_speed: rate(metric::IMPACT_SPEED.name),
            collisions: count(metric::COLLISIONS),
            preventable: rate(metric::PREVENTABLE_RATE.name),
            preventable_share: rate(metric::PREVENTABLE_SHARE.name),
            injury: rate(metric::AVOIDABLE_INJURY.name),
            faults: count(metric::FAULT_COLLISIONS),
            fault: rate(metric::FAULT_RATE.name),
            labels: Label::ALL.map(|label| count(metric::labelled(label))),
            foreseeable: count(metric::FORESEEABLE_COLLISIONS),
            walked_into: count(metric::WALKED_INTO_COLLISIONS),
            all: count(metric::ALL_EPISODES),
            left_out: count(metric::LEFT_OUT_EPISODES),
            road_end: count(metric::ROAD_END_EPISODES),
            placed: count(metric::PLACED_STARTS),
            left_road: count(metric::LEFT_ROAD_EPISODES),
            expected_preventable: rate(metric::EXPECTED_PREVENTABLE.name),
            ..cell
        }
    }

    fn metric(&self, name: &str) -> Option<&Measured> {
        self.metrics.iter().find(|(metric, _)| metric.name() == name).map(|(_, measured)| measured)
    }

    /// A count over all runs.
    pub fn count(&self, count: metric::Count) -> u32 {
        if let Some(Measured::Count(count)) = self.metric(count.name) { *count } else { 0 }
    }

    /// A mean or a rate, by its name.
    pub fn average(&self, name: &str) -> Option<&Rate> {
        if let Some(Measured::Average(average)) = self.metric(name) { Some(average) } else { None }
    }

    /// The number of preventable collisions in all runs.
    pub fn preventable_collisions(&self) -> u32 {
        self.labels[Label::Preventable as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{self, EpisodeRow, RunKey, episodes};
    use crate::report::aggregate::run_totals::RunTotals;
    use world::av::Fault;
    use world::env::Ending;
    use world::judge::{ContactSide, Verdict};

    fn row(run: u32, episode: u32, hit: Option<(bool, f64)>) -> EpisodeRow {
        let ending = hit.map_or(Ending::Timeout, |(front, impact_speed)| Ending::Touch {
            pedestrian: 0,
            front,
            moving: impact_speed > 0.1,
            impact_speed,
            bearing: 0.5,
        });
        let mut row = crate::record::tests::row(episode, ending);
        row.key = RunKey { id: format!("{run:08x}").parse().unwrap(), run, ..RunKey::clone(&row.key) }.into();
        (row.judged.outcome.reward, row.judged.outcome.ticks) = (hit.map_or(0.0, |(_, speed)| 1.0 + speed), 10);
        // Frontal collisions are preventable; the others are bumps.
        row.judged.verdict = row.judged.verdict.zip(hit).map(|(verdict, (front, impact_speed))| Verdict {
            label: if front { Label::Preventable } else { Label::Bump },
            side: ContactSide::Front,
            walked_into: false,
            foreseeable: front,
            impact_speed,
            ..verdict
        });
        row
    }

    /// The run of these episodes.
    fn run(rows: &[EpisodeRow], metrics: Vec<Metric>) -> RunRow {
        let mut totals = RunTotals::new(metrics);
        totals.add(&episodes(rows)).unwrap();
        totals.row().unwrap()
    }

    /// The cells of the runs of these episodes.
    fn cells_of(rows: &[EpisodeRow]) -> Vec<Cell> {
        let runs = rows.chunk_by(|one, next| one.key == next.key).map(|rows| run(rows, record::metrics()));
        cells(&runs.collect::<Vec<_>>())
    }

    #[test]
    fn episodes_become_runs_and_runs_become_cells() {
        let rows = [
            row(0, 0, Some((true, 4.0))),
            row(0, 1, Some((false, 0.0))),
            row(0, 2, None),
            row(0, 3, None),
            row(1, 0, Some((true, 6.0))),
            row(1, 1, None),
            row(1, 2, None),
            row(1, 3, None),
        ];
        let [cell] = &cells_of(&rows)[..] else { panic!("one cell") };
        assert_eq!((cell.runs, cell.episodes), (2, 8));
        let near = |rate: &Rate, mean: f64, sd: f64| {
            assert!((rate.value.unwrap() - mean).abs() < 1e-12, "{rate:?}");
            assert!((rate.sd.unwrap() - sd).abs() < 1e-12, "{rate:?}");
        };
        near(&cell.touch, 0.375, 0.125 * 2.0_f64.sqrt());
        near(&cell.front, 0.75, 0.25 * 2.0_f64.sqrt());
        near(&cell.collision, 0.25, 0.0);
        near(&cell.impact_speed, 5.0, 2.0_f64.sqrt());
        assert_eq!(cell.collision.interval, Some(wilson(1, 4)), "its two runs share four starts");
        near(&cell.preventable, 0.25, 0.0);
        near(&cell.preventable_share, 1.0, 0.0);
        let intervals = [&cell.preventable, &cell.preventable_share].map(|rate| rate.interval.unwrap());
        assert_eq!(intervals, [wilson(1, 4), wilson(1, 1)]);
        assert_eq!((cell.collisions, cell.labels, cell.foreseeable), (2, [2, 0, 0, 0, 1], 2));
        // Every preventable collision of these is foreseeable.
        assert_eq!(cell.fault, cell.preventable);
    }

    #[test]
    fn episodes_in_error_count_as_errors_and_nowhere_else() {
        let failed = |run, episode| {
            let mut row = row(run, episode, None);
            row.judged.outcome.ending = Ending::Error(Fault::Ended(world::av::Exit::Unknown));
            row.judged.outcome.reward = 100.0;
            row
        };
        let rows = [row(0, 0, Some((true, 4.0))), failed(0, 1), row(0, 2, None), failed(1, 0)];
        let cell = &cells_of(&rows)[0];
        assert_eq!((cell.runs, cell.episodes, cell.errors), (2, 2, 2));
        assert_eq!((cell.collision.value, cell.collision.sd), (Some(0.5), None), "a run of errors alone has no rate");
        assert_eq!(cell.reward_sum.value, Some(2.5));
        let runs = 2.0;
        assert_eq!(
            cell.collision.interval.unwrap(),
            wilson(ClusteredCount::from(1).of_clusters(runs), ClusteredCount::from(2).of_clusters(runs))
        );
    }

    #[test]
    fn a_new_quantity_of_an_episode_is_a_metric() {
        const HURRY: record::Column<f64> = record::Column::new("hurry", "1/s", "how soon it was over");
        let entry = HURRY.of(|row: &EpisodeRow| 1.0 / f64::from(row.judged.outcome.ticks));
        let table = record::episode_table().column(entry);
        let mut all = record::metrics();
        all.push(Metric::Mean(metric::Mean::new(&HURRY, "mean hurry")));
        let mut totals = RunTotals::new(all.clone());
        totals.add(&table.frame(&[row(0, 0, None), row(0, 1, Some((true, 4.0)))])).unwrap();
        let run = totals.row().unwrap();
        assert_eq!(Cell::of(&[&run]).average("hurry").unwrap().value, Some(0.1));
    }

    #[test]
    fn parts_of_a_run_give_the_bits_of_the_whole_run() {
        let rows: Vec<_> = (0..40).map(|n| row(0, n, (n % 3 == 0).then(|| (n % 2 == 0, 0.1 * f64::from(n))))).collect();
        let wanted = run(&rows, record::metrics());
        for size in [1, 7, 40] {
            let mut totals = RunTotals::new(record::metrics());
            rows.chunks(size).for_each(|part| totals.add(&episodes(part)).unwrap());
            assert_eq!(totals.row().as_ref(), Some(&wanted), "{size}");
        }
        assert_eq!(RunTotals::new(record::metrics()).row(), None);
    }

    #[test]
    fn a_run_without_collisions_has_no_front_rate() {
        let cell = &cells_of(&[row(0, 0, None)])[0];
        assert_eq!((cell.front.value, cell.collision.value), (None, Some(0.0)));
    }
}
