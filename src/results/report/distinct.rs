use std::collections::BTreeSet;

use super::Findings;
use super::alike::clusters;
use super::render::listed;
use super::replayed::played_failure;
use crate::failure::Failure;
use crate::parallel;
use base::seed::Seed;
use verdict::cause::{Cause, Incident, MAX_RUNS, Questions, RunLimit, Shrunk, explain, explain_any, shrink};

/// Maximum number of failures of a page that are shrunk, the first of its list.
pub const MAX_SHRUNK: usize = 24;
/// Maximum number of failures of a page whose cause is found.
const MAX_EXPLAINED: usize = 8;
/// Maximum number of simulator ticks in which a failure of a page is shrunk, and as many in which its cause is found.
const MAX_TICKS: u64 = 1_200_000;
/// Of how many failures of programs the cause is asked, the first of different kinds.
pub const MAX_OF_PROGRAMS: usize = 3;

/// A failure for all that shrink to the same.
#[derive(Debug, Clone)]
pub struct DistinctFailure {
    pub failure: Failure,
    /// The number of failures that shrink to it, itself included.
    pub merged: usize,
    /// The number of failures of its driver's list that are in its cluster, itself included.
    pub alike: usize,
    /// The number of commands before and after it was shrunk; `None` if it was not repeated.
    pub commands: Option<[usize; 2]>,
    /// Whether it was asked why it happened.
    pub is_asked: bool,
    /// Why it happened as it was recorded, not as it was shrunk; `None` if that was not asked, or if it does not repeat.
    pub cause: Option<Cause>,
}

/// The first of the items of each class, with how many there are. An item without a class is alone.
pub fn first_of_each<T, C: PartialEq>(items: impl IntoIterator<Item = (T, Option<C>)>) -> Vec<(T, usize)> {
    let mut firsts: Vec<(T, usize)> = Vec::new();
    let mut classes: Vec<Option<C>> = Vec::new();
    for (item, class) in items {
        match classes.iter().position(|known| class.is_some() && *known == class) {
            Some(place) => firsts[place].1 += 1,
            None => {
                firsts.push((item, 1));
                classes.push(class);
            }
        }
    }
    firsts
}

/// The distinct ones among the first failures of the list of a page, in which the worst of each cluster comes before the others. Those of a program of the user
/// are left out, which may take long to start.
pub fn listed_findings(found: &Findings<'_>, seed: &Seed) -> Vec<DistinctFailure> {
    let listed = listed(&found.drivers, &found.gathered.failures).into_iter();
    let own: Vec<&Failure> = listed.filter(|failure| !is_of_program(found, failure)).collect();
    let clusters = clusters_of(&own);
    let mut seen = BTreeSet::new();
    let (first, others): (Vec<_>, Vec<_>) =
        own.iter().zip(&clusters).partition(|(_, cluster)| seen.insert((*cluster).clone()));
    let chosen: Vec<&Failure> = first.into_iter().chain(others).take(MAX_SHRUNK).map(|(failure, _)| *failure).collect();
    let mut distinct = distinct_failures(found, &chosen, MAX_EXPLAINED, seed);
    for each in &mut distinct {
        let cluster =
            own.iter().position(|failure| failure.name() == each.failure.name()).map(|place| &clusters[place]);
        each.alike = clusters.iter().filter(|other| Some(*other) == cluster).count();
    }
    distinct
}

/// The driver and the cluster of each failure.
fn clusters_of(failures: &[&Failure]) -> Vec<(String, usize)> {
    let of = |failure: &Failure| failure.key.cell.policy.clone();
    let drivers: BTreeSet<String> = failures.iter().map(|failure| of(failure)).collect();
    let mut found = vec![(String::new(), 0); failures.len()];
    for driver in drivers {
        let own: Vec<usize> = (0..failures.len()).filter(|place| of(failures[*place]) == driver).collect();
        let clusters = clusters(&own.iter().map(|place| failures[*place]).collect::<Vec<_>>());
        own.into_iter().zip(clusters).for_each(|(place, cluster)| found[place] = (driver.clone(), cluster));
    }
    found
}

/// The distinct ones among some failures, with the causes of the first. Those of a program of the user are not shrunk, and those of another simulator not
/// repeated.
pub fn distinct_failures(
    found: &Findings<'_>,
    failures: &[&Failure],
    max_explained: usize,
    seed: &Seed,
) -> Vec<DistinctFailure> {
    let repeated = parallel::map(failures, |failure| {
        let (.., repeated) =
            (!is_of_program(found, failure)).then(|| played_failure(&failure.name(), found, seed))??;
        let incident = repeated.incident()?;
        let shrunk = shrink(&incident, runs_of(&incident))?;
        Some((incident, shrunk))
    });
    let class = |failure: &Failure, shrunk: &Shrunk| (failure.key.cell.policy.clone(), shrunk.class());
    let classed = failures.iter().zip(repeated).map(|(failure, repeated)| {
        let class = repeated.as_ref().map(|(_, shrunk)| class(failure, shrunk));
        ((*failure, repeated), class)
    });
    let firsts = first_of_each(classed);
    let mut kinds = Vec::new();
    let mut is_asked = |place: usize, failure: &Failure| {
        if !is_of_program(found, failure) {
            return place < max_explained;
        }
        let kind = (failure.key.cell.policy.clone(), failure.kind());
        let is_new = !failure.key.cell.is_elsewhere() && kinds.len() < MAX_OF_PROGRAMS && !kinds.contains(&kind);
        kinds.extend(is_new.then_some(kind));
        is_new
    };
    let asked: Vec<bool> =
        firsts.iter().enumerate().map(|(place, ((failure, _), _))| is_asked(place, failure)).collect();
    let each: Vec<_> = firsts.into_iter().zip(asked).collect();
    let causes = parallel::map(&each, |(((failure, repeated), _), is_asked)| match repeated {
        _ if !is_asked => None,
        Some((incident, _)) => {
            let limit = RunLimit { max_runs: runs_of(incident), ..RunLimit::default() };
            explain(incident, Questions::OfCopied, limit)
        }
        None => explain_any(&played_failure(&failure.name(), found, seed)?.2.incident()?),
    });
    let distinct = |((((failure, repeated), merged), is_asked), cause): (_, Option<Cause>)| {
        let repeated: Option<(Incident, Shrunk)> = repeated;
        let failure: &Failure = failure;
        DistinctFailure {
            failure: failure.clone(),
            merged,
            alike: merged,
            commands: repeated.map(|(_, shrunk)| shrunk.counts),
            is_asked,
            cause,
        }
    };
    each.into_iter().zip(causes).map(distinct).collect()
}

/// The number of runs of a failure for a page: [`MAX_RUNS`], and fewer of a very long episode.
fn runs_of(incident: &Incident) -> u32 {
    let (scenario, commands) = (&incident.scenario, incident.commands.len() as u64);
    let decisions = commands / scenario.cast.pedestrians.len() as u64;
    let ticks = (decisions * u64::from(scenario.episode.hold)).max(1);
    (MAX_TICKS / ticks).clamp(1, MAX_RUNS.into()) as u32
}

/// Whether the driver of a failure is a program of the user, or it happened in another simulator: they are expensive to run.
pub fn is_of_program(found: &Findings<'_>, failure: &Failure) -> bool {
    failure.key.cell.is_elsewhere()
        || found.drivers.iter().any(|each| each.driver.name == failure.key.cell.policy && each.driver.is_external())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_each_class_is_kept_and_counts_the_others() {
        let items = [("a", Some(1)), ("b", None), ("c", Some(2)), ("d", Some(1)), ("e", None), ("f", Some(1))];
        assert_eq!(first_of_each(items), [("a", 3), ("b", 1), ("c", 1), ("e", 1)]);
    }
}
