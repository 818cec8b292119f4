//! The harm that a touch may do, by the speed of the car.

/// From this impact speed on (m/s) a touch is *hard*. Half of all touches are slower, down to a tenth of it; they are found by the same rules
/// and mean less. Our choice: a jog.
pub const HARD: f64 = 2.0;

/// The probability that a grown-up pedestrian dies who is struck by the front of a car at this speed (m/s).
///
/// `P = 1 / (1 + exp(6.9 − 0.090 v))` with `v` in km/h.
///
/// # Source
/// Rosén and Sander, *Pedestrian fatality risk as a function of car impact speed*, Accident Analysis and Prevention 41 (2009) 536–542: 2,127
/// pedestrians aged 15 to 96 in the German in-depth study GIDAS.
pub fn fatality_risk(impact_speed: f64) -> f64 {
    logistic(0.090 * impact_speed * KMH - 6.9)
}

/// The probability that a pedestrian who is struck by the front of a car at this speed (m/s) is severely injured (AIS 4 or more) or dies.
///
/// `P = 1 / (1 + exp(4.68 − 0.0881 v))` with `v` in km/h: the logistic curve through the published speeds at which the risk is 10 % and 90 %;
/// those of 25, 50 and 75 % are met within 0.02.
///
/// # Source
/// Tefft, *Impact speed and a pedestrian's risk of severe injury or death*, Accident Analysis and Prevention 50 (2013) 871–878: United
/// States, 1994 to 1998, standardised to 2007 to 2009. 10, 25, 50, 75 and 90 % at 17.1, 24.9, 33.0, 40.8 and 48.1 mph.
pub fn severe_injury_risk(impact_speed: f64) -> f64 {
    logistic(0.0881 * impact_speed * KMH - 4.68)
}

/// One m/s in km/h.
const KMH: f64 = 3.6;

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}
