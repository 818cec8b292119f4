//! The harm that a touch may do, by the speed of the car.

/// The probability that a pedestrian who is struck by the front of a car at this speed (m/s) is severely injured (AIS 4 or more) or dies.
///
/// `P = 1 / (1 + exp(4.68 − 0.0881 v))` with `v` in km/h: the logistic curve through the published speeds at which the risk is 10 % and 90 %;
/// those of 25, 50 and 75 % are met within 0.02.
///
/// # Source
/// Tefft, *Impact speed and a pedestrian's risk of severe injury or death*, Accident Analysis and Prevention 50 (2013) 871–878: United
/// States, 1994 to 1998, standardised to 2007 to 2009. 10, 25, 50, 75 and 90 % at 17.1, 24.9, 33.0, 40.8 and 48.1 mph.
pub fn severe_injury_risk(impact_speed: f64) -> f64 {
    /// One m/s in km/h.
    const KMH: f64 = 3.6;
    1.0 / (1.0 + libm::exp(4.68 - 0.0881 * impact_speed * KMH))
}
