use std::collections::BTreeMap;

use super::clusters::clusters;
use super::{Approach, Kind, Stability};
use crate::failure::Failure;

/// A mode of collisions: those of one kind with similar approaches.
#[derive(Debug, Clone, PartialEq)]
pub struct FailureMode {
    /// The class of its collisions.
    pub kind: Kind,
    /// The number of collisions of that kind.
    pub failures: usize,
    /// Number of the cluster within the kind, from 0, the largest first.
    pub cluster: usize,
    /// The number of clusters of the kind.
    pub clusters: usize,
    /// Share of all collisions. The share of a cluster within its kind is that among the collisions whose approach is known.
    pub share: f64,
    /// Its collisions, as indices in the given list: those whose approach is known, or all of the kind if none is known.
    pub members: Vec<usize>,
    /// The member that is nearest to all the others, as index in the given list.
    pub medoid: usize,
    /// Root mean square distance of the members from the medoid (m), see [`Approach::distance`]; `None` if no approach is known.
    pub spread: Option<f64>,
    /// Quantiles of the car's speed at the touch (m/s): 10 %, 50 % and 90 % of the members are at most as fast.
    pub impact_speed: [f64; 3],
    /// Median time from the start of the episode to the touch (s).
    pub length: f64,
    /// The stability of the clusters of the kind; `None` for a single cluster.
    pub stability: Option<Stability>,
}

/// Finds the modes of collisions, the most frequent first. Runs are pooled, so a mode may come from one training alone.
pub fn failure_modes(failures: &[Failure]) -> Vec<FailureMode> {
    let mut kinds: BTreeMap<Kind, Vec<usize>> = BTreeMap::new();
    for (place, failure) in failures.iter().enumerate() {
        if let Some(kind) = Kind::of(failure) {
            kinds.entry(kind).or_default().push(place);
        }
    }
    let mut modes: Vec<FailureMode> =
        kinds.into_iter().flat_map(|(kind, places)| modes_of(kind, &places, failures)).collect();
    modes.sort_by(|a, b| b.share.total_cmp(&a.share));
    modes
}

fn modes_of(kind: Kind, places: &[usize], failures: &[Failure]) -> Vec<FailureMode> {
    let (mut known, mut approaches) = (Vec::new(), Vec::new());
    for place in places {
        if let Some(approach) = &failures[*place].approach {
            known.push(*place);
            approaches.push(approach);
        }
    }
    let share = places.len() as f64 / failures.len() as f64;
    let mode = |members: Vec<usize>, medoid, spread| {
        let quantile = |value: &dyn Fn(&Failure) -> f64, share| {
            let mut values: Vec<f64> = members.iter().map(|member| value(&failures[*member])).collect();
            values.sort_by(f64::total_cmp);
            quantile(&values, share)
        };
        FailureMode {
            kind,
            failures: places.len(),
            cluster: 0,
            clusters: 1,
            share,
            medoid,
            spread,
            impact_speed: [0.1, 0.5, 0.9].map(|share| quantile(&|failure| failure.impact_speed, share)),
            length: quantile(&|failure| failure.length, 0.5),
            stability: None,
            members,
        }
    };
    if known.is_empty() {
        return vec![mode(places.to_vec(), places[0], None)];
    }
    let points: Vec<Vec<f64>> = approaches.iter().map(|approach| approach.features()).collect();
    // Episodes of equal numbers have equal starts, in every run.
    let groups: Vec<u32> = known.iter().map(|place| failures[*place].number as u32).collect();
    let found = clusters(&points, &groups);
    let count = found.labels.iter().max().map_or(1, |most| most + 1);
    let mut heaps: Vec<Vec<usize>> = vec![Vec::new(); count];
    found.labels.iter().enumerate().for_each(|(index, label)| heaps[*label].push(index));
    heaps.sort_by_key(|heap| std::cmp::Reverse(heap.len()));
    let numbered = heaps.into_iter().enumerate().map(|(cluster, heap)| {
        let (medoid, spread) = medoid(&heap, &approaches);
        FailureMode {
            cluster,
            clusters: count,
            share: share * heap.len() as f64 / known.len() as f64,
            stability: found.stability,
            ..mode(heap.iter().map(|index| known[*index]).collect(), known[medoid], Some(spread))
        }
    });
    numbered.collect()
}

/// The approach with the least sum of distances from the others, and the root mean square of these distances (m).
fn medoid(heap: &[usize], approaches: &[&Approach]) -> (usize, f64) {
    let distances = |one: usize| heap.iter().map(move |other| approaches[one].distance(approaches[*other]));
    let sums = heap.iter().map(|one| (*one, distances(*one).sum::<f64>()));
    let (medoid, _) = sums.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a cluster has a member");
    let squares: f64 = distances(medoid).map(|distance| distance * distance).sum();
    (medoid, (squares / heap.len() as f64).sqrt())
}

/// The quantile of sorted values, linear between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    low + (high - low) * place.fract()
}
