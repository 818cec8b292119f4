use std::collections::BTreeMap;

use polars::prelude::{BooleanChunked, DataFrame, Float64Chunked, PolarsResult, StringChunked, UInt32Chunked};

use super::evidence::{Evidence, Gathering};
use super::metrics::runs;
use super::{Episodes, FailureModes, ReportFolder, Run, Starts, Tally, WriteError};
use crate::av::DrivingMode;
use crate::compile::Evaluation;
use crate::env::{Ending, Outcome, Spawn};
use crate::geometry::Pose;
use crate::seed::Seed;

/// What one pass over all episodes brings: small tables, counts, and a bounded sample.
#[derive(Debug, Clone)]
pub struct Gathered {
    /// One row a run.
    pub runs: DataFrame,
    /// Episodes, those in error included.
    pub episodes: u64,
    /// Simulator ticks of them.
    pub ticks: u64,
    /// Whether every evaluation has all its episodes, or as many as its stopping rule asks for.
    pub all_tried: bool,
    /// Episodes in error.
    pub errors: u64,
    /// How many of these were not tried, for a limit or since something before them had failed.
    pub untried: u64,
    /// Where the first error is, and what went wrong.
    pub first_error: Option<String>,
    /// Episodes whose reward is no number.
    pub unpaid: u64,
    /// Where the first of these is.
    pub first_unpaid: Option<String>,
    /// Whether every driver drove at least one episode in every town to its end.
    pub every_driver_drove: bool,
    /// Intervals over trainings, comparisons on common beginnings, transfer gaps.
    pub evidence: Evidence,
    /// Where trained pedestrians began, by town.
    pub starts: BTreeMap<String, Starts>,
    /// What the page shows of the episodes.
    pub tally: Tally,
}

/// Goes over all episodes once: writes the table `episodes` and gathers what all other outputs are made from.
///
/// # Errors
/// A table that cannot be made or a file that cannot be written.
pub fn gather(
    folder: &ReportFolder,
    episodes: &Episodes<'_>,
    kinds: &mut FailureModes<'_>,
    seed: &Seed,
) -> Result<Gathered, WriteError> {
    let failed = |source| WriteError::Table { name: "episodes".into(), source };
    let mut gathered = Gathered {
        runs: runs(&super::episodes(&[])).map_err(failed)?,
        episodes: 0,
        ticks: 0,
        all_tried: true,
        errors: 0,
        untried: 0,
        first_error: None,
        unpaid: 0,
        first_unpaid: None,
        every_driver_drove: true,
        evidence: Evidence::default(),
        starts: BTreeMap::new(),
        tally: Tally::default(),
    };
    let mut evidence = Gathering::new(seed.child("report"));
    let mut drove: BTreeMap<(&str, &str), bool> = BTreeMap::new();
    let mut file = folder.stream("episodes", super::episodes(&[]).schema())?;
    for run in episodes.runs() {
        let evaluation = run.evaluation;
        let mut whole: Option<DataFrame> = None;
        for part in run.parts() {
            let part = part.map_err(failed)?;
            file.add(&part)?;
            gathered.tally.add(&part).map_err(failed)?;
            let drives = gathered.count(&run, &part).map_err(failed)?;
            *drove.entry((&evaluation.town, &evaluation.policy)).or_default() |= drives;
            match &mut whole {
                Some(whole) => drop(whole.vstack_mut(&part).map_err(failed)?),
                None => whole = Some(part),
            }
        }
        let Some(mut whole) = whole else {
            gathered.all_tried = false;
            continue;
        };
        gathered.all_tried &= is_finished(evaluation, &whole).map_err(failed)?;
        // Sums must not hang on how many pieces there were.
        whole.rechunk_mut();
        gathered.runs.vstack_mut(&runs(&whole).map_err(failed)?).map_err(failed)?;
        if evaluation.pedestrian.name() == "trained" {
            gathered.note_starts(evaluation, &whole).map_err(failed)?;
        }
        kinds.add(&whole).map_err(failed)?;
        evidence.add(&whole).map_err(failed)?;
    }
    gathered.runs.rechunk_mut();
    gathered.every_driver_drove = drove.values().all(|drove| *drove);
    file.finish()?;
    gathered.evidence = evidence.finish();
    Ok(gathered)
}

/// Whether a run has all its episodes, or as many as its stopping rule asks for.
fn is_finished(evaluation: &Evaluation, run: &DataFrame) -> PolarsResult<bool> {
    let errors = text(run, "outcome")?.iter().filter(|outcome| *outcome == Some("error")).count();
    let collisions = truth(run, "collision")?.sum().unwrap_or_default();
    Ok(evaluation.is_finished_with(run.height() as u32, (run.height() - errors) as u64, collisions.into()))
}

impl Gathered {
    /// Counts what is in a table of episodes; says whether the driver drove any to its end.
    fn count(&mut self, run: &Run<'_>, part: &DataFrame) -> PolarsResult<bool> {
        let Evaluation { town, policy, trained, .. } = run.evaluation;
        let (outcomes, errors) = (text(part, "outcome")?, text(part, "error")?);
        let (episodes, rewards) = (count(part, "episode")?, number(part, "episode_reward")?);
        let ticks = count(part, "ticks")?;
        let mut drives = false;
        for row in 0..part.height() {
            let episode = episodes.get(row).unwrap_or_default();
            if outcomes.get(row) == Some("error") {
                self.errors += 1;
                self.untried += u64::from(ticks.get(row).is_none());
                let error = errors.get(row).unwrap_or_default();
                self.first_error.get_or_insert_with(|| format!("episode {episode} in {town}: {policy} {error}"));
                continue;
            }
            drives = true;
            if let Some(reward) = rewards.get(row).filter(|reward| !reward.is_finite()) {
                self.unpaid += 1;
                self.first_unpaid.get_or_insert_with(|| {
                    format!("`{}` was {reward} in episode {episode} in {town} against {policy}", trained.reward)
                });
            }
        }
        self.episodes += part.height() as u64;
        self.ticks += ticks.iter().flatten().map(u64::from).sum::<u64>();
        Ok(drives)
    }

    /// Notes the places where a run began.
    fn note_starts(&mut self, evaluation: &Evaluation, run: &DataFrame) -> PolarsResult<()> {
        let columns = Columns::new(run)?;
        let starts = self.starts.entry(evaluation.town.to_string()).or_default();
        for row in 0..run.height() {
            let Some(outcome) = columns.outcome(row) else { continue };
            let episode = columns.episode.get(row).unwrap_or_default();
            starts.add((&evaluation.policy, evaluation.block, episode), &outcome);
        }
        Ok(())
    }
}

fn text<'a>(table: &'a DataFrame, name: &str) -> PolarsResult<&'a StringChunked> {
    table.column(name)?.str()
}

fn count<'a>(table: &'a DataFrame, name: &str) -> PolarsResult<&'a UInt32Chunked> {
    table.column(name)?.u32()
}

fn number<'a>(table: &'a DataFrame, name: &str) -> PolarsResult<&'a Float64Chunked> {
    table.column(name)?.f64()
}

fn truth<'a>(table: &'a DataFrame, name: &str) -> PolarsResult<&'a BooleanChunked> {
    table.column(name)?.bool()
}

/// The columns of a table of episodes that make an outcome.
struct Columns<'a> {
    episode: &'a UInt32Chunked,
    outcome: &'a StringChunked,
    mode: &'a StringChunked,
    digest: &'a StringChunked,
    trail: &'a StringChunked,
    ticks: &'a UInt32Chunked,
    front: &'a BooleanChunked,
    moving: &'a BooleanChunked,
    /// Impact speed and bearing, reward, length, gap; ego's x, y, yaw, speed; pedestrian's x, y, yaw.
    numbers: [&'a Float64Chunked; 12],
}

impl<'a> Columns<'a> {
    fn new(table: &'a DataFrame) -> PolarsResult<Self> {
        let number = |name| number(table, name);
        Ok(Self {
            episode: count(table, "episode")?,
            outcome: text(table, "outcome")?,
            mode: text(table, "driving_mode")?,
            digest: text(table, "digest")?,
            trail: text(table, "trail")?,
            ticks: count(table, "ticks")?,
            front: truth(table, "front")?,
            moving: truth(table, "moving")?,
            numbers: [
                number("impact_speed_mps")?,
                number("impact_bearing_deg")?,
                number("episode_reward")?,
                number("episode_length_s")?,
                number("least_gap_m")?,
                number("ego_x_m")?,
                number("ego_y_m")?,
                number("ego_yaw_deg")?,
                number("ego_speed_mps")?,
                number("pedestrian_x_m")?,
                number("pedestrian_y_m")?,
                number("pedestrian_yaw_deg")?,
            ],
        })
    }

    /// What became of an episode; none when it is in error.
    fn outcome(&self, row: usize) -> Option<Outcome> {
        let [impact_speed, bearing, reward, duration, least_gap, ex, ey, eyaw, ego_speed, px, py, pyaw] =
            self.numbers.map(|column| column.get(row).unwrap_or_default());
        let ending = match self.outcome.get(row)? {
            "collision" => Ending::Collision {
                front: self.front.get(row)?,
                moving: self.moving.get(row)?,
                impact_speed,
                bearing: bearing.to_radians(),
            },
            "lost" => Ending::Lost,
            "timeout" => Ending::Timeout,
            _ => return None,
        };
        let ego = Pose::new(ex, ey, eyaw.to_radians());
        let spawn = Spawn { ego, ego_speed, pedestrian: Pose::new(px, py, pyaw.to_radians()) };
        let last_mode = DrivingMode::named(self.mode.get(row)?)?;
        let digest = u64::from_str_radix(self.digest.get(row)?, 16).ok()?;
        let trail = self.trail.get(row).and_then(|trail| trail.parse().ok()).unwrap_or_default();
        let ticks = self.ticks.get(row)?;
        Some(Outcome { spawn, ending, reward, ticks, duration, least_gap, last_mode, digest, trail })
    }
}
