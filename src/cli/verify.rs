use std::collections::{BTreeMap, BTreeSet};

use rand::seq::index::sample;
use rayon::prelude::*;

use super::repeat::{self, Source};
use super::repeat_args::{Name, VerifyOptions};
use super::{ExitCode, front};
use crate::campaign::{self, InMemory, Silent};
use crate::compile::{Campaign, Training};
use crate::report::StoredReport;
use crate::seed::Seed;

/// Most differences that are shown.
const SHOWN: usize = 10;

/// `falsify verify`
pub fn verify(options: &VerifyOptions) -> ExitCode {
    let source = StoredReport::open(&options.report)
        .map_err(|error| repeat::unreadable(&error))
        .and_then(|report| repeat::open(report, &options.repeat));
    let source = match source {
        Ok(source) => source,
        Err(code) => return code,
    };
    let names = match chosen(&source, options) {
        Ok(names) => names,
        Err(code) => return code,
    };
    let unequal = match repeat_all(&source, &names) {
        Ok(unequal) => unequal,
        Err(code) => return code,
    };
    front::say(&format!(
        "episodes and failures of searches: {} repeated, {} equal",
        names.len(),
        names.len() - unequal
    ));
    let mut differ = unequal > 0;
    if options.trainings {
        let (trained, equal) = trainings(&source);
        front::say(&format!("trainings: {trained} repeated, {equal} equal"));
        differ |= equal < trained;
    }
    if differ {
        repeat::reasons(source.report.manifest()).iter().for_each(|reason| front::say(&format!("perhaps {reason}")));
        return ExitCode::Differs;
    }
    ExitCode::Done
}

/// The episodes and failures that are to be repeated, in the order of the tables.
fn chosen(source: &Source, options: &VerifyOptions) -> Result<Vec<Name>, ExitCode> {
    let unreadable = |error| repeat::unreadable(&error);
    let mut all = source.report.index().map_err(unreadable)?;
    all.extend(source.report.search_failures().map_err(unreadable)?);
    let places: BTreeSet<usize> = if options.all || options.sample >= all.len() {
        (0..all.len()).collect()
    } else {
        let mut stream = Seed::root(options.seed).child("verify").stream();
        sample(&mut stream, all.len(), options.sample).into_iter().collect()
    };
    let name = |place: usize| {
        let (run, number) = &all[place];
        let name = format!("{run}:{number}").parse();
        name.map_err(|_| {
            front::fail(&format!("`{run}:{number}` in a table is no name of an episode"));
            ExitCode::Usage
        })
    };
    places.into_iter().map(name).collect()
}

/// Repeats them, run by run; says what differs and gives how many do.
fn repeat_all(source: &Source, names: &[Name]) -> Result<usize, ExitCode> {
    let mut runs: BTreeMap<_, Vec<Name>> = BTreeMap::new();
    for name in names {
        runs.entry(name.run).or_default().push(*name);
    }
    let runs: Vec<Vec<Name>> = runs.into_values().collect();
    let repeated: Vec<Result<Vec<_>, ExitCode>> = runs
        .par_iter()
        .map(|run| run.iter().map(|name| source.repeat(*name)).collect::<Result<Vec<_>, _>>())
        .map(|run| run.map(|all| all.into_iter().filter(|repeated| !repeated.differences.is_empty()).collect()))
        .collect();
    let mut unequal = Vec::new();
    for run in repeated {
        unequal.extend(run?);
    }
    for repeated in unequal.iter().take(SHOWN) {
        let columns: Vec<&str> = repeated.differences.iter().map(|difference| difference.column.as_str()).collect();
        let parting = repeated.parting.as_ref().map_or(String::new(), |parting| format!("; it parts {parting}"));
        front::fail(&format!("{} came out differently: {}{parting}", repeated.name, columns.join(", ")));
    }
    if unequal.len() > SHOWN {
        front::fail(&format!("… and {} more", unequal.len() - SHOWN));
    }
    Ok(unequal.len())
}

/// Trains all pedestrians of the report again; gives how many, and how many are equal to the bit.
fn trainings(source: &Source) -> (usize, usize) {
    let of_report = |training: &&Training| source.report.pedestrian(&training.key).is_ok();
    let trainings: Vec<&Training> = source.campaign.trainings.iter().filter(of_report).collect();
    let alone = Campaign {
        trainings: trainings.iter().map(|training| (*training).clone()).collect(),
        evaluations: Vec::new(),
        searches: Vec::new(),
        ..source.campaign.clone()
    };
    let finished = campaign::run(&alone, &source.seed, &InMemory::default(), &Silent);
    let mut equal = 0;
    for training in &finished.trainings {
        let key = &training.key;
        let again = training.result.as_ref().ok().map(|trained| trained.actor_critic.to_safetensors(&BTreeMap::new()));
        let stored = source.report.pedestrian(key).ok().map(|stored| stored.to_safetensors(&BTreeMap::new()));
        if again.is_some() && again == stored {
            equal += 1;
        } else {
            let who = format!("{} in {} against {}, run {}", key.reward, key.town, key.policy, key.run);
            front::fail(&format!("the training of {who} came out differently"));
        }
    }
    (trainings.len(), equal)
}
