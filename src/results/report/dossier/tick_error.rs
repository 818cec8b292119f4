use std::sync::Arc;

use super::{NOT_DONE, section};
use crate::jobs::{Repeatable, Repeated, TrainingResult, networks};
use crate::parallel;
use crate::report::Findings;
use crate::report::distinct::is_of_program;
use crate::report::render::{Section, Selection, Table, Value};
use crate::report::replayed::played_failure;
use base::seed::Seed;
use compile::Evaluation;
use episode::{EpisodeRule, Scenario, recorded_commands};
use verdict::Judged;
use verdict::cause::{Incident, Reruns};

/// Maximum number of failures, and of episodes of evaluations, that are run again.
const MAX_EPISODES: usize = 100;
/// Parts into which a tick is divided.
const PARTS: [u32; 2] = [2, 10];

/// How many verdicts change if the tick is a half or a tenth, with the same commands of the pedestrian at the same times.
pub fn tick_error(found: &Findings<'_>, seed: &Seed) -> Section {
    let is_program =
        |name: &str| found.drivers.iter().any(|each| each.driver.name == name && each.driver.is_external());
    let listed = found.drivers.iter().flat_map(|each| found.gathered.failures.of(&each.driver.name));
    let failures = listed.filter(|failure| !is_of_program(found, failure)).take(MAX_EPISODES);
    let names: Vec<String> = failures.map(crate::failure::Failure::name).collect();
    let failures = parallel::map(&names, |name| Some(incident(played_failure(name, found, seed)?.2)));
    let evaluations: Vec<&Evaluation> = found
        .campaign
        .all::<Evaluation>()
        .filter(|each| !is_program(&each.policy) && each.scenario.external_world.is_none())
        .collect();
    let each = MAX_EPISODES.div_ceil(evaluations.len().max(1)) as u32;
    let episodes = parallel::map(&evaluations, |evaluation| {
        let numbers: Vec<u32> = (0..evaluation.episodes.min(each)).collect();
        let networks = networks(evaluation, found.finished.all::<TrainingResult>());
        let numbers = numbers.iter().map(|number| Repeatable::Episode { evaluation, networks, number: *number });
        numbers.filter_map(|each| each.repeat(seed).map(incident)).collect::<Vec<_>>()
    });
    let failures: Vec<Incident> = failures.into_iter().flatten().collect();
    let episodes: Vec<Incident> = episodes.into_iter().flatten().collect();
    if failures.is_empty() && episodes.is_empty() {
        let lead =
            format!("{NOT_DONE} Episodes of programs and of other simulators are not run again with a shorter tick.");
        return section("error", "Numerical error", vec![lead], Vec::new());
    }
    let mut rows = Vec::new();
    for (what, incidents) in [("listed failures", &failures), ("first episodes of the evaluations", &episodes)] {
        let ends =
            parallel::map(incidents, |incident| Some((end(incident, 1)?, PARTS.map(|parts| end(incident, parts)))));
        let ends: Vec<_> = ends.into_iter().flatten().collect();
        for (place, parts) in PARTS.into_iter().enumerate() {
            let compared = ends.iter().filter_map(|(whole, fine)| Some((whole, fine[place].as_ref()?)));
            let [mut all, mut collisions, mut faults] = [0u64; 3];
            for (whole, fine) in compared {
                all += 1;
                collisions += u64::from(whole.0 != fine.0);
                faults += u64::from(whole.1 != fine.1);
            }
            rows.push((what, parts, [collisions, faults].map(|changes| Value::Of(changes, all))));
        }
    }
    let shown = Selection::new()
        .text("episodes", |(what, ..): &(&str, u32, [Value; 2])| (*what).to_owned())
        .text("tick", |(_, parts, _)| format!("1/{parts}"))
        .number("collision or not changes", |(.., [collisions, _])| collisions.clone())
        .number("fault or not changes", |(.., [_, faults])| faults.clone());
    let table = Table {
        notes: vec![
            "The pedestrian's commands and their times are the same; the driver decides more often. A driver with noisy sensors gets other noise, and one that counts ticks other times: \
             their changes are more than numerical error."
                .into(),
        ],
        ..shown.table(&rows)
    };
    section("error", "Numerical error", Vec::new(), vec![table])
}

/// What repeats an episode.
fn incident(repeated: Repeated) -> Incident {
    let Repeated { scenario, trace, start: (seed, start), .. } = repeated;
    Incident { criterion: scenario.criterion, commands: recorded_commands(&trace), scenario, seed, start }
}

/// Whether the episode ends with a collision, and with a fault, with a tick of this part; `None` if it does not come to an end.
fn end(incident: &Incident, parts: u32) -> Option<(bool, bool)> {
    let mut scenario = Scenario::clone(&incident.scenario);
    let rule = &scenario.episode;
    scenario.episode = EpisodeRule {
        tick: rule.tick / f64::from(parts),
        hold: rule.hold * parts,
        ticks: rule.ticks * parts,
        ..rule.clone()
    };
    let scenario = Arc::new(scenario);
    let rerun = Reruns::with(incident, scenario.clone()).run(&incident.commands)?;
    let judged = Judged::new(&rerun.outcome, &rerun.trace.main_pair(&scenario));
    Some((rerun.outcome.is_collision(), judged.verdict.is_some_and(|verdict| verdict.is_fault())))
}
