//! Requirements: what must be true of an episode, how far it is from being false, and which sample and comparison decide that.
//!
//! A [`Monitor`] takes one sample of the signals at the start of an episode and one after each tick. At the end of the episode [`Trace::degree`]
//! evaluates the formula: exactly, over all samples at once, in time proportional to the number of samples and of operators.
//!
//! # Semantics
//! Time is discrete and the episode is finite: samples 0 to n − 1, one tick apart. The robustness ρ of a formula at sample t is
//!
//! | formula | ρ at t |
//! |---|---|
//! | `a < b`, `a <= b` | b − a |
//! | a condition such as `in_sight` | +∞ if true, −∞ if false |
//! | `not φ` | −ρ(φ, t) |
//! | `φ and ψ`, `φ or ψ` | the lesser, the greater |
//! | `φ implies ψ` | that of `not φ or ψ` |
//! | `always(φ, [a, b])` | the least ρ(φ, s) of all s from t + a to t + b |
//! | `eventually(φ, [a, b])` | the greatest |
//! | `until(φ, ψ, [a, b])` | the greatest over s from t + a to t + b of the least of ρ(ψ, s) and all ρ(φ, r) with t ≤ r < s |
//!
//! Samples after the last one do not exist: a bound that reaches beyond the end is cut there. If nothing of it is left, `always` is true (+∞),
//! `eventually` and `until` are false (−∞). A requirement is satisfied if ρ at sample 0 is positive. Where it is 0 the operators of the
//! comparisons decide: `<` and `>` are false where both sides are equal, `<=` and `>=` are true. The sign of the zero keeps that: −0 is false, +0 is
//! true, and the order −0 < +0 is that of [`f64::total_cmp`]. So yes and no follow from the sign alone, through all operators.
//!
//! # Source
//! Fainekos and Pappas, *Robustness of temporal logic specifications for continuous-time signals*, Theoretical Computer Science 410, 2009;
//! Donzé, Ferrère and Maler, *Efficient robust monitoring for STL*, CAV 2013, for `until` with a bound. Lemire, *Streaming maximum-minimum filter
//! using no more than three comparisons per element*, Nordic Journal of Computing 13, 2006, for the windows.

mod degree;
mod monitor;
mod robustness;

use base::signature::Within;

pub use degree::{Degree, NoDegree};
pub use monitor::{Monitor, NamedRequirement};
pub use robustness::Trace;

/// The first and the last tick of a bound after the present sample: those whose time lies in it. `None` for a bound without an end. The last is before
/// the first if no tick lies in it.
pub fn ticks_within(within: &Within, dt: f64) -> (usize, Option<usize>) {
    // A quotient such as 0.3 / 0.1 is a little less than 3.
    const ROUNDING: f64 = 1e-9;
    let (from, to) = (within.from / dt, within.to / dt);
    let last = to.is_finite().then(|| (to * (1.0 + ROUNDING)).floor() as usize);
    ((from * (1.0 - ROUNDING)).ceil() as usize, last)
}
