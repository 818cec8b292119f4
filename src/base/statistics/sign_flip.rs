use super::{mcnemar, normal_below};

/// Above this number of steps the normal approximation is used, whose error is then below 0.001.
const MAX_STEPS: u64 = 100_000_000;

/// The exact randomisation test of paired differences: the probability of a sum at least as far from 0, if each difference is as likely as its negative. Of
/// differences of one size it is [`mcnemar`]'s. 1 without any.
///
/// # Source
/// Fisher, *The Design of Experiments*, 1935, section 21.
pub fn sign_flip(differences: &[i64]) -> f64 {
    let sizes: Vec<u64> = differences.iter().map(|each| each.unsigned_abs()).filter(|size| *size > 0).collect();
    let sum = differences.iter().sum::<i64>().unsigned_abs();
    let count = |is: fn(&i64) -> bool| differences.iter().copied().filter(is).count() as u64;
    if sizes.windows(2).all(|pair| pair[0] == pair[1]) {
        return mcnemar(count(|each| *each < 0), count(|each| *each > 0));
    }
    let all: u64 = sizes.iter().sum();
    if sum == 0 {
        return 1.0;
    }
    if all.saturating_mul(sizes.len() as u64) > MAX_STEPS {
        let squares: f64 = sizes.iter().map(|size| (size * size) as f64).sum();
        return 2.0 * normal_below(-(sum as f64) / squares.sqrt());
    }
    // The probability of each sum of the differences that are positive: it is far from half of all where the sum is far from 0.
    let mut chances = vec![0.0; all as usize + 1];
    chances[0] = 1.0;
    let mut reached = 0;
    for size in sizes.iter().map(|size| *size as usize) {
        reached += size;
        for positive in (0..=reached).rev() {
            let with = if positive >= size { chances[positive - size] } else { 0.0 };
            chances[positive] = (chances[positive] + with) / 2.0;
        }
    }
    let tail: f64 = chances[..=((all - sum) / 2) as usize].iter().sum();
    (2.0 * tail).min(1.0)
}
