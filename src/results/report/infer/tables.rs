use polars::prelude::{DataFrame, Expr, IntoLazy, NULL, col, lit, when};

use super::{Comparison, Test};
use crate::record::columns::{DRIVER, PEDESTRIAN};
use crate::record::{Column, ColumnReference, Table, cell_key, columns, interval};
use crate::tables::{FIGURE, METHOD, OTHER};
use verdict::Reference;

const OTHER_PEDESTRIAN: Column<String> =
    Column::new("other_pedestrian", "", "pedestrian of the cell that is subtracted");
const OTHER_DRIVER: Column<String> =
    Column::new("other_driver", "", "driver of that cell: another one than `driver` where drivers are compared");
const OTHER_REWARD: Column<String> = Column::new("other_reward", "", "reward of that cell");
const DIFFERENCE: Column<f64> =
    Column::new("difference", "", "mean of the figure over the runs of the cell less that of the other cell");
const DIFFERENCE_INTERVAL: &str = "its interval, which holds the truth for all rows of its kind in 95 % of campaigns (Bonferroni). Student's with Welch's degrees of freedom; its variance is \
     that between the trainings of either cell plus that of the common episodes (at least that of one episode). Exact for one run on each side. \
     Missing if one side alone is a single training, or has two or three runs";
columns! {
    /// two-sided p-value, adjusted for all tests of its kind in the table by Holm's method; in 95 % of campaigns no finding of its kind below 0.05 is false;
    /// a kind is all rows that compare pedestrians, or all that compare drivers. Missing without a test: where neither cell has such a collision, or one has
    /// two runs
    P_HOLM: Column<f64> = "p_holm";

    /// collisions that the reference driver does not avoid, of all episodes; what remains if it brakes from where the danger began. Episodes without a
    /// collision are not run again, so it never is above `collision_rate`
    REST: Family<f64> = "_collision_rate";

    /// episodes without a collision in which the reference driver would have braked needlessly, of all episodes; in an approach in which a car that keeps its
    /// pace does not touch the pedestrian either
    NEEDLESS: Family<f64> = "_false_brake_rate";

    /// 90th percentile over all collisions; of each run the first 100,000 episodes
    pub IMPACT_SPEED_P90: Column<f64> = "impact_speed_mps_p90" ["m/s"];

    /// whether every training of the cell gets more reward an episode than an untrained pedestrian, and none less; `no` where a training is significantly
    /// below one with the same reward and starts, such as `intercept`, however much better than `random` it is; `yes` where each is significantly above one
    /// and none is below; else `unclear`. About these trainings: normal test over common episodes, at 5 % after Holm's correction for all such pairs of the
    /// campaign. Missing for untrained pedestrians
    pub BEATS_UNTRAINED: Column<String> = "beats_untrained";
}
/// The metrics of a reference driver: the rate of the collisions that it does not avoid, and that of needless braking.
pub fn reference_rates(reference: Reference) -> [ColumnReference; 2] {
    [REST, NEEDLESS].map(|rate| rate.reference(reference.name()))
}

/// The stem of the files of the table of comparisons.
pub const COMPARISONS: &str = "comparisons";
columns! {
    /// episodes of the shortest of these runs; null for searches
    PAIRED_EPISODES: Column<u64> = "paired_episodes";
    /// `student`, `mcnemar` or empty; `student` is about further trainings, of searches paired, `mcnemar` exact with one run on each side and about these two
    /// and further episodes, on the first 100,000
    TEST: Column<String> = "test";
}

/// The columns of [`comparisons`].
pub fn comparison_table() -> Table<'static, Comparison> {
    type Row = Comparison;
    Table::new(
        COMPARISONS,
        "One row for each pair of cells with common starts, and figure: two pedestrians against one driver, or, where `other_driver` is not `driver`, two drivers that met the same pedestrian. Both cells \
         have the same town, vehicle, body, world and block. Rows of searches follow, which have no `vehicle`: two searches, or two drivers. Each kind is adjusted on its own.",
    )
    .columns(cell_key(|row: &Row| &row.first))
    .column(OTHER_PEDESTRIAN.of(|row: &Row| row.second.controller.clone()))
    .column(OTHER_DRIVER.of(|row: &Row| row.second.policy.clone()))
    .column(OTHER_REWARD.of(|row: &Row| row.second.reward.clone()))
    .column(FIGURE.of(|row: &Row| row.figure.name))
    .column(PAIRED_EPISODES.of(|row: &Row| row.episodes))
    .column(DIFFERENCE.of(|row: &Row| row.difference))
    .columns(interval(DIFFERENCE.name, DIFFERENCE.name, DIFFERENCE_INTERVAL, |row: &Row| row.interval))
    .column(TEST.of(|row: &Row| row.test.name()))
    .column(P_HOLM.of(|row: &Row| row.holm))
}

/// Comparisons of cells, then pairs of searches: the falsifier is the pedestrian.
///
/// # Panics
/// Never: a table of pairs has these columns.
pub fn comparisons(cells: &[Comparison], searches: &DataFrame) -> DataFrame {
    let mut all = comparison_table().frame(cells);
    let column = |reference: ColumnReference| {
        let (name, holds) = (&*reference.name, reference.holds);
        let values = match name {
            _ if name == PEDESTRIAN.name => col(METHOD.name),
            _ if name == OTHER_PEDESTRIAN.name => col(format!("{}{OTHER}", METHOD.name)),
            _ if name == OTHER_DRIVER.name => col(format!("{}{OTHER}", DRIVER.name)),
            _ if name == PAIRED_EPISODES.name => lit(NULL),
            _ if name == TEST.name => {
                when(col(P_HOLM.name).is_null()).then(lit("")).otherwise(lit(Test::Student.name()))
            }
            _ if searches.get_column_index(name).is_some() => col(name),
            _ => lit(""),
        };
        values.cast(holds).alias(name)
    };
    let columns: Vec<Expr> = comparison_table().reference().columns.into_iter().map(column).collect();
    if searches.height() > 0 {
        let rows = searches.clone().lazy().select(columns).collect();
        rows.and_then(|rows| all.vstack_mut(&rows).map(|_| ())).expect("a bug: a table of pairs has its columns");
    }
    all
}
