use polars::prelude::{DataFrame, PolarsResult};

use crate::analysis::{Failure, Impact, Kind};
use crate::av::DrivingMode;
use crate::compile::Evaluation;
use crate::env::Spawn;
use crate::geometry::Pose;
use crate::judge::{Label, Sight};

/// Most collisions of a cell that are looked at, the first ones of each of its runs.
pub const MOST_FAILURES: usize = 20_000;
/// Most episodes of a cell that are explained, the first ones of each of its runs.
pub const MOST_CASES: usize = 6_000;

/// A collision with what tells whether it has been repeated.
#[derive(Debug, Clone)]
pub struct Sampled {
    pub failure: Failure,
    /// The digest of its episode.
    pub digest: String,
}

/// How an episode began and ended.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub episode: u32,
    pub spawn: Spawn,
    pub collision: bool,
    pub preventable: bool,
}

/// A run of a cell, as far as it is looked at.
#[derive(Debug, Clone)]
pub struct RunSample<'a> {
    pub evaluation: &'a Evaluation,
    /// The name under which its episodes can be found.
    pub name: String,
    /// How many episodes and collisions it has, without those in which the driver failed.
    pub all: (u64, u64),
    /// How many of its first episodes were looked at for collisions; all of these are in the list.
    pub episodes: u64,
    pub failures: Vec<Sampled>,
    pub cases: Vec<Case>,
}

impl<'a> RunSample<'a> {
    /// Takes a part of a run's episodes, one of so many runs of its cell.
    pub fn new(evaluation: &'a Evaluation, runs: usize, frame: &DataFrame) -> PolarsResult<Self> {
        let text = |name: &str| frame.column(name).and_then(|column| column.str().cloned());
        let number = |name: &str| frame.column(name).and_then(|column| column.f64().cloned());
        let truth = |name: &str| frame.column(name).and_then(|column| column.bool().cloned());
        let episodes = frame.column("episode")?.u32()?.clone();
        let (outcome, mode, digest, verdict) =
            (text("outcome")?, text("driving_mode")?, text("digest")?, text("verdict")?);
        let (front, moving) = (truth("front")?, truth("moving")?);
        let (speed, bearing, length) =
            (number("impact_speed_mps")?, number("impact_bearing_deg")?, number("episode_length_s")?);
        let in_sight = number("in_sight_s")?;
        let places = ["ego_x_m", "ego_y_m", "ego_yaw_deg", "ego_speed_mps", "pedestrian_x_m", "pedestrian_y_m"];
        let places: Vec<_> = places.iter().map(|name| number(name)).collect::<PolarsResult<_>>()?;
        let yaw = number("pedestrian_yaw_deg")?;
        let name = frame.column("run_id").ok().and_then(|column| column.str().ok()?.get(0).map(String::from));
        let mut sample = Self {
            evaluation,
            name: name.unwrap_or_else(|| format!("run {}", evaluation.trained.run)),
            all: (0, 0),
            episodes: 0,
            failures: Vec::new(),
            cases: Vec::new(),
        };
        let (failures, cases) = (MOST_FAILURES.div_ceil(runs), MOST_CASES.div_ceil(runs));
        for row in 0..frame.height() {
            let outcome = outcome.get(row).unwrap_or_default();
            if outcome == "error" {
                continue;
            }
            let of = |column: &polars::prelude::Float64Chunked| column.get(row).unwrap_or_default();
            let (episode, collision) = (episodes.get(row).unwrap_or_default(), outcome == "collision");
            sample.all = (sample.all.0 + 1, sample.all.1 + u64::from(collision));
            let label = verdict.get(row).and_then(Label::named);
            if sample.cases.len() < cases {
                let pose = |i: usize, yaw: f64| Pose::new(of(&places[i]), of(&places[i + 1]), yaw.to_radians());
                sample.cases.push(Case {
                    episode,
                    spawn: Spawn {
                        ego: pose(0, of(&places[2])),
                        ego_speed: of(&places[3]),
                        pedestrian: pose(4, of(&yaw)),
                    },
                    collision,
                    preventable: label == Some(Label::Preventable),
                });
            }
            if sample.failures.len() == failures {
                continue;
            }
            sample.episodes += 1;
            let Some(label) = label else { continue };
            let kind = Kind {
                impact: Impact::new(front.get(row).unwrap_or_default(), of(&bearing).to_radians()),
                moving: moving.get(row).unwrap_or_default(),
                verdict: label,
                occluded: Sight { hidden: 0.0, seen: of(&in_sight) }.is_occluded(),
                mode: mode.get(row).and_then(DrivingMode::named).unwrap_or(DrivingMode::Unknown),
            };
            let failure = Failure {
                run: evaluation.trained.run,
                episode,
                kind,
                impact_speed: of(&speed),
                length: of(&length),
                approach: None,
            };
            sample.failures.push(Sampled { failure, digest: digest.get(row).unwrap_or_default().into() });
        }
        Ok(sample)
    }
}
