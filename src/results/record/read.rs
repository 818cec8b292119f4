//! Reads tables back by type, without the names of their columns at the caller.

use polars::prelude::{DataFrame, Float64Chunked, PolarsResult};

use super::columns::{
    AVOIDS, BLOCK, BODY, COUNTS_AS, DIGEST, DRIVER, DRIVING_MODE, EGO_SPEED, EGO_X, EGO_Y, EGO_YAW, EPISODE,
    EPISODE_LENGTH, EPISODE_REWARD, ERROR, FALSE_BRAKE, FAULT, FORESEEABLE, FRONT, IMPACT, IMPACT_SPEED, IN_SIGHT,
    LATEST_REACTION, LEFT_OUT, ON_CROSSWALK, OUTCOME, PEDESTRIAN, PEDESTRIAN_X, PEDESTRIAN_Y, PEDESTRIAN_YAW, RESTS_ON,
    REWARD, RUN, RUN_ID, STATE_HASHES, TICKS, TOWN, TRAIN_DRIVER, TRAIN_TOWN, VEHICLE, VERDICT, WORLD,
};
use super::episodes::named;
use super::{CellKey, Family, Kind, RunKey};
use episode::{Impact, LeftOut, Spawn};
use road::geometry::Pose;
use verdict::{Class, Label, Reference, RestsOn};
use world::av::DrivingMode;

impl CellKey {
    /// The key in a row of a table. Block, vehicle and adversary are empty of the file of a report, whose manifest has them.
    ///
    /// # Errors
    /// A column is missing or holds something else.
    pub fn read(table: &DataFrame, row: usize) -> PolarsResult<Self> {
        let text = |column: &super::Column<String>| column.value(table, row).map(Option::unwrap_or_default);
        let of_manifest = |column: &super::Column<String>| column.value(table, row).ok().flatten().unwrap_or_default();
        Ok(Self {
            block: BLOCK.value(table, row).ok().flatten().unwrap_or_default(),
            town: text(&TOWN)?,
            policy: text(&DRIVER)?,
            vehicle: of_manifest(&VEHICLE),
            adversary: of_manifest(&BODY),
            world: text(&WORLD)?,
            controller: text(&PEDESTRIAN)?,
            reward: text(&REWARD)?,
            train_town: text(&TRAIN_TOWN)?,
            train_policy: text(&TRAIN_DRIVER)?,
        })
    }
}

impl RunKey {
    /// The key in a row of a table.
    ///
    /// # Errors
    /// A column is missing or holds something else.
    pub fn read(table: &DataFrame, row: usize) -> PolarsResult<Self> {
        let id = RUN_ID.value(table, row)?.and_then(|id| id.parse().ok());
        let run = RUN.value(table, row)?.unwrap_or_default();
        Ok(Self { id: id.unwrap_or_default(), cell: CellKey::read(table, row)?, run })
    }
}

macro_rules! episode_table {
    (
        $($field:ident: $held:ty = $column:ident),+;
        $($inner:ident: $of:ty = $in_memory:ident),+;
        $($(#[$doc:meta])+ $value:ident: $type:ty = $known:ident),+;
        $($(#[$about:meta])+ $word:ident: $Word:ident = $named:ident),+ $(,)?
    ) => {
        /// A table of episodes, read row by row.
        ///
        /// Missing numbers are `None` if the type allows it, else 0. The file of a report has only some of the columns.
        #[derive(Debug, Clone, Copy)]
        pub struct EpisodeTable<'a> {
            table: &'a DataFrame,
            $($field: &'a <$held as Kind>::Array,)+
            $($inner: Option<&'a <$of as Kind>::Array>,)+
            $($value: Option<&'a <$type as Kind>::Array>,)+
            $($word: Option<&'a <String as Kind>::Array>),+
        }

        impl<'a> EpisodeTable<'a> {
            /// Reads a table.
            ///
            /// # Errors
            /// A column is missing or holds something else.
            pub fn new(table: &'a DataFrame) -> PolarsResult<Self> {
                Ok(Self {
                    table,
                    $($field: $column.read(table)?,)+
                    $($inner: $in_memory.read(table).ok(),)+
                    $($value: $known.read(table).ok(),)+
                    $($word: $named.read(table).ok()),+
                })
            }

            $(
                $(#[$doc])+
                pub fn $value(&self, row: usize) -> Option<$type> {
                    self.$value?.get(row)
                }
            )+

            $(
                $(#[$about])+
                pub fn $word(&self, row: usize) -> Option<$Word> {
                    $Word::named(self.$word?.get(row)?)
                }
            )+
        }
    };
}

episode_table! {
    episode: u32 = EPISODE,
    outcome: String = OUTCOME,
    fault: bool = FAULT,
    error: String = ERROR,
    left_out: String = LEFT_OUT,
    reward: f64 = EPISODE_REWARD,
    length: f64 = EPISODE_LENGTH,
    ego_x: f64 = EGO_X,
    ego_y: f64 = EGO_Y,
    ego_yaw: f64 = EGO_YAW,
    ego_speed: f64 = EGO_SPEED,
    pedestrian_x: f64 = PEDESTRIAN_X,
    pedestrian_y: f64 = PEDESTRIAN_Y,
    pedestrian_yaw: f64 = PEDESTRIAN_YAW,
    digest: String = DIGEST;
    front: bool = FRONT,
    state_hashes: String = STATE_HASHES,
    foreseeable: bool = FORESEEABLE;
    /// Speed of the car at the touch (m/s).
    impact_speed: f64 = IMPACT_SPEED,
    /// Simulator ticks; `None` if it was not run.
    ticks: u32 = TICKS,
    /// Whether the pedestrian was on a crosswalk at the touch.
    on_crosswalk: bool = ON_CROSSWALK,
    /// The longest reaction time that avoids a collision (s).
    latest_reaction: f64 = LATEST_REACTION,
    /// Time in sight before the touch (s).
    in_sight: f64 = IN_SIGHT;
    /// The side of the touch.
    impact: Impact = IMPACT,
    /// The driver's action in the last tick.
    driving_mode: DrivingMode = DRIVING_MODE,
    /// The verdict.
    label: Label = VERDICT,
    /// Why a touch counts against the driver, or not.
    counts_as: Class = COUNTS_AS,
    /// On what it rests that a collision is preventable.
    rests_on: RestsOn = RESTS_ON,
}

impl<'a> EpisodeTable<'a> {
    pub fn rows(&self) -> std::ops::Range<usize> {
        0..self.table.height()
    }

    pub fn episode(&self, row: usize) -> u32 {
        self.episode.get(row).unwrap_or_default()
    }

    /// Its error; `None` if it has none.
    pub fn error(&self, row: usize) -> Option<&'a str> {
        (self.outcome.get(row) == Some(named::ERROR)).then(|| self.error.get(row).unwrap_or_default())
    }

    /// Whether it is a collision or a bump.
    pub fn is_touch(&self, row: usize) -> bool {
        self.outcome.get(row).is_some_and(named::is_touch)
    }

    /// Why it is left out; `None` if it is not.
    pub fn left_out(&self, row: usize) -> Option<LeftOut> {
        self.left_out.get(row).and_then(LeftOut::named)
    }

    /// Whether it is in rates, comparisons, gates and lists of failures: it has no error, and it is not left out.
    pub fn counts(&self, row: usize) -> bool {
        self.error(row).is_none() && self.left_out(row).is_none()
    }

    pub fn is_collision(&self, row: usize) -> bool {
        self.outcome.get(row) == Some(named::COLLISION)
    }

    /// Whether it is a collision or a bump within the front sector.
    pub fn is_front(&self, row: usize) -> bool {
        self.front.and_then(|front| front.get(row)) == Some(true)
    }

    /// Whether the pedestrian of a collision moved as people do.
    pub fn is_foreseeable(&self, row: usize) -> bool {
        self.foreseeable.and_then(|foreseeable| foreseeable.get(row)) == Some(true)
    }

    /// Whether it counts against the driver: preventable, with a foreseeable pedestrian.
    pub fn is_fault(&self, row: usize) -> bool {
        self.fault.get(row).unwrap_or_default()
    }

    /// The marks of its states.
    pub fn state_hashes(&self, row: usize) -> Option<&'a str> {
        self.state_hashes?.get(row)
    }

    /// Sum of the rewards.
    pub fn reward(&self, row: usize) -> Option<f64> {
        self.reward.get(row)
    }

    /// Length (s).
    pub fn length(&self, row: usize) -> Option<f64> {
        self.length.get(row)
    }

    /// Digest, as 16 hexadecimal digits.
    pub fn digest(&self, row: usize) -> &'a str {
        self.digest.get(row).unwrap_or_default()
    }

    /// The rows of collisions that a reference driver avoids; none in the file of a report, which does not have them.
    pub fn avoided(&self, reference: Reference) -> impl Iterator<Item = usize> {
        let table = *self;
        self.holding(AVOIDS, reference).filter(move |row| table.is_collision(*row))
    }

    /// The rows without a collision in which a reference driver would have braked needlessly; none in the file of a report.
    pub fn needless(&self, reference: Reference) -> impl Iterator<Item = usize> {
        self.holding(FALSE_BRAKE, reference)
    }

    /// The rows that count and for which a column of a reference driver is true.
    fn holding(&self, family: Family<bool>, reference: Reference) -> impl Iterator<Item = usize> {
        let values = family.read(reference.name(), self.table).ok();
        let table = *self;
        self.rows().filter(move |row| table.counts(*row) && values.and_then(|values| values.get(*row)) == Some(true))
    }

    /// The start.
    pub fn spawn(&self, row: usize) -> Spawn {
        let of = |column: &Float64Chunked| column.get(row).unwrap_or_default();
        Spawn {
            ego: Pose::new(of(self.ego_x), of(self.ego_y), of(self.ego_yaw).to_radians()),
            ego_speed: of(self.ego_speed),
            pedestrian: Pose::new(of(self.pedestrian_x), of(self.pedestrian_y), of(self.pedestrian_yaw).to_radians()),
        }
    }
}
