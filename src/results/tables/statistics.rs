//! Statistics of the rows of a group, as expressions: plain functions of numbers.

use polars::prelude::{
    Column, DataType, Expr, Field, Float64Chunked, IntoColumn, NewChunkedArray, PolarsResult, apply_multiple, col,
};

use super::metrics::MEAN;
use base::statistics::{bounded_interval, holm, mean_interval};

/// A statistic of the numbers of a group that are not missing, a slice for each expression.
pub fn statistic<const N: usize>(
    of: [Expr; N],
    statistic: impl Fn([&[f64]; N]) -> Option<f64> + Send + Sync + 'static,
) -> Expr {
    let numbers = |column: &Column| -> PolarsResult<Vec<f64>> { Ok(column.f64()?.iter().flatten().collect()) };
    let of_group = move |columns: &mut [Column]| {
        let lists = columns.iter().map(numbers).collect::<PolarsResult<Vec<_>>>()?;
        let value = statistic(std::array::from_fn(|place| lists[place].as_slice()));
        Ok(Float64Chunked::from_slice_options(columns[0].name().clone(), &[value]).into_column())
    };
    let field = |_: &_, fields: &[Field]| Ok(Field::new(fields[0].name().clone(), DataType::Float64));
    apply_multiple(of_group, of.map(|expression| expression.cast(DataType::Float64)), field, true)
}

/// The columns `NAME_low` and `NAME_high` of an interval.
pub fn interval<const N: usize>(
    name: &str,
    of: [Expr; N],
    ends: impl Fn([&[f64]; N]) -> Option<(f64, f64)> + Copy + Send + Sync + 'static,
) -> [Expr; 2] {
    let low = statistic(of.clone(), move |numbers| Some(ends(numbers)?.0));
    let high = statistic(of, move |numbers| Some(ends(numbers)?.1));
    [low.alias(format!("{name}_low")), high.alias(format!("{name}_high"))]
}

/// Probabilities, adjusted by Holm's method for those that are not missing.
pub fn adjusted(p: Expr) -> Expr {
    let holm_of = |p: Column| {
        let p = p.f64()?;
        let mut known = holm(&p.iter().flatten().collect::<Vec<f64>>()).into_iter();
        let all: Float64Chunked = p.iter().map(|p| p.and_then(|_| known.next())).collect();
        Ok(all.with_name(p.name().clone()).into_column())
    };
    p.apply(holm_of, |_, field| Ok(Field::new(field.name().clone(), DataType::Float64)))
}

/// A number of runs: its mean, its sample deviation, and the values of those that have one.
pub fn over_runs(figure: &str, number: Expr) -> [Expr; 3] {
    let number = || number.clone().cast(DataType::Float64);
    [
        number().mean().alias(MEAN.name(figure)),
        number().std(1).alias(format!("{figure}_sd")),
        number().drop_nulls().alias(format!("{figure}_by_run")),
    ]
}

/// The same with Student's interval about further runs, between bounds; none of few runs and of equal ones.
pub fn over_runs_with_student(figure: &'static str, bounds: (f64, f64)) -> impl Iterator<Item = Expr> {
    let ends = interval(figure, [col(figure)], move |[runs]| student(runs, bounds));
    over_runs(figure, col(figure)).into_iter().chain(ends)
}

/// Student's interval of the mean, between bounds.
pub fn student(numbers: &[f64], bounds: (f64, f64)) -> Option<(f64, f64)> {
    let (mean, interval) = mean_interval(numbers);
    let (low, high) = interval?;
    Some(bounded_interval(mean, (high - low) / 2.0, bounds))
}
