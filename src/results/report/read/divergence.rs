use polars::prelude::DataFrame;

use super::stored::{differences, trail};
use world::env::{Outcome, Scenario};

/// Where a repeated episode parts from the stored one, in words: the tick, where the report holds the ticks (given here then and
/// now), else the decisions between which it does; none where neither tells.
pub fn divergence(
    stored: &DataFrame,
    outcome: &Outcome,
    scenario: &Scenario,
    ticks: Option<(&DataFrame, &DataFrame)>,
) -> Option<String> {
    let (dt, hold) = (scenario.episode.tick, scenario.episode.hold);
    if let Some((then, now)) = ticks
        && let Some((tick, first)) = differences(then, now).ok()?.into_iter().next()
    {
        let time = tick as f64 * dt;
        return Some(format!(
            "at tick {tick} ({time:.2} s): {} was {}, and is {}",
            first.column, first.stored, first.again
        ));
    }
    let (same, other) = trail(stored)?.divergence(&outcome.state_hashes)?;
    let (from, to) = (same * hold + 1, other * hold);
    let (begun, ended) = (f64::from(from) * dt, f64::from(to) * dt);
    Some(format!("between tick {from} and tick {to} ({begun:.2} s to {ended:.2} s), decision {other}"))
}
