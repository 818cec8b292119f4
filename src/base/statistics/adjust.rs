/// Adjusts p-values of several tests so that the chance of *any* false finding stays below the level that they are compared with.
///
/// # Source
/// Holm, *A simple sequentially rejective multiple test procedure*, Scandinavian Journal of Statistics 6, 1979.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut adjusted = vec![0.0; p.len()];
    let mut worst = 0.0_f64;
    for (rank, place) in ascending(p).into_iter().enumerate() {
        worst = worst.max(p[place] * (p.len() - rank) as f64).min(1.0);
        adjusted[place] = worst;
    }
    adjusted
}

/// The indices of numbers, from the smallest to the largest.
fn ascending(numbers: &[f64]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..numbers.len()).collect();
    places.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    places
}
