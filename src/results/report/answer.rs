//! The answer of a report: what was found about each driver under test, in a sentence.

use std::collections::BTreeMap;

use super::caution::CRAWLS;
use super::{DriverResult, Findings};
use crate::jobs::{KINDS, Said};
use crate::tables::metrics::{EPISODES, FAULT_COLLISIONS};
use crate::tables::{APPLIED, FAULT_VIOLATIONS, REQUIREMENT};

/// Above this share of encounters, surely, needless braking is a part of the answer.
const STANDS: f64 = 0.05;

/// Maximum number of drivers with a sentence each.
const MAX_DRIVERS: usize = 3;

/// A sentence about each driver under test, in the order of the report, or about the baselines if there is no other; then those of kinds of jobs. Of many drivers the worst
/// have a sentence, and the others share one.
pub fn answer(found: &Findings<'_>) -> Vec<String> {
    let tested: Vec<&DriverResult> =
        found.drivers.iter().filter(|result| !result.driver.sees_no_pedestrians()).collect();
    let shown = if tested.is_empty() { found.drivers.iter().collect() } else { tested };
    let of_kinds: Vec<Said> = KINDS.iter().flat_map(|kind| (kind.answer)(found)).collect();
    let is_lost = |result: &&&DriverResult| {
        let mut own = found.cells.iter().filter(|cell| cell.key.policy == result.driver.name).peekable();
        own.peek().is_some() && own.all(|cell| cell.count(&EPISODES) == 0)
    };
    let lost: Vec<String> = shown
        .iter()
        .filter(is_lost)
        .map(|result| format!("{} cannot be judged: none of its episodes counts", result.driver.name))
        .collect();
    let tried = shown
        .into_iter()
        .filter(|result| result.episodes > 0 || result.searched.is_some_and(|searched| searched.evaluated.1 > 0));
    let mut told: Vec<DriverAnswer> = tried.map(|result| told(found, result, &of_kinds)).collect();
    let is_many = told.len() > MAX_DRIVERS;
    let (fail, good): (Vec<_>, Vec<_>) = told.drain(..).partition(|driver| driver.verdict == FAILS || !is_many);
    let sentence = |driver: &DriverAnswer| format!("{} {}: {}", driver.name, driver.verdict, driver.parts.join("; "));
    let (shown, further) = fail.split_at(if is_many { MAX_DRIVERS.min(fail.len()) } else { fail.len() });
    let names: Vec<&str> = further.iter().map(|driver| driver.name).collect();
    let further = (!names.is_empty()).then(|| match names.as_slice() {
        [one] => format!("{one} fails, too"),
        all => format!("{} fail, too", all.join(", ")),
    });
    let others: Vec<String> = good.iter().map(DriverAnswer::in_brief).collect();
    let others = (!others.is_empty()).then(|| format!("No fault was found of {}", others.join(", ")));
    let of_drivers = shown.iter().map(sentence).chain(further).chain(others).chain(lost);
    of_drivers.chain(of_kinds.iter().map(|said| said.text.clone())).collect()
}

const FAILS: &str = "fails";

/// What is said of a driver.
struct DriverAnswer<'a> {
    name: &'a str,
    verdict: &'static str,
    parts: Vec<String>,
    /// What makes that it has no fault worth less; empty if there is nothing.
    but: Vec<String>,
    episodes: u64,
}

impl DriverAnswer<'_> {
    /// A driver without a fault, among others.
    fn in_brief(&self) -> String {
        let but: Vec<&str> = self.but.iter().map(String::as_str).collect();
        let episodes = format!("{} episodes", self.episodes);
        format!("{} ({})", self.name, std::iter::once(&*episodes).chain(but).collect::<Vec<_>>().join("; "))
    }
}

fn told<'a>(found: &Findings<'_>, result: &'a DriverResult, of_kinds: &[Said]) -> DriverAnswer<'a> {
    let name = &result.driver.name;
    // The cases of a test are no sample of episodes.
    let counts = |is_test: bool| {
        let own = found.cells.iter().filter(|cell| cell.key.policy == *name && cell.is_fixed_cases() == is_test);
        own.fold((0, 0), |(faults, episodes), cell| {
            (faults + u64::from(cell.count(&FAULT_COLLISIONS)), episodes + u64::from(cell.count(&EPISODES)))
        })
    };
    let mut tests: Vec<&str> = Vec::new();
    let cases = found.gathered.protocol.iter().filter(|case| case.policy == *name);
    cases.for_each(|case| tests.extend(Some(&*case.test).filter(|test| !tests.contains(test))));
    let cases = format!("cases of {}", tests.join(", "));
    let searched = result.searched.filter(|searched| searched.episodes > 0);
    let of_searches = searched.map_or(0, |searched| searched.fault as u64);
    let (evaluated, tests) = (counts(false), counts(true));
    // They tell what the others do not.
    let further = result.searched.map(|searched| searched.evaluated);
    let further = further.filter(|_| of_searches + evaluated.0 + tests.0 == 0).unwrap_or_default();
    let tried = [(further, "fresh episodes of what searches found"), (evaluated, "episodes"), (tests, &*cases)];
    let mut parts = Vec::new();
    if let Some(searched) = searched {
        parts.push(match searched.fault {
            0 => format!("none in {} episodes of searches", searched.episodes),
            1 => "1 fault in searches".into(),
            faults => format!("{faults} faults in searches"),
        });
    }
    for ((faults, of), what) in tried.into_iter().filter(|((_, of), _)| *of > 0) {
        parts.push(match faults {
            0 => format!("none in {of} {what}"),
            faults => format!("a fault in {faults} of {of} {what}"),
        });
    }
    let worst = result
        .worst
        .as_ref()
        .filter(|worst| worst.fault && worst.violation.is_none())
        .map(|worst| format!("the worst at {:.1} m/s", worst.impact_speed));
    parts.extend(worst);
    let breached = breaches(found, result);
    let is_breaking = !breached.is_empty();
    let progress = result.price.map(|price| price.progress);
    let is_crawling = progress.is_some_and(|progress| progress < CRAWLS);
    let needless = result.price.and_then(|price| price.needless()).filter(|(_, (low, _))| *low > STANDS);
    let needless = needless.map(|(share, _)| format!("brakes needlessly in {:.0} % of encounters", 100.0 * share));
    let told_progress = progress.map(|progress| format!("progress {progress:.2}"));
    let crawls = told_progress.clone().filter(|_| is_crawling).map(|progress| format!("hardly drives, {progress}"));
    let but = breached.iter().cloned().chain(crawls).chain(needless.clone()).collect();
    parts.extend(breached.into_iter().chain(told_progress).chain(needless));
    let fails_below = of_kinds.iter().any(|said| said.fails && said.driver == *name);
    parts.extend(fails_below.then(|| "a fault in encounters or a box, as below".into()));
    let verdict = match progress {
        _ if fails_below || of_searches + tried.iter().map(|((faults, _), _)| faults).sum::<u64>() > 0 => FAILS,
        Some(_) if is_crawling => "hardly drives",
        _ if is_breaking => "breaks requirements and has no fault",
        _ => "has no fault",
    };
    let episodes = searched.map_or(0, |searched| searched.episodes) + tried.iter().map(|((_, of), _)| of).sum::<u64>();
    DriverAnswer { name, verdict, parts, but, episodes }
}

/// The breaches of each requirement that has some, and those that searches for them found.
fn breaches(found: &Findings<'_>, result: &DriverResult) -> Vec<String> {
    let own = found.gathered.requirements.iter().filter(|cell| cell.key.policy == result.driver.name);
    let mut counts: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    for cell in own {
        let [breaches, applied] = counts.entry(cell.text(&REQUIREMENT)).or_default();
        *breaches += u64::from(cell.count(&FAULT_VIOLATIONS));
        *applied += u64::from(cell.count(&APPLIED));
    }
    let evaluated = counts.into_iter().filter(|(_, [breaches, _])| *breaches > 0);
    let evaluated = evaluated.map(|(name, [breaches, of])| format!("a breach of {name} in {breaches} of {of}"));
    let searched = result.searched.map(|searched| searched.breaches).filter(|breaches| *breaches > 0);
    evaluated
        .chain(searched.map(|breaches| match breaches {
            1 => "a breach in searches".into(),
            _ => format!("{breaches} breaches in searches"),
        }))
        .collect()
}
