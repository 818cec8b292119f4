//! The metrics of runs and cells. A new metric is one entry in [`METRICS`].

use polars::prelude::{DataType, Expr, col, lit};

use crate::record::episodes::named;
use crate::record::{Column, ColumnReference, Family, Role, columns};
use episode::LeftOut;
use verdict::Label;

/// A number of the episodes of a run, and of the runs of a cell.
///
/// Without a `whole` it is a count: the sum of `part`, also over the runs of a cell. With one it is the sum of `part` divided by that count, missing where that is
/// 0; a cell has the mean over its runs. A share also has Wilson's 95 % interval of the sums.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// The column.
    pub name: &'static str,
    pub unit: &'static str,
    /// What it means, for `reports/README.md`.
    pub doc: &'static str,
    pub role: Role,
    /// What is summed over the rows of the table of episodes.
    pub part: fn() -> Expr,
    /// The count that it is a ratio to.
    pub whole: Option<&'static Metric>,
    /// The count that a share is a part of; `None` of other metrics. A share has Wilson's interval.
    pub counted: Option<&'static Metric>,
    /// What is inferred of it beyond the episodes of a cell.
    pub inference: Inference,
}

/// What is inferred of a metric from the runs of a cell and from cells with common starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Inference {
    #[default]
    None,
    /// Student's interval about further trainings.
    Trainings,
    /// The same, and comparisons of pedestrians, of drivers and of reports.
    Pairs,
}

/// All metrics, in the order of their tables.
pub const METRICS: [&Metric; 33] = [
    &EPISODES,
    &ERRORS,
    &COLLISIONS,
    &TOUCHES,
    &FRONT_TOUCHES,
    &COLLISION_RATE,
    &TOUCH_RATE,
    &FRONT_RATE,
    &EPISODE_REWARD,
    &EPISODE_LENGTH,
    &IMPACT_SPEED,
    &FORESEEABLE_COLLISIONS,
    &PREVENTABLE_COLLISIONS,
    &CONTESTED_COLLISIONS,
    &MACHINE_PREVENTABLE_COLLISIONS,
    &UNPREVENTABLE_COLLISIONS,
    &BUMPS,
    &FAULT_COLLISIONS,
    &WALKED_INTO_COLLISIONS,
    &PREVENTABLE_RATE,
    &PREVENTABLE_SHARE,
    &FAULT_RATE,
    &EXPECTED_PREVENTABLE,
    &PLACED_STARTS,
    &PLACED_RATE,
    &AVOIDABLE_INJURY,
    &ALL_EPISODES,
    &LEFT_OUT_EPISODES,
    &LEFT_OUT_RATE,
    &ROAD_END_EPISODES,
    &LEFT_ROAD_EPISODES,
    &LEFT_ROAD_RATE,
    &LEFT_LANE,
];

/// Counts that metrics are ratios to, and that no table has.
pub(super) const HIDDEN: [&Metric; 1] = [&LANE_EPISODES];

impl Metric {
    pub(super) const fn count(name: &'static str, doc: &'static str, part: fn() -> Expr) -> Self {
        Self { name, unit: "", doc, role: Role::Plain, part, whole: None, counted: None, inference: Inference::None }
    }

    pub(super) const fn share(
        name: &'static str,
        part: &'static Self,
        whole: &'static Self,
        doc: &'static str,
    ) -> Self {
        Self {
            name,
            unit: "",
            doc,
            role: Role::Share,
            part: part.part,
            whole: Some(whole),
            counted: Some(part),
            inference: Inference::None,
        }
    }

    /// The mean of a column over these episodes; a missing value counts as 0.
    const fn mean(column: &Column<f64>, part: fn() -> Expr, whole: &'static Self, doc: &'static str) -> Self {
        Self {
            name: column.name,
            unit: column.unit,
            doc,
            role: column.role,
            part,
            whole: Some(whole),
            counted: None,
            inference: Inference::None,
        }
    }

    /// Whether it is a number of episodes.
    pub const fn is_count(&self) -> bool {
        self.whole.is_none()
    }

    /// The column of the sum of its part: that of a count is its value.
    pub(super) fn part_column(&self) -> String {
        if self.is_count() { self.name.into() } else { format!("{}_part", self.name) }
    }

    /// With more inferred of it.
    const fn inferring(self, inference: Inference) -> Self {
        Self { inference, ..self }
    }

    /// Whether it is a ratio of two counts, which has Wilson's interval.
    pub const fn is_share(&self) -> bool {
        self.counted.is_some()
    }

    /// Between what its values lie: a share from 0 to 1, what has a unit from 0 on.
    pub const fn bounds(&self) -> (f64, f64) {
        match self.counted {
            Some(_) => (0.0, 1.0),
            None if self.unit.is_empty() => (f64::NEG_INFINITY, f64::INFINITY),
            None => (0.0, f64::INFINITY),
        }
    }

    /// What it is a rate of, for people: `fault` of `fault_rate`.
    pub fn word(&self) -> &'static str {
        self.name.trim_end_matches("_rate")
    }

    /// Whether it has no value without a touch.
    pub fn is_of_collisions(&self) -> bool {
        self.whole.is_some_and(|whole| [COLLISIONS.name, TOUCHES.name].contains(&whole.name))
    }

    pub fn reference(&self) -> ColumnReference {
        let holds = if self.is_count() { DataType::UInt32 } else { DataType::Float64 };
        let Self { name, unit, doc, role, .. } = *self;
        ColumnReference { name: name.into(), unit: unit.into(), doc: doc.into(), holds, role, figure: name.into() }
    }
}

impl PartialEq for Metric {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Metric {}

/// The metrics with intervals about further trainings, in the order of [`METRICS`].
pub fn inferred() -> impl Iterator<Item = &'static Metric> {
    METRICS.into_iter().filter(|metric| metric.inference != Inference::None)
}

/// The metrics in which pedestrians, drivers and reports are compared.
pub fn compared() -> impl DoubleEndedIterator<Item = &'static Metric> {
    METRICS.into_iter().filter(|metric| metric.inference == Inference::Pairs)
}

/// Episodes without error.
fn ran() -> Expr {
    col(columns::OUTCOME.name).neq(lit(named::ERROR))
}

/// Those that count: without error, and not left out.
fn counts() -> Expr {
    ran().and(col(columns::LEFT_OUT.name).eq(lit("")))
}

fn ended(outcome: &'static str) -> Expr {
    counts().and(col(columns::OUTCOME.name).eq(lit(outcome)))
}

fn collided() -> Expr {
    ended(named::COLLISION)
}

fn labelled(label: Label) -> Expr {
    counts().and(col(columns::VERDICT.name).eq(lit(label.name())))
}

fn is(column: &Column<bool>) -> Expr {
    col(column.name).fill_null(lit(false))
}

/// The values of a column in these episodes; 0 elsewhere.
fn of(episodes: Expr, column: &Column<f64>) -> Expr {
    polars::prelude::when(episodes).then(col(column.name)).otherwise(lit(0.0))
}

pub const EPISODES: Metric = Metric::count(
    "episodes",
    "number of episodes that count; those in error and those that are left out (`left_out`) are missing here and in every rate and mean",
    counts,
);
pub const ERRORS: Metric = Metric::count("errors", "number of episodes in error", || ran().not());
pub const COLLISIONS: Metric = Metric::count("collisions", "number of collisions, in which the car moved", collided);
pub const BUMPS: Metric =
    Metric::count("bumps", "number of bumps, in which a pedestrian touched the standing car", || ended(named::BUMP));
pub const TOUCHES: Metric =
    Metric::count("touches", "number of collisions and bumps", || collided().or(ended(named::BUMP)));
pub const FRONT_TOUCHES: Metric =
    Metric::count("front_touches", "number of collisions and bumps in the front sector", || {
        counts().and(is(&columns::FRONT))
    });
pub const FORESEEABLE_COLLISIONS: Metric =
    Metric::count("foreseeable_collisions", "number of collisions with a foreseeable pedestrian", || {
        counts().and(is(&columns::FORESEEABLE))
    });
const WITH_VERDICT: &str = "number of collisions with that verdict";
pub const PREVENTABLE_COLLISIONS: Metric =
    Metric::count("preventable_collisions", WITH_VERDICT, || labelled(Label::Preventable));
pub const CONTESTED_COLLISIONS: Metric =
    Metric::count("contested_collisions", WITH_VERDICT, || labelled(Label::Contested));
pub const MACHINE_PREVENTABLE_COLLISIONS: Metric =
    Metric::count("machine_preventable_collisions", WITH_VERDICT, || labelled(Label::MachinePreventable));
pub const UNPREVENTABLE_COLLISIONS: Metric =
    Metric::count("unpreventable_collisions", WITH_VERDICT, || labelled(Label::Unpreventable));
pub const FAULT_COLLISIONS: Metric =
    Metric::count("fault_collisions", "number of faults", || counts().and(is(&columns::FAULT)));
pub const WALKED_INTO_COLLISIONS: Metric = Metric::count(
    "walked_into_collisions",
    "number of collisions in which the pedestrian walked into the side or the rear",
    || counts().and(is(&columns::WALKED_INTO)),
);
pub const PLACED_STARTS: Metric =
    Metric::count("placed_starts", "number of starts that the driver did not reach in its run-up", || {
        ran().and(is(&columns::PLACED))
    });
pub const ALL_EPISODES: Metric = Metric::count(
    "all_episodes",
    "number of episodes without error; those that count, and those that are left out",
    ran,
);
pub const LEFT_OUT_EPISODES: Metric = Metric::count(
    "left_out_episodes",
    "number of episodes that are left out; the driver did not reach its start, its car left the road before it could see a pedestrian, or it drove past \
     the end of the road",
    || ran().and(counts().not()),
);
pub const ROAD_END_EPISODES: Metric = Metric::count(
    "road_end_episodes",
    "number of episodes that are left out since the car drove past the end of the road",
    || ran().and(col(columns::LEFT_OUT.name).eq(lit(LeftOut::RoadEnd.name()))),
);
pub const LEFT_ROAD_EPISODES: Metric = Metric::count(
    "left_road_episodes",
    "number of episodes in which the centre of the car was outside all driving lanes; those that are left out included",
    || ran().and(is(&columns::LEFT_ROAD)),
);
const LANE_EPISODES: Metric = Metric::count(
    "lane_episodes",
    "number of episodes without error in which the car was on a road with lanes, also where they are left out",
    || ran().and(col(columns::LEFT_LANE.name).is_not_null()),
);

pub const COLLISION_RATE: Metric = Metric::share(
    "collision_rate",
    &COLLISIONS,
    &EPISODES,
    "collisions of all *episodes*; bumps do not count (the paper's moving CR)",
)
.inferring(Inference::Pairs);
pub const TOUCH_RATE: Metric =
    Metric::share("touch_rate", &TOUCHES, &EPISODES, "collisions and bumps of all *episodes* (the paper's CR)")
        .inferring(Inference::Trainings);
pub const FRONT_RATE: Metric = Metric::share(
    "front_rate",
    &FRONT_TOUCHES,
    &TOUCHES,
    "collisions and bumps in the front sector of *all of them* (the paper's front CR); missing without any",
)
.inferring(Inference::Trainings);
pub const PREVENTABLE_RATE: Metric =
    Metric::share("preventable_rate", &PREVENTABLE_COLLISIONS, &EPISODES, "preventable collisions of all *episodes*")
        .inferring(Inference::Pairs);
pub const PREVENTABLE_SHARE: Metric = Metric::share(
    "preventable_share",
    &PREVENTABLE_COLLISIONS,
    &COLLISIONS,
    "preventable collisions of all *collisions*; missing without any collision",
);
pub const FAULT_RATE: Metric =
    Metric::share("fault_rate", &FAULT_COLLISIONS, &EPISODES, "faults of all *episodes*").inferring(Inference::Pairs);
pub const PLACED_RATE: Metric = Metric::share(
    "placed_rate",
    &PLACED_STARTS,
    &ALL_EPISODES,
    "their share of `all_episodes`; near 1 it never drives to where the pedestrian is",
);
pub const LEFT_OUT_RATE: Metric =
    Metric::share("left_out_rate", &LEFT_OUT_EPISODES, &ALL_EPISODES, "their share of `all_episodes`");
pub const LEFT_ROAD_RATE: Metric = Metric::share(
    "left_road_rate",
    &LEFT_ROAD_EPISODES,
    &ALL_EPISODES,
    "their share of `all_episodes`; near 1 the driver does not follow its route",
);

pub const EPISODE_REWARD: Metric = Metric::mean(
    &columns::EPISODE_REWARD,
    || of(counts(), &columns::EPISODE_REWARD),
    &EPISODES,
    "mean reward of an episode",
)
.inferring(Inference::Trainings);
pub const EPISODE_LENGTH: Metric = Metric::mean(
    &columns::EPISODE_LENGTH,
    || of(counts(), &columns::EPISODE_LENGTH),
    &EPISODES,
    "mean length of an episode",
)
.inferring(Inference::Trainings);
pub const IMPACT_SPEED: Metric = Metric::mean(
    &columns::IMPACT_SPEED,
    || of(collided(), &columns::IMPACT_SPEED),
    &COLLISIONS,
    "mean speed of the car at a collision",
)
.inferring(Inference::Trainings);
pub const EXPECTED_PREVENTABLE: Metric = Metric {
    name: "expected_preventable",
    ..Metric::mean(
        &columns::PREVENTABLE_PROBABILITY,
        || of(counts(), &columns::PREVENTABLE_PROBABILITY),
        &EPISODES,
        "the expected rate of collisions that a driver drawn at random would have avoided, of all *episodes*",
    )
};
pub const AVOIDABLE_INJURY: Metric = Metric::mean(
    &columns::AVOIDABLE_INJURY,
    || of(counts(), &columns::AVOIDABLE_INJURY),
    &EPISODES,
    "mean over episodes of the risk of a severe injury that a careful human would have spared; times 1,000 it is per 1,000 episodes",
);
pub const LEFT_LANE: Metric = Metric::mean(
    &columns::LEFT_LANE,
    || of(ran(), &columns::LEFT_LANE),
    &LANE_EPISODES,
    "mean time of an episode in which the car was outside its lane, over `all_episodes`",
);

/// What the answer of a comparison weighs, with the plural of what a rate is of; searches count with the first.
pub const ANSWER: [(&Metric, &str); 3] = [
    (&FAULT_RATE, "faults"),
    (&COLLISION_RATE, "collisions"),
    (&IMPACT_SPEED, "collisions that are worse than on the other side"),
];

/// The number of runs of a cell.
pub const RUNS: Column<u32> = Column::new("runs", "", "number of runs");
pub const MEAN: Family<f64> = Family::new("_mean", "", "mean over the runs of the cell");

/// The counts of touches with each verdict, in the order of [`Label::ALL`].
pub const LABELLED: [&Metric; Label::COUNT] = [
    &PREVENTABLE_COLLISIONS,
    &CONTESTED_COLLISIONS,
    &MACHINE_PREVENTABLE_COLLISIONS,
    &UNPREVENTABLE_COLLISIONS,
    &BUMPS,
];
