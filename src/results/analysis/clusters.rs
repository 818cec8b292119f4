use rand::RngExt;
use smartcore::cluster::kmeans::{KMeans, KMeansParameters};
use smartcore::linalg::basic::matrix::DenseMatrix;

use super::agreement::{adjusted_rand, silhouette};
use base::seed::Seed;

/// Fewer points than this are one cluster.
const LEAST: usize = 40;
/// The largest number of clusters that is evaluated.
const MOST: usize = 5;
/// Clusters count only if the two halves agree at least this well, and the bootstrap samples with the whole, too.
const STABLE: f64 = 0.8;
/// Clusters with a smaller silhouette have "no substantial structure" (Kaufman and Rousseeuw, *Finding Groups in Data*, 1990).
const APART: f64 = 0.25;
/// Number of runs of k-means, of which the best counts. The number of a run is the seed of its centres.
const BEGINNINGS: u64 = 5;
/// Number of bootstrap samples.
const SAMPLES: u64 = 10;

/// How far clusters can be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// Agreement of the partitions that k-means finds on the two halves, as adjusted Rand index.
    pub halves: f64,
    /// Agreement of the partitions of bootstrap samples with that of all points, as mean adjusted Rand index.
    pub bootstrap: f64,
    /// Mean silhouette.
    pub silhouette: f64,
}

/// A partition of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters {
    /// The cluster of each point, from 0.
    pub labels: Vec<usize>,
    /// Its stability; `None` for a single cluster.
    pub stability: Option<Stability>,
}

/// Partitions points of equal dimension into a number of clusters on which two halves of the points agree. The halves are those of even
/// and those of odd groups, so that points which belong together stay in one half. Bootstrap samples must agree as well. If several
/// numbers of clusters pass, the one with the largest silhouette counts.
///
/// K-means also cuts one long cluster in two, and the halves may agree on the cut. So clusters are a view of the data, not a finding.
pub fn clusters(points: &[Vec<f64>], groups: &[u32]) -> Clusters {
    let single = Clusters { labels: vec![0; points.len()], stability: None };
    if points.len() < LEAST {
        return single;
    }
    let half = |rest: u32| {
        let members = points.iter().zip(groups).filter(|(_, group)| **group % 2 == rest);
        members.map(|(point, _)| point.clone()).collect::<Vec<_>>()
    };
    let (even, odd) = (half(0), half(1));
    let attempt = |k: usize| {
        let halves = adjusted_rand(&partition(&even, points, k)?, &partition(&odd, points, k)?);
        if halves < STABLE {
            return None;
        }
        let labels = partition(points, points, k)?;
        let silhouette = silhouette(points, &labels).filter(|width| *width >= APART)?;
        let bootstrap = bootstrap(points, &labels);
        (bootstrap >= STABLE).then_some((labels, Stability { halves, bootstrap, silhouette }))
    };
    let best = (2..=MOST).filter_map(attempt).max_by(|a, b| a.1.silhouette.total_cmp(&b.1.silhouette));
    best.map_or(single, |(labels, stability)| Clusters { labels, stability: Some(stability) })
}

/// Agreement of partitions of samples drawn with replacement with this one. A sample with fewer clusters counts as 0.
fn bootstrap(points: &[Vec<f64>], labels: &[usize]) -> f64 {
    let k = labels.iter().max().map_or(1, |most| most + 1);
    let agreement = |sample| {
        let mut stream = Seed::root(0).child("bootstrap of clusters").index(sample).stream();
        let drawn: Vec<Vec<f64>> =
            points.iter().map(|_| points[stream.random_range(0..points.len())].clone()).collect();
        partition(&drawn, points, k).map_or(0.0, |other| adjusted_rand(labels, &other))
    };
    (0..SAMPLES).map(agreement).sum::<f64>() / SAMPLES as f64
}

/// Fits `k` centres to some points in several runs, and returns the nearest centre of each other point; `None` if a centre has no points.
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

/// The sum of squared distances from the points to the centres of their clusters.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Points around the given centres, spread evenly by half a unit.
    fn around(centres: &[f64], each: usize) -> Vec<Vec<f64>> {
        let point = |i: usize| {
            let spread = (i as f64 * 0.618_034).fract() - 0.5;
            let centre = centres[i % centres.len()];
            vec![centre + spread, centre / 2.0 + (i as f64 * 0.414_214).fract()]
        };
        (0..each * centres.len()).map(point).collect()
    }

    #[test]
    fn three_heaps_are_found_and_a_few_points_are_not_split() {
        let groups: Vec<u32> = (0..90).collect();
        let found = clusters(&around(&[0.0, 10.0, 20.0], 30), &groups);
        assert_eq!(found.labels.iter().max(), Some(&2), "{found:?}");
        let stability = found.stability.unwrap();
        assert!(stability.halves > 0.99 && stability.bootstrap > 0.99 && stability.silhouette > 0.8, "{stability:?}");
        for (i, label) in found.labels.iter().enumerate() {
            assert_eq!(*label, found.labels[i % 3], "a heap is one cluster");
        }
        let few = clusters(&around(&[0.0, 10.0], 5), &groups[..10]);
        assert!(few.labels.iter().all(|label| *label == 0) && few.stability.is_none());
    }

    #[test]
    fn a_round_heap_in_many_dimensions_is_not_split() {
        let mut stream = Seed::root(1).stream();
        let points: Vec<Vec<f64>> =
            (0..200).map(|_| (0..8).map(|_| stream.random_range(-1.0..1.0)).collect()).collect();
        let found = clusters(&points, &(0..200).collect::<Vec<_>>());
        assert!(found.stability.is_none(), "{found:?}");
    }
}
