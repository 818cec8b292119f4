/// The most instants of a recording.
pub(super) const MAX_INSTANTS: usize = 100_000;

/// A recording that cannot be judged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    #[error("there are {ego} instants of the car and {pedestrian} of the pedestrian; give the same number of both, 2 to {most}", most = MAX_INSTANTS)]
    Instants { ego: usize, pedestrian: usize },
    #[error("the time between two instants is {step} s; {}give 0.001 s to 0.5 s", unit_of_time(*.step))]
    Step { step: f64 },
    #[error("`{quantity}` is {size}; give {low} to {high} {unit}")]
    Size { quantity: &'static str, size: f64, low: f64, high: f64, unit: &'static str },
    #[error("instant {instant}: {fault}")]
    Instant { instant: usize, fault: InstantFault },
    #[error("the {who} moves {} its speed and the step of {dt} s explain: {likely}", times(*ratio))]
    Units { who: &'static str, ratio: f64, dt: f64, likely: String },
    #[error(
        "the {who} moves at {degrees:.0} deg from its heading: {likely}{}",
        if *.who == "car" { "" } else { ". Where it is that of the body, as in boxes of data sets, leave out speed and heading: they then come from the positions" }
    )]
    Heading { who: &'static str, degrees: f64, likely: &'static str },
}

/// What is wrong at an instant of a recording, or from it on.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InstantFault {
    #[error("the {quantity} is {number}; give {low} to {high}")]
    Number { quantity: &'static str, number: f64, low: f64, high: f64 },
}

/// What a time between two instants (s) that is too long looks like.
fn unit_of_time(step: f64) -> &'static str {
    match step {
        5.0..=500.0 => "the times look like milliseconds; ",
        5e3..=5e5 => "the times look like microseconds; ",
        5e6..=5e8 => "the times look like nanoseconds; ",
        _ => "",
    }
}

/// How much farther something moves than is explained.
fn times(ratio: f64) -> String {
    if ratio.is_finite() { format!("{ratio:.2} times as far as") } else { "farther than".into() }
}
