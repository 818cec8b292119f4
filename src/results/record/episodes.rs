use polars::prelude::{Column as Values, DataFrame};

use super::columns::{
    AVOIDABLE_INJURY, AVOIDS, BLOCK, BODY, COUNTS_AS, DIGEST, DRIVER, DRIVING_MODE, EGO_SPEED, EGO_X, EGO_Y, EGO_YAW,
    EPISODE, EPISODE_LENGTH, EPISODE_REWARD, ERROR, FALSE_BRAKE, FAULT, FORESEEABLE, FRONT, IMPACT, IMPACT_SPEED,
    IN_SIGHT, LATEST_REACTION, LEFT_LANE, LEFT_OUT, LEFT_ROAD, MIN_GAP, MIN_TTC, ON_CROSSWALK, OUTCOME, PEDESTRIAN,
    PEDESTRIAN_X, PEDESTRIAN_Y, PEDESTRIAN_YAW, PET, PLACED, PREVENTABLE_PROBABILITY, RESTS_ON, REWARD, RUN, RUN_ID,
    START, STATE_HASHES, TICKS, TOWN, TRAIN_DRIVER, TRAIN_TOWN, VEHICLE, VERDICT, WALKED_INTO, WORLD,
};
use super::{CellKey, Entry, EpisodeRow, RunKey, Table, TableReference};
use episode::{Ending, Impact, LeftOut, Outcome};
use verdict::{LaneDeparture, NearMiss, Reference, RestsOn, Verdict};

/// The stem of the files of the table of episodes.
pub const EPISODES: &str = "episodes";

/// The columns of a cell's key, for a table whose rows have one.
pub fn cell_key<'t, R>(key: impl Fn(&R) -> &CellKey + Copy + 't) -> [Entry<'t, R>; 10] {
    [
        REWARD.of(move |row| key(row).reward.clone()),
        TRAIN_TOWN.of(move |row| key(row).train_town.clone()),
        TRAIN_DRIVER.of(move |row| key(row).train_policy.clone()),
        PEDESTRIAN.of(move |row| key(row).controller.clone()),
        TOWN.of(move |row| key(row).town.clone()),
        DRIVER.of(move |row| key(row).policy.clone()),
        VEHICLE.of(move |row| key(row).vehicle.clone()),
        BODY.of(move |row| key(row).adversary.clone()),
        WORLD.of(move |row| key(row).world.clone()),
        BLOCK.of(move |row| key(row).block),
    ]
}

/// The columns of a run's key in the table of episodes.
fn run_key<'t, R>(key: impl Fn(&R) -> &RunKey + Copy + 't) -> Vec<Entry<'t, R>> {
    let mut entries = vec![RUN_ID.of(move |row: &R| key(row).id.to_string())];
    entries.extend(cell_key(move |row| &key(row).cell));
    entries.insert(4, RUN.of(move |row| key(row).run));
    entries
}

/// The key of a run, `rows` times.
pub(super) fn repeated_key(key: &RunKey, rows: usize) -> Vec<Values> {
    run_key(|key: &RunKey| key).iter().map(|entry| entry.repeated(key, rows)).collect()
}

/// The table of episodes as it is in memory: a row for each, first the key of its run.
pub fn episode_table() -> Table<'static, EpisodeRow> {
    Table::new(EPISODES, "").columns(run_key(|row: &EpisodeRow| &*row.key)).columns(outcome_table().entries)
}

/// The columns of the files of episodes. The table has more, which `failures` shows and `metrics` sums up.
pub fn episode_references() -> TableReference {
    let doc = "One row for each episode. Episodes with equal numbers in one town have equal starts for all pedestrians and drivers (equal `start`), so rows can be paired. \
               `failures` has more of those in which something failed, the manifest block, vehicle and body of `run_id`.";
    let of_manifest = [BLOCK.name, VEHICLE.name, BODY.name];
    let mut table =
        Table::new(EPISODES, doc).columns(run_key(|row: &EpisodeRow| &*row.key)).columns(shown()).reference();
    table.columns.retain(|column| !of_manifest.contains(&&*column.name));
    table
}

/// Episodes as a table, one row each, in the order given.
pub fn episodes(rows: &[EpisodeRow]) -> DataFrame {
    episode_table().frame(rows)
}

/// The columns that files have, after the key.
fn shown() -> Vec<Entry<'static, EpisodeRow>> {
    vec![
        EPISODE.of(|row: &EpisodeRow| row.episode),
        OUTCOME.of(|row: &EpisodeRow| ending(&row.judged.outcome.ending)),
        ERROR.of(|row: &EpisodeRow| why_in_error(&row.judged.outcome)),
        LEFT_OUT.of(|row: &EpisodeRow| row.judged.outcome.left_out.map_or("", LeftOut::name)),
        FAULT.of(|row| struck(row).is_some_and(|verdict| verdict.is_fault())),
        EPISODE_REWARD.of(|row: &EpisodeRow| row.judged.outcome.reward),
        EPISODE_LENGTH.of(|row: &EpisodeRow| row.judged.outcome.duration),
        MIN_GAP.of(|row: &EpisodeRow| row.judged.outcome.least_gap),
        MIN_TTC.of(|row| near_miss(row).min_ttc),
        PET.of(|row| near_miss(row).pet),
        LEFT_LANE.of(|row| lane(row).map(|lane| lane.left_lane)),
        LEFT_ROAD.of(|row| lane(row).map(|lane| lane.left_road)),
        EGO_X.of(|row: &EpisodeRow| row.judged.outcome.spawn.ego.x),
        EGO_Y.of(|row: &EpisodeRow| row.judged.outcome.spawn.ego.y),
        EGO_YAW.of(|row: &EpisodeRow| row.judged.outcome.spawn.ego.yaw.to_degrees()),
        EGO_SPEED.of(|row: &EpisodeRow| row.judged.outcome.spawn.ego_speed),
        PEDESTRIAN_X.of(|row: &EpisodeRow| row.judged.outcome.spawn.pedestrian.x),
        PEDESTRIAN_Y.of(|row: &EpisodeRow| row.judged.outcome.spawn.pedestrian.y),
        PEDESTRIAN_YAW.of(|row: &EpisodeRow| row.judged.outcome.spawn.pedestrian.yaw.to_degrees()),
        START.of(|row: &EpisodeRow| format!("{:016x}", row.judged.outcome.start)),
        DIGEST.of(|row: &EpisodeRow| format!("{:016x}", row.judged.outcome.digest)),
    ]
}

/// The part of the table of episodes that is stored: the episodes without the key of their run, which the plan has.
///
/// A new quantity of an episode is one entry here or among those that files have; [`metrics`](super::metric::metrics) has what runs and cells make of it.
pub(super) fn outcome_table() -> Table<'static, EpisodeRow> {
    let verdict = |row: &EpisodeRow| row.judged.verdict;
    Table::new(EPISODES, "")
        .columns(shown())
        .column(FRONT.of(|row: &EpisodeRow| matches!(row.judged.outcome.ending, Ending::Touch { front: true, .. })))
        .column(IMPACT.of(|row: &EpisodeRow| Impact::of(&row.judged.outcome).map(Impact::name)))
        .column(IMPACT_SPEED.of(|row: &EpisodeRow| row.judged.outcome.impact_speed()))
        .column(TICKS.of(|row: &EpisodeRow| row.judged.outcome.ticks))
        .column(ON_CROSSWALK.of(|row: &EpisodeRow| touched(row).then_some(row.judged.outcome.on_crosswalk)))
        .column(DRIVING_MODE.of(|row: &EpisodeRow| row.judged.outcome.last_mode.name()))
        .column(PLACED.of(placed))
        .column(STATE_HASHES.of(|row| touched(row).then(|| row.judged.outcome.state_hashes.to_string())))
        .column(VERDICT.of(move |row| verdict(row).map(|verdict| verdict.label.name())))
        .column(FORESEEABLE.of(|row| struck(row).map(|verdict| verdict.foreseeable)))
        .column(COUNTS_AS.of(move |row| verdict(row).map(|verdict| verdict.class().name())))
        .column(AVOIDABLE_INJURY.of(|row| struck(row).map(|verdict| verdict.avoidable_injury())))
        .column(LATEST_REACTION.of(|row| struck(row).and_then(|verdict| verdict.latest_reaction)))
        .column(RESTS_ON.of(|row| struck(row).and_then(|verdict| verdict.rests_on).map(RestsOn::name)))
        .column(PREVENTABLE_PROBABILITY.of(|row| struck(row).map(|verdict| verdict.preventable_probability())))
        .column(WALKED_INTO.of(|row| struck(row).map(|verdict| verdict.walked_into)))
        .column(IN_SIGHT.of(move |row| verdict(row).map(|verdict| verdict.sight.seen)))
        .columns(reference_drivers())
}

/// The verdict on a collision; `None` of a bump and without a touch.
fn struck(row: &EpisodeRow) -> Option<Verdict> {
    row.judged.verdict.filter(|verdict| !verdict.is_bump())
}

fn touched(row: &EpisodeRow) -> bool {
    row.judged.outcome.is_touch()
}

/// What the reference drivers did.
fn reference_drivers() -> Vec<Entry<'static, EpisodeRow>> {
    let of = |reference: Reference| {
        let name = reference.name();
        [
            AVOIDS.of(name, move |row: &EpisodeRow| Some(row.judged.verdict?.trial(reference).is_avoided())),
            FALSE_BRAKE.of(name, move |row: &EpisodeRow| Some(row.false_alarms?.braked(reference))),
        ]
    };
    Reference::ALL.into_iter().flat_map(of).collect()
}

/// Whether the driver did not arrive at its start; `None` without a run-up.
fn placed(row: &EpisodeRow) -> Option<bool> {
    (row.judged.outcome.run_up > 0).then_some(row.judged.outcome.spawn.ego_speed == 0.0)
}

/// The near-miss figures of an episode; `None` for one in error, whose driver did not reach the end.
fn near_miss(row: &EpisodeRow) -> NearMiss {
    if row.judged.outcome.fault().is_some() { NearMiss::default() } else { row.near_miss }
}

/// Whether the car stayed in its lane; `None` for an episode in error.
fn lane(row: &EpisodeRow) -> Option<LaneDeparture> {
    row.lane.filter(|_| row.judged.outcome.fault().is_none())
}

/// The value of `outcome` for an episode in error.
pub const IN_ERROR: &str = named::ERROR;

/// The names of endings in tables.
pub mod named {
    pub const COLLISION: &str = "collision";
    pub const BUMP: &str = "bump";
    pub const OTHER_CONTACT: &str = "other_contact";
    pub const LOST: &str = "lost";
    pub const TIMEOUT: &str = "timeout";
    pub const ERROR: &str = "error";

    /// Whether it is one of the two in which car and pedestrian touched.
    pub fn is_touch(outcome: &str) -> bool {
        [COLLISION, BUMP].contains(&outcome)
    }
}

/// The cause of an episode in error; empty for others. A driver's has no subject, a controller's names the controller.
fn why_in_error(outcome: &Outcome) -> String {
    match outcome.ending {
        Ending::ControllerError(_) | Ending::WorldError(_) => outcome.error().unwrap_or_default(),
        _ => outcome.fault().map_or(String::new(), |fault| fault.to_string()),
    }
}

fn ending(ending: &Ending) -> &'static str {
    match ending {
        Ending::Touch { moving: true, .. } => named::COLLISION,
        Ending::Touch { moving: false, .. } => named::BUMP,
        Ending::OtherContact { .. } => named::OTHER_CONTACT,
        Ending::Lost => named::LOST,
        Ending::Timeout => named::TIMEOUT,
        Ending::Error(_) | Ending::ControllerError(_) | Ending::WorldError(_) => named::ERROR,
    }
}
