use std::collections::BTreeMap;

use super::super::town::Scenery;
use super::Replay;
use crate::jobs::Repeated;
use crate::report::{CastFailure, DistinctFailure, PlayedFailure};
use verdict::cause::needed;

/// The failures that can be played on a page.
#[derive(Debug, Default)]
pub struct Players {
    all: BTreeMap<String, Replay>,
    /// The options of `falsify replay`, with a blank after each; `None` if the report has nothing that it reads.
    options: Option<&'static str>,
}

impl Players {
    /// Converts these failures to the player's format, with the causes of the distinct ones and the actors that those of a cast need. The options
    /// are those that `falsify replay` needs.
    pub fn new(
        played: &[PlayedFailure<'_>],
        distinct: &[DistinctFailure],
        cast: &[CastFailure],
        options: Option<&'static str>,
    ) -> Self {
        let mut scenery: BTreeMap<&str, Scenery> = BTreeMap::new();
        let mut all = BTreeMap::new();
        let cause = |name: &str| distinct.iter().find(|each| each.failure.name() == name)?.cause.as_ref();
        for (name, town, Repeated { scenario, trace, judged, .. }) in played {
            let scenery = scenery.entry(town).or_insert_with(|| Scenery::new(&scenario.town));
            let mut replay = Replay::new(scenario, scenery, trace, judged);
            if let Some(cause) = cause(name) {
                replay.short = format!("{} {}", cause.sentence(), replay.short);
            }
            if let Some(each) = cast.iter().find(|each| each.failure.name() == *name) {
                replay.short = format!("{} {}", replay.short, needed(&each.needs));
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
