//! The columns that several tables share, and those that are read back. Each is named only here.

use super::{Column, Family, Role};

pub const RUN_ID: Column<String> = Column::new(
    "run_id",
    "",
    "short name of the run or of the search; 32 bits of BLAKE3 over its names, the campaign's included, the seed and what the files \
     and settings say about it. Episode 17 of run `1a2b3c4d` is called `1a2b3c4d:17`",
);
pub const REWARD: Column<String> = Column::new(
    "reward",
    "",
    "reward of the training; of an untrained pedestrian, the reward that is counted here; `none` in a campaign without training",
);
pub const TRAIN_TOWN: Column<String> =
    Column::new("train_town", "", "town of the training; empty for untrained pedestrians");
pub const TRAIN_DRIVER: Column<String> =
    Column::new("train_driver", "", "driver of the training; empty for untrained pedestrians");
pub const RUN: Column<u32> =
    Column::new("run", "", "number of the run, from 0; of a trained pedestrian that of its training");
pub const PEDESTRIAN: Column<String> = Column::new(
    "pedestrian",
    "",
    "the pedestrian, by what moves it; `trained` (the mean of its policy), `stochastic` (draws from its policy, as in training), `untrained` \
     (the mean of the policy with which its training begins), `random` (each command uniform), `homing` (walks straight at the car, as fast as it can), `intercept` (walks to where it would meet a car that keeps its \
     velocity)",
);
pub const TOWN: Column<String> = Column::new("town", "", "town of the episodes");
pub const DRIVER: Column<String> = Column::new("driver", "", "the driver");
pub const VEHICLE: Column<String> = Column::new("vehicle", "", "model of the car");
pub const BODY: Column<String> = Column::new("body", "", "body of the pedestrian");
pub const WORLD: Column<String> = Column::new(
    "world",
    "",
    "simulator in which the car drove; `here` is that of this program, others are the `world` of that name",
);
pub const BLOCK: Column<u32> = Column::new("block", "", "number of the `evaluate` block in its campaign, from 0");
pub const EPISODE: Column<u32> =
    Column::new("episode", "", "number of the episode, from 0; equal numbers of a place have equal starts");

pub const NUMBER: Column<u64> = Column::new(
    "number",
    "",
    "number of the episode, or of the failure in its search, from 0; `RUN_ID:NUMBER` is the name of a failure",
);

pub const OUTCOME: Column<String> = Column::new(
    "outcome",
    "",
    "`collision` (the moving car touched the pedestrian), `bump` (the pedestrian touched the standing car), `timeout`, `lost` (the scenario's `end_when` was true, or the test of a protocol was over), or `error` (a driver or pedestrian failed as a program)",
);
pub const ERROR: Column<String> =
    Column::new("error", "", "why the driver, or `the pedestrian`, failed; empty otherwise");
pub const LEFT_OUT: Column<String> = Column::new(
    "left_out",
    "",
    "why the row is in no rate, comparison, gate or list of failures; `run_up` (the driver did not reach its start in the run-up), `off_road` \
     (the car left the road before it could see a pedestrian) or `road_end` (the car drove past the end of a lane that leads nowhere); empty for a row that counts",
);
pub const FRONT: Column<bool> =
    Column::new("front", "", "whether they touched within the front sector, by the bearing from the car's middle");
pub const IMPACT_SPEED: Column<f64> = Column::new("impact_speed_mps", "m/s", "speed of the car at the touch");
pub const EPISODE_REWARD: Column<f64> = Column::new("episode_reward", "", "sum of the rewards");
pub const EPISODE_LENGTH: Column<f64> = Column::new("episode_length_s", "s", "time until the touch or the end");
pub const TICKS: Column<u32> = Column::new("ticks", "", "simulator ticks");
pub const MIN_GAP: Column<f64> =
    Column::new("least_gap_m", "m", "least distance from the pedestrian's disc to the car's box; 0 at a collision");
pub const ON_CROSSWALK: Column<bool> =
    Column::new("on_crosswalk", "", "whether the pedestrian was on a crosswalk at the collision; missing without one");
pub const MIN_TTC: Column<f64> = Column::new(
    "min_ttc_s",
    "s",
    "least time to collision of disc and box at constant velocities, over all ticks at which the car moves (more than 0.1 m/s); 0 \
     after a collision, missing if they never were on course to touch within 10 s",
);
pub const PET: Column<f64> = Column::new(
    "pet_s",
    "s",
    "post-encroachment time at the ticks, up to two of them too long; the least time between one leaving a place and the other \
     reaching it, over all places that disc and box both sweep; missing without such a place and at a collision",
);
pub const DRIVING_MODE: Column<String> = Column::new("driving_mode", "", "what the driver did in the last tick");
pub const IMPACT: Column<String> = Column::new("impact", "", "side of the impact: `front`, `left`, `right` or `rear`");
pub const EGO_X: Column<f64> = Column::new("ego_x_m", "m", "start of the car, in the world frame");
pub const EGO_Y: Column<f64> = Column::new("ego_y_m", "m", EGO_X.doc);
pub const EGO_YAW: Column<f64> = Column::new("ego_yaw_deg", "deg", "heading of the car at the start");
pub const EGO_SPEED: Column<f64> = Column::new("ego_speed_mps", "m/s", "speed of the car at the start");
pub const PLACED: Column<bool> = Column::new(
    "placed",
    "",
    "whether the driver did not reach the start within the time of a run-up, so that it starts there at rest; missing without a run-up",
);
pub const LEFT_LANE: Column<f64> = Column::new(
    "left_lane_s",
    "s",
    "time in which the centre of the car was outside its lane; more than 0.1 m beyond the edge of a driving lane that leads its way; in a junction, of \
     all lanes that lead on from the lane by which it came. A lane beside it with the same direction is not another lane",
);
pub const LEFT_ROAD: Column<bool> = Column::new(
    "left_road",
    "",
    "whether the centre of the car was outside all driving lanes, by more than 0.1 m, at the start or later",
);
pub const START: Column<String> = Column::new(
    "start",
    "",
    "hash of the start as it was drawn, before the driver had any influence: rows with the same number and hash have the same start",
);
pub const PEDESTRIAN_X: Column<f64> = Column::new("pedestrian_x_m", "m", "start of the pedestrian, in the world frame");
pub const PEDESTRIAN_Y: Column<f64> = Column::new("pedestrian_y_m", "m", PEDESTRIAN_X.doc);
pub const PEDESTRIAN_YAW: Column<f64> =
    Column::new("pedestrian_yaw_deg", "deg", "heading of the pedestrian at the start");
pub const DIGEST: Column<String> =
    Column::new("digest", "", "hash of every state of the episode; equal digests mean equal episodes");
pub const STATE_HASHES: Column<String> = Column::new(
    "state_hashes",
    "",
    "of a touch the digest at marks; the number of decisions from mark to mark, a colon, and a byte of the digest at each mark. It shows where a \
     repetition diverges",
);

pub const VERDICT: Column<String> = Column::new(
    "verdict",
    "",
    "what the reference drivers say of a touch, see [Was it avoidable?](#was-it-avoidable); missing without a touch",
);
pub const FORESEEABLE: Column<bool> = Column::new(
    "foreseeable",
    "",
    "whether the pedestrian moved as people do in the last 3 s before the touch; not faster than 8 km/h unless it kept its velocity, its velocity changed by \
     at most 2.12 m/s² over 0.5 s and by at most 1.65 m/s within any second (Euro NCAP's running adult, and recorded walking). Turning and \
     stopping are acceleration",
);
pub const FAULT: Column<bool> = Column::new(
    "fault",
    "",
    "whether it counts against the driver; all careful drivers avoid it with 0.1 m to spare, the pedestrian moved as people do, and the car drove \
     at 1 m/s or more, on whichever side the collision was, and was not walked into at the flank or rear after the front had passed; of a violation, whether both careful \
     humans satisfy the requirement from the start of the danger on and the pedestrian moved as people do",
);
pub const COUNTS_AS: Column<String> = Column::new(
    "counts_as",
    "",
    "`fault`, or the first reason why it is none; `bump` (the car stood), `not_preventable`, `unforeseeable`, `flank` (the pedestrian walked \
     into the flank or the rear), `slow` (below 1 m/s), `narrow` (a careful human has less than 0.1 m to spare), `followed` (a car behind runs into that of a careful human who brakes). `runner` is a fault, too: somebody faster than 8 km/h at a steady speed",
);
pub const AVOIDABLE_INJURY: Column<f64> = Column::new(
    "avoidable_injury",
    "",
    "of a fault the risk of an injury of AIS 4 or more or of death at its speed, which a careful human would have spared the pedestrian; otherwise 0",
)
.with_role(Role::Risk);
pub const IN_SIGHT: Column<f64> = Column::new(
    "in_sight_s",
    "s",
    "time in sight without a break before the touch, 3 s at most; before its start, a shorter episode counts as in sight",
);
pub const WALKED_INTO: Column<bool> = Column::new(
    "walked_into_car",
    "",
    "whether the pedestrian walked into the flank at more than 0.1 m/s, or ran into the rear, after the front had passed it",
);
pub const LATEST_REACTION: Column<f64> = Column::new(
    "latest_reaction_s",
    "s",
    "longest reaction time, counted from the gate, with which a driver who brakes like `cc` avoids the collision, 5 s at most; missing when \
     it collides even without any, and for a bump",
);
pub const RESTS_ON: Column<String> = Column::new(
    "rests_on",
    "",
    "on what of the humans' gate it rests that a collision is preventable: `anticipation` (they brake for somebody not yet in the path), `early_gate` (more than 2 s \
     before), `both` or `neither`; missing unless it is",
);
pub const PREVENTABLE_PROBABILITY: Column<f64> =
    Column::new("preventable_probability", "", "share of drivers who react within that time").with_role(Role::Share);
pub const AVOIDS: Family<bool> =
    Family::new("_avoids", "", "whether that reference driver touches no pedestrian while it moves");
pub const FALSE_BRAKE: Family<bool> = Family::new(
    "_false_brake",
    "",
    "whether that reference driver would have braked needlessly: in an approach in which a car that keeps its pace does not touch the \
     pedestrian either; missing with a collision and in error",
);
