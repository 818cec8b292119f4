use std::collections::BTreeMap;

use super::super::town::Scenery;
use super::Replay;
use crate::jobs::Repeated;
use crate::parallel;
use crate::report::PlayedFailure;
use world::cause::explain;

/// Maximum number of failures whose cause is found.
const MAX_EXPLAINED: usize = 8;

/// The failures that can be played on a page.
#[derive(Debug, Default)]
pub struct Players {
    all: BTreeMap<String, Replay>,
    /// The options of `falsify replay`, with a blank after each; `None` if the report has nothing that it reads.
    options: Option<&'static str>,
}

impl Players {
    /// Converts these failures to the player's format. The options are those that `falsify replay` needs.
    pub fn new(played: &[PlayedFailure<'_>], options: Option<&'static str>) -> Self {
        let mut scenery: BTreeMap<&str, Scenery> = BTreeMap::new();
        let mut all = BTreeMap::new();
        let cause = |(.., repeated): &PlayedFailure<'_>| Some(explain(&repeated.incident()?, false)?.sentence());
        let mut causes = parallel::map(&played[..played.len().min(MAX_EXPLAINED)], cause).into_iter();
        for (name, town, Repeated { scenario, trace, judged, .. }) in played {
            let scenery = scenery.entry(town).or_insert_with(|| Scenery::new(&scenario.town));
            let mut replay = Replay::new(scenario, scenery, trace, judged);
            if let Some(cause) = causes.next().flatten() {
                replay.short = format!("{cause} {}", replay.short);
            }
            all.insert(name.clone(), replay);
        }
        Self { all, options }
    }

    /// The options that `falsify replay` needs, with a blank after each; `None` if it cannot read the report.
    pub const fn options(&self) -> Option<&'static str> {
        self.options
    }

    /// The player of a failure; `None` if it was not repeated.
    pub fn get(&self, name: &str) -> Option<&Replay> {
        self.all.get(name)
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &Replay)> {
        self.all.iter()
    }

    /// The `id` of a failure's player on the page.
    pub fn id(name: &str) -> String {
        format!("play-{}", name.replace(':', "-"))
    }

    /// The link to the player of a failure; `None` if it was not repeated.
    pub fn link(&self, name: &str) -> Option<String> {
        self.all.contains_key(name).then(|| format!("#{}", Self::id(name)))
    }
}
