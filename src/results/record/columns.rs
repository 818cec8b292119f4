//! The columns that several tables share, and those that are read back. Each is named only here.

use super::{Column, columns};

columns! {
    /// short name of the run or of the search; 32 bits of BLAKE3 over its names, the campaign's included, the seed and what the files and settings say about
    /// it. Episode 17 of run `1a2b3c4d` is called `1a2b3c4d:17`
    pub RUN_ID: Column<String> = "run_id";
    /// reward of the training; of an untrained pedestrian, the reward that is counted here; `none` in a campaign without training
    pub REWARD: Column<String> = "reward";
    /// town of the training; empty for untrained pedestrians
    pub TRAIN_TOWN: Column<String> = "train_town";
    /// driver of the training; empty for untrained pedestrians
    pub TRAIN_DRIVER: Column<String> = "train_driver";
    /// number of the run, from 0; of a trained pedestrian that of its training
    pub RUN: Column<u32> = "run";
    /// the pedestrian, by what moves it; `trained` (the mean of its policy), `stochastic` (draws from its policy, as in training), `untrained` (the mean of
    /// the policy with which its training begins), `random` (each command uniform), `homing` (walks straight at the car, as fast as it can), `intercept`
    /// (walks to where it would meet a car that keeps its velocity)
    pub PEDESTRIAN: Column<String> = "pedestrian";
    /// town of the episodes
    pub TOWN: Column<String> = "town";
    /// the driver
    pub DRIVER: Column<String> = "driver";
    /// model of the car
    pub VEHICLE: Column<String> = "vehicle";
    /// body of the pedestrian
    pub BODY: Column<String> = "body";
    /// simulator in which the car drove; `here` is that of this program, others are the `world` of that name
    pub WORLD: Column<String> = "world";
    /// number of the `evaluate` block in its campaign, from 0
    pub BLOCK: Column<u32> = "block";
    /// number of the episode, from 0; equal numbers of a place have equal starts
    pub EPISODE: Column<u32> = "episode";

    /// number of the episode, or of the failure in its search, from 0; `RUN_ID:NUMBER` is the name of a failure
    pub NUMBER: Column<u64> = "number";

    /// `collision` (the moving car touched the pedestrian), `bump` (the pedestrian touched the standing car), `timeout`, `lost` (the scenario's `end_when`
    /// was true, or the test of a protocol was over), or `error` (a driver or pedestrian failed as a program)
    pub OUTCOME: Column<String> = "outcome";
    /// why the driver, or `the pedestrian`, failed; empty otherwise
    pub ERROR: Column<String> = "error";
    /// why the row is in no rate, comparison, gate or list of failures; `run_up` (the driver did not reach its start in the run-up), `off_road` (the car left
    /// the road before it could see a pedestrian) or `road_end` (the car drove past the end of a lane that leads nowhere); empty for a row that counts
    pub LEFT_OUT: Column<String> = "left_out";
    /// whether they touched within the front sector, by the bearing from the car's middle
    pub FRONT: Column<bool> = "front";
    /// speed of the car at the touch
    pub IMPACT_SPEED: Column<f64> = "impact_speed_mps" ["m/s"];
    /// sum of the rewards
    pub EPISODE_REWARD: Column<f64> = "episode_reward";
    /// time until the touch or the end
    pub EPISODE_LENGTH: Column<f64> = "episode_length_s" ["s"];
    /// simulator ticks
    pub TICKS: Column<u32> = "ticks";
    /// least distance from the pedestrian's disc to the car's box; 0 at a collision
    pub MIN_GAP: Column<f64> = "least_gap_m" ["m"];
    /// whether the pedestrian was on a crosswalk at the collision; missing without one
    pub ON_CROSSWALK: Column<bool> = "on_crosswalk";
    /// least time to collision of disc and box at constant velocities, over all ticks at which the car moves (more than 0.1 m/s); 0 after a collision,
    /// missing if they never were on course to touch within 10 s
    pub MIN_TTC: Column<f64> = "min_ttc_s" ["s"];
    /// post-encroachment time at the ticks, up to two of them too long; the least time between one leaving a place and the other reaching it, over all places
    /// that disc and box both sweep; missing without such a place and at a collision
    pub PET: Column<f64> = "pet_s" ["s"];
    /// what the driver did in the last tick
    pub DRIVING_MODE: Column<String> = "driving_mode";
    /// side of the impact: `front`, `left`, `right` or `rear`
    pub IMPACT: Column<String> = "impact";
    /// start of the car, in the world frame
    pub EGO_X: Column<f64> = "ego_x_m" ["m"];
}
pub const EGO_Y: Column<f64> = Column::new("ego_y_m", "m", EGO_X.doc);
columns! {
    /// heading of the car at the start
    pub EGO_YAW: Column<f64> = "ego_yaw_deg" ["deg"];
    /// speed of the car at the start
    pub EGO_SPEED: Column<f64> = "ego_speed_mps" ["m/s"];
    /// whether the driver did not reach the start within the time of a run-up, so that it starts there at rest; missing without a run-up
    pub PLACED: Column<bool> = "placed";
    /// time in which the centre of the car was outside its lane; more than 0.1 m beyond the edge of a driving lane that leads its way; in a junction, of all
    /// lanes that lead on from the lane by which it came. A lane beside it with the same direction is not another lane
    pub LEFT_LANE: Column<f64> = "left_lane_s" ["s"];
    /// whether the centre of the car was outside all driving lanes, by more than 0.1 m, at the start or later
    pub LEFT_ROAD: Column<bool> = "left_road";
    /// hash of the start as it was drawn, before the driver had any influence: rows with the same number and hash have the same start
    pub START: Column<String> = "start";
    /// start of the pedestrian, in the world frame
    pub PEDESTRIAN_X: Column<f64> = "pedestrian_x_m" ["m"];
}
pub const PEDESTRIAN_Y: Column<f64> = Column::new("pedestrian_y_m", "m", PEDESTRIAN_X.doc);
columns! {
    /// heading of the pedestrian at the start
    pub PEDESTRIAN_YAW: Column<f64> = "pedestrian_yaw_deg" ["deg"];
    /// hash of every state of the episode; equal digests mean equal episodes
    pub DIGEST: Column<String> = "digest";
    /// of a touch the digest at marks; the number of decisions from mark to mark, a colon, and a byte of the digest at each mark. It shows where a repetition
    /// diverges
    pub STATE_HASHES: Column<String> = "state_hashes";

    /// what the reference drivers say of a touch, see [Was it avoidable?](#was-it-avoidable); missing without a touch
    pub VERDICT: Column<String> = "verdict";
    /// whether the pedestrian moved as people do in the last 3 s before the touch; not faster than 8 km/h unless it kept its velocity, its velocity changed
    /// by at most 2.12 m/s² over 0.5 s and by at most 1.65 m/s within any second (Euro NCAP's running adult, and recorded walking). Turning and stopping are
    /// acceleration
    pub FORESEEABLE: Column<bool> = "foreseeable";
    /// whether it counts against the driver; all careful drivers avoid it with 0.1 m to spare, the pedestrian moved as people do, and the car drove at 1 m/s
    /// or more, on whichever side the collision was, and was not walked into at the flank or rear after the front had passed; of a violation, whether all
    /// careful drivers satisfy the requirement from the start of the danger on and the pedestrian moved as people do
    pub FAULT: Column<bool> = "fault";
    /// `fault`, or the first reason why it is none; `bump` (the car stood), `not_preventable`, `unforeseeable`, `flank` (the pedestrian walked into the flank
    /// or the rear), `slow` (below 1 m/s), `narrow` (a careful human has less than 0.1 m to spare), `followed` (a car behind runs into that of a careful
    /// human who brakes). `runner` is a fault, too: somebody faster than 8 km/h at a steady speed
    pub COUNTS_AS: Column<String> = "counts_as";
    /// of a fault the risk of an injury of AIS 4 or more or of death at its speed, which a careful human would have spared the pedestrian; otherwise 0
    pub AVOIDABLE_INJURY: Column<f64> = "avoidable_injury" as Risk;
    /// time in sight without a break before the touch, 3 s at most; before its start, a shorter episode counts as in sight
    pub IN_SIGHT: Column<f64> = "in_sight_s" ["s"];
    /// whether the pedestrian walked into the flank at more than 0.1 m/s, or ran into the rear, after the front had passed it
    pub WALKED_INTO: Column<bool> = "walked_into_car";
    /// longest reaction time, counted from the gate, with which a driver who brakes like `cc` avoids the collision, 5 s at most; missing when it collides
    /// even without any, and for a bump
    pub LATEST_REACTION: Column<f64> = "latest_reaction_s" ["s"];
    /// on what of the humans' gate it rests that a collision is preventable: `anticipation` (they brake for somebody not yet in the path), `early_gate` (more
    /// than 2 s before), `both` or `neither`; missing unless it is
    pub RESTS_ON: Column<String> = "rests_on";
    /// share of drivers who react within that time
    pub PREVENTABLE_PROBABILITY: Column<f64> = "preventable_probability" as Share;
    /// whether that reference driver touches no pedestrian while it moves
    pub AVOIDS: Family<bool> = "_avoids";
    /// whether that reference driver would have braked needlessly: in an approach in which a car that keeps its pace does not touch the pedestrian either;
    /// missing with a collision and in error
    pub FALSE_BRAKE: Family<bool> = "_false_brake";
}
