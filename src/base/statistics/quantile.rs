/// The value below which a share of sorted numbers lies, with linear interpolation; `None` without numbers.
///
/// # Source
/// Hyndman and Fan, *Sample quantiles in statistical packages*, The American Statistician 50, 1996, definition 7, as in numpy
/// and pandas.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * (sorted.len().checked_sub(1)?) as f64;
    let below = place.floor();
    let (low, high) = (sorted[below as usize], sorted[place.ceil() as usize]);
    Some(low + (high - low) * (place - below))
}
