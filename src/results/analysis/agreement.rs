/// The adjusted Rand index of two partitions of the same points: 1 when they are equal, 0 on average when they are independent.
///
/// # Source
/// Hubert and Arabie, *Comparing partitions*, Journal of Classification 2, 1985, eq. 5.
pub(super) fn adjusted_rand(a: &[usize], b: &[usize]) -> f64 {
    let pairs = |n: usize| n as f64 * (n as f64 - 1.0) / 2.0;
    let size = |labels: &[usize]| labels.iter().max().map_or(0, |most| most + 1);
    let mut table = vec![vec![0usize; size(b)]; size(a)];
    for (x, y) in a.iter().zip(b) {
        table[*x][*y] += 1;
    }
    let both: f64 = table.iter().flatten().map(|n| pairs(*n)).sum();
    let rows: f64 = table.iter().map(|row| pairs(row.iter().sum())).sum();
    let columns: f64 = (0..size(b)).map(|y| pairs(table.iter().map(|row| row[y]).sum())).sum();
    let expected = rows * columns / pairs(a.len());
    let most = (rows + columns) / 2.0;
    if most == expected { 1.0 } else { (both - expected) / (most - expected) }
}

/// The mean silhouette of a partition: 1 when the clusters are points far apart, about 0 when points lie between them.
///
/// A point alone in its cluster counts as 0. The result is `None` for one cluster and for no points.
///
/// # Source
/// Rousseeuw, *Silhouettes: a graphical aid to the interpretation and validation of cluster analysis*, J. Comput. Appl. Math. 20, 1987.
pub(super) fn silhouette(points: &[Vec<f64>], labels: &[usize]) -> Option<f64> {
    let clusters = labels.iter().max().filter(|most| **most > 0)? + 1;
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt();
    let mut sizes = vec![0.0; clusters];
    labels.iter().for_each(|label| sizes[*label] += 1.0);
    let width = |(point, own): (&Vec<f64>, &usize)| {
        let mut sums = vec![0.0; clusters];
        points.iter().zip(labels).for_each(|(other, label)| sums[*label] += apart(point, other));
        if sizes[*own] <= 1.0 {
            return 0.0;
        }
        let within = sums[*own] / (sizes[*own] - 1.0);
        let others = (0..clusters).filter(|cluster| cluster != own && sizes[*cluster] > 0.0);
        let nearest = others.map(|cluster| sums[cluster] / sizes[cluster]).fold(f64::INFINITY, f64::min);
        let most = within.max(nearest);
        if most > 0.0 { (nearest - within) / most } else { 0.0 }
    };
    Some(points.iter().zip(labels).map(width).sum::<f64>() / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{number, numbers, recorded};
    use super::*;

    #[test]
    fn both_figures_are_those_of_scikit_learn() {
        let record = recorded();
        for case in record["partitions"].as_array().unwrap() {
            let labels = |name| numbers(&case[name]).iter().map(|label| *label as usize).collect::<Vec<_>>();
            let points: Vec<Vec<f64>> = case["points"].as_array().unwrap().iter().map(numbers).collect();
            let (a, b) = (labels("a"), labels("b"));
            assert!((adjusted_rand(&a, &b) - number(&case["adjusted_rand"])).abs() < 1e-12);
            assert!((silhouette(&points, &a).unwrap() - number(&case["silhouette"])).abs() < 1e-12);
        }
    }

    #[test]
    fn the_index_is_one_for_equal_and_below_zero_for_crossed_partitions() {
        assert_eq!(adjusted_rand(&[0, 0, 1, 1], &[1, 1, 0, 0]), 1.0);
        // Hubert and Arabie's definition by hand: 0 pairs together in both, 2 expected out of 6·(1/3)·(1/3).
        assert!((adjusted_rand(&[0, 0, 1, 1], &[0, 1, 0, 1]) + 0.5).abs() < 1e-12);
        assert_eq!(silhouette(&[vec![1.0], vec![2.0]], &[0, 0]), None);
    }
}
