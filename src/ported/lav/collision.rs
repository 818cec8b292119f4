use super::command::Command;
use super::forecast::Forecast;
use super::frame::EgoPoint;
use super::version::Traits;

/// Modes below this score are ignored.
const MIN_SCORE: f64 = 0.2;
/// A vehicle that starts farther behind the ego than this is ignored (m).
const BEHIND: f64 = 2.0;
/// A vehicle that moves less than this between two points stands, for v2 (m).
const STANDS: f64 = 0.2;

/// Whether the plan comes too near to a forecast: at the same time, from centre to centre, whatever their sizes.
///
/// # Source
/// `plan_collide` of LAV. Only a vehicle's first branch, a turn to the left, decides whether it is behind.
pub(super) fn plan_collides(traits: &Traits, plan: &[EgoPoint], forecasts: &[Forecast]) -> bool {
    forecasts.iter().filter(|forecast| forecast.modes[Command::Left.index()][0].back <= BEHIND).any(|forecast| {
        forecast.modes.iter().zip(forecast.scores).filter(|(_, score)| *score >= MIN_SCORE).any(|(mode, _)| {
            let mode = &mode[..plan.len().min(mode.len())];
            let threshold = if mean_step(mode) < STANDS { traits.collision_standing } else { traits.collision };
            mode.iter().zip(plan).any(|(its, own)| its.distance(*own) < threshold)
        })
    })
}

/// Mean distance between neighbours (m).
pub(super) fn mean_step(points: &[EgoPoint]) -> f64 {
    let steps = points.windows(2).map(|pair| pair[0].distance(pair[1]));
    steps.sum::<f64>() / points.len().saturating_sub(1).max(1) as f64
}
