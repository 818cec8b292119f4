use smartcore::cluster::kmeans::{KMeans, KMeansParameters};
use smartcore::linalg::basic::matrix::DenseMatrix;

/// Fewer points than this are one cluster.
const LEAST: usize = 40;
/// Most clusters that are tried.
const MOST: usize = 4;
/// Two halves must agree so well for clusters to count.
const STABLE: f64 = 0.8;
/// From so many beginnings k-means is run, of which the best counts; their numbers seed the choice of centres.
const BEGINNINGS: u64 = 10;

/// A partition of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters {
    /// The cluster of each point, from 0.
    pub labels: Vec<usize>,
    /// How well the partitions agree that k-means finds on the two halves, as adjusted Rand index; 1 for
    /// a single cluster.
    pub stability: f64,
}

/// Partitions points of equal dimension into as many clusters as two halves of them agree on: those of even and those of
/// odd groups, so that points which belong together stay in one half.
///
/// Features are standardised first.
pub fn clusters(points: &[Vec<f64>], groups: &[u32]) -> Clusters {
    let single = Clusters { labels: vec![0; points.len()], stability: 1.0 };
    if points.len() < LEAST {
        return single;
    }
    let points = standardised(points);
    let half = |rest: u32| {
        let members = points.iter().zip(groups).filter(|(_, group)| **group % 2 == rest);
        members.map(|(point, _)| point.clone()).collect::<Vec<_>>()
    };
    let (even, odd) = (half(0), half(1));
    let attempt = |k: usize| {
        let stability = adjusted_rand(&partition(&even, &points, k)?, &partition(&odd, &points, k)?);
        Some(Clusters { labels: partition(&points, &points, k)?, stability })
    };
    let stable = (2..=MOST).rev().filter_map(attempt).find(|found| found.stability >= STABLE);
    stable.unwrap_or(single)
}

/// Fits `k` centres to some points, from many beginnings, and says which centre is nearest to each of others; none when a
/// centre stays empty.
fn partition(fit: &[Vec<f64>], points: &[Vec<f64>], k: usize) -> Option<Vec<usize>> {
    if fit.len() < k {
        return None;
    }
    let matrix = |rows: &[Vec<f64>]| DenseMatrix::from_2d_vec(&rows.to_vec()).ok();
    let (data, others) = (matrix(fit)?, matrix(points)?);
    let attempt = |seed| {
        let parameters = KMeansParameters { k, max_iter: 100, seed: Some(seed) };
        let model: KMeans<f64, i32, DenseMatrix<f64>, Vec<i32>> = KMeans::fit(&data, parameters).ok()?;
        let labels = |rows| Some(model.predict(rows).ok()?.into_iter().map(|label| label as usize).collect::<Vec<_>>());
        Some((scatter(fit, &labels(&data)?, k), labels(&others)?))
    };
    let best = (0..BEGINNINGS).filter_map(attempt).min_by(|(a, _), (b, _)| a.total_cmp(b));
    best.map(|(_, labels)| labels).filter(|labels| (0..k).all(|cluster| labels.contains(&cluster)))
}

/// The sum of squared distances from the points to the middles of their clusters.
fn scatter(points: &[Vec<f64>], labels: &[usize], k: usize) -> f64 {
    let dimensions = points.first().map_or(0, Vec::len);
    let mut middles = vec![vec![0.0; dimensions]; k];
    let mut sizes = vec![0.0; k];
    for (point, label) in points.iter().zip(labels) {
        sizes[*label] += 1.0;
        middles[*label].iter_mut().zip(point).for_each(|(sum, x)| *sum += x);
    }
    let apart = |(point, label): (&Vec<f64>, &usize)| {
        let middle = middles[*label].iter().map(|sum| sum / sizes[*label]);
        point.iter().zip(middle).map(|(x, m)| (x - m).powi(2)).sum::<f64>()
    };
    points.iter().zip(labels).map(apart).sum()
}

fn standardised(points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = points.len() as f64;
    let dimensions = points.first().map_or(0, Vec::len);
    let scales: Vec<(f64, f64)> = (0..dimensions)
        .map(|axis| {
            let mean = points.iter().map(|point| point[axis]).sum::<f64>() / n;
            let variance = points.iter().map(|point| (point[axis] - mean).powi(2)).sum::<f64>() / n;
            (mean, if variance > 0.0 { variance.sqrt() } else { 1.0 })
        })
        .collect();
    points.iter().map(|point| point.iter().zip(&scales).map(|(x, (mean, sd))| (x - mean) / sd).collect()).collect()
}

/// The adjusted Rand index of two partitions of the same points.
///
/// # Source
/// Hubert and Arabie, *Comparing partitions*, Journal of Classification 2, 1985, eq. 5.
fn adjusted_rand(a: &[usize], b: &[usize]) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Points about the given centres, spread evenly by half a unit.
    fn around(centres: &[f64], each: usize) -> Vec<Vec<f64>> {
        let point = |i: usize| {
            let spread = (i as f64 * 0.618_034).fract() - 0.5;
            let centre = centres[i % centres.len()];
            vec![centre + spread, centre / 2.0 + (i as f64 * 0.414_214).fract()]
        };
        (0..each * centres.len()).map(point).collect()
    }

    #[test]
    fn three_heaps_are_found_and_one_is_not_split() {
        let groups: Vec<u32> = (0..90).collect();
        let found = clusters(&around(&[0.0, 10.0, 20.0], 30), &groups);
        assert_eq!(found.labels.iter().max(), Some(&2), "{found:?}");
        assert!(found.stability > 0.99);
        for (i, label) in found.labels.iter().enumerate() {
            assert_eq!(*label, found.labels[i % 3], "a heap is one cluster");
        }
        let few = clusters(&around(&[0.0, 10.0], 5), &groups[..10]);
        assert!(few.labels.iter().all(|label| *label == 0));
    }

    #[test]
    fn the_index_is_one_for_equal_and_near_zero_for_crossed_partitions() {
        assert_eq!(adjusted_rand(&[0, 0, 1, 1], &[1, 1, 0, 0]), 1.0);
        // Hubert and Arabie's definition by hand: 0 pairs together in both, 2 expected out of 6·(1/3)·(1/3).
        assert!((adjusted_rand(&[0, 0, 1, 1], &[0, 1, 0, 1]) + 0.5).abs() < 1e-12);
    }
}
