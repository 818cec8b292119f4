use std::sync::Arc;

use super::{Incident, Rerun, Reruns};
use crate::Blame;
use episode::Scenario;
use world::sim::ActorId;

/// An actor beside the car under test, and whether a failure needs it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Need {
    pub actor: ActorId,
    /// The name of its role.
    pub name: Arc<str>,
    /// Whether the failure does not happen without it.
    pub is_needed: bool,
}

/// Which actors a failure needs. It is run again from the same draws without each of them in turn. All others start where they did; those with a
/// controller or a driver of their own do what it chooses then, and the others carry out the recorded commands. A fault that is a failure
/// without being a fault any more has ended.
///
/// Empty for one car and one pedestrian, for a failure that cannot be repeated, and where a program fails.
pub fn needs(incident: &Incident) -> Vec<Need> {
    let incident = &incident.lasting();
    let Incident { scenario, criterion, commands, .. } = incident;
    let cast = &scenario.cast;
    let others: Vec<ActorId> =
        cast.actors().filter(|actor| *actor != ActorId::EGO && !cast.is_absent(*actor)).collect();
    let recorded = Reruns::new(incident).run(commands).filter(|_| others.len() > 1);
    let Some(recorded) = recorded.map(|rerun| rerun.judged(*criterion, scenario)) else { return Vec::new() };
    let blame = if recorded.is(*criterion, Blame::Fault) { Blame::Fault } else { Blame::Any };
    let without = |actor: ActorId| {
        let scenario = Arc::new(Scenario { cast: cast.without(actor), ..Scenario::clone(scenario) });
        let rerun = Reruns::with(incident, scenario.clone()).run(commands);
        // A program that fails says nothing.
        let rerun = rerun.filter(|rerun| rerun.outcome.fault().is_none());
        let is = |rerun: Rerun| rerun.outcome.counts() && rerun.judged(*criterion, &scenario).is(*criterion, blame);
        rerun.map(|rerun| Need { actor, name: cast.name(actor).clone(), is_needed: !is(rerun) })
    };
    others.into_iter().map(without).collect::<Option<_>>().unwrap_or_default()
}

/// Which actors a failure needs, as a sentence.
pub fn needed(needs: &[Need]) -> String {
    match needed_names(needs) {
        names if names.is_empty() => {
            "It needs none of the other actors: without any one of them it happens as well.".into()
        }
        names => format!("It needs {names}: without any one of them it does not happen."),
    }
}

/// The roles of the actors that a failure needs, each once, as "`child`, `van`"; empty if it needs none.
pub fn needed_names(needs: &[Need]) -> String {
    let mut names: Vec<String> = Vec::new();
    for need in needs.iter().filter(|need| need.is_needed) {
        let name = format!("`{}`", need.name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(", ")
}
