use polars::prelude::DataFrame;

use crate::record::columns::STATE_HASHES;
use episode::{Outcome, Scenario, StateHashes};

/// Where a repeated episode diverges from the stored one, in words: the decisions between which it does; `None` if the row does not tell.
pub fn divergence(stored: &DataFrame, outcome: &Outcome, scenario: &Scenario) -> Option<String> {
    let (dt, hold) = (scenario.episode.tick, scenario.episode.hold);
    let stored: StateHashes = STATE_HASHES.value(stored, 0).ok()??.parse().ok()?;
    let (same, other) = stored.divergence(&outcome.state_hashes)?;
    let (from, to) = (same * hold + 1, other * hold);
    let (begun, ended) = (f64::from(from) * dt, f64::from(to) * dt);
    Some(format!("between tick {from} and tick {to} ({begun:.2} s to {ended:.2} s), decision {other}"))
}
