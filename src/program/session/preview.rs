use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, value_parser};

use super::{Checked, Error, Input, SampledStarts, Session, sampled_starts};
use base::diagnostic::{Colour, render};
use compile::Plan;
use results::report::{MapPage, StartLayer, TownView, map_page};
use world::road::Town;

/// The most layers of starts in a town.
const LAYERS: usize = 12;
/// The most problems that a page shows.
const PROBLEMS: usize = 50;

/// Options of [`Session::preview`].
#[derive(Debug, Clone, Default, Args)]
pub struct PreviewOptions {
    /// The files.
    #[arg(skip)]
    pub input: Input,
    /// The number of starts that are drawn of every spawn in every town.
    #[arg(long, default_value_t = 300, value_name = "N", value_parser = value_parser!(u32).range(1..=100_000))]
    pub sample: u32,
    /// Seed of the starts.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
}

/// The towns of scenario files with starts of episodes, and what is wrong with the files.
#[derive(Debug, Clone, Default)]
pub struct Preview {
    /// The diagnostics as they are drawn under their lines, without colour.
    pub problems: Vec<String>,
    /// The number of diagnostics that are errors, and of files that cannot be read.
    pub errors: usize,
    /// The files that were read, or that could not be read.
    pub files: Vec<PathBuf>,
    /// Whether the files have errors and the towns are those of an earlier preview.
    pub outdated: bool,
    plan: Option<Plan>,
    starts: Vec<(String, SampledStarts)>,
}

impl Session {
    /// Checks scenario files and draws starts of their campaigns. Files with errors keep the towns of the preview before.
    pub fn preview(&self, options: &PreviewOptions, before: &Preview) -> Preview {
        let kept = |problems, errors, files| {
            let outdated = before.plan.is_some();
            Preview { problems, errors, files, outdated, ..before.clone() }
        };
        let checked = match self.check(&options.input) {
            Ok(checked) => checked,
            Err(Error::Unreadable { files }) => {
                let problems: Vec<String> = files.iter().map(|file| format!("error: {file}")).collect();
                return kept(problems, files.len(), options.input.files.clone());
            }
            Err(other) => return kept(vec![format!("error: {other}")], 1, options.input.files.clone()),
        };
        let files = checked.records.iter().map(|record| PathBuf::from(&record.path)).collect();
        let errors = checked.errors();
        let Checked { compiled, sources, .. } = checked;
        let shown = compiled.diagnostics.iter().take(PROBLEMS).map(|each| render(each, &sources, Colour::Never));
        let more = compiled.diagnostics.len().saturating_sub(PROBLEMS);
        let problems = shown.chain((more > 0).then(|| format!("… and {more} more"))).collect();
        // Spawns that cannot be satisfied are drawn too: the map may show why.
        let Some(plan) = compiled.plan.or(compiled.unplaced) else { return kept(problems, errors, files) };
        let mut starts: Vec<(String, SampledStarts)> = Vec::new();
        for campaign in &plan.campaigns {
            for sampled in sampled_starts(campaign, options.sample, options.seed) {
                let same = |(_, other): &(String, SampledStarts)| {
                    other.town == sampled.town && other.scenario.spawn == sampled.scenario.spawn
                };
                // The variants of a matrix often share their starts.
                if !starts.iter().any(same) {
                    starts.push((format!("{}, spawn {}", campaign.name, sampled.scenario.spawn.name), sampled));
                }
            }
        }
        Preview { problems, errors, files, outdated: false, plan: Some(plan), starts }
    }
}

impl Preview {
    /// The page with this title. A page that `follows` a script (its file name, and the version of this page) loads itself again when
    /// the script names another version.
    pub fn page(&self, title: &str, follows: Option<(String, String)>) -> String {
        let mut towns: Vec<(&str, &Arc<Town>)> = Vec::new();
        if let Some(plan) = &self.plan {
            let used = plan.campaigns.iter().flat_map(|campaign| &campaign.towns);
            for town in plan.towns.iter().chain(used) {
                if towns.iter().all(|(name, _)| *name != town.name) {
                    towns.push((&town.name, &town.town));
                }
            }
        }
        let layers = |town: &str| {
            let here = self.starts.iter().filter(|(_, sampled)| sampled.town == town).take(LAYERS);
            here.map(|(name, sampled)| StartLayer { name: name.clone(), survey: &sampled.survey }).collect()
        };
        let views = towns.iter().map(|(name, town)| TownView { town, starts: layers(name) });
        map_page(&MapPage {
            title: title.to_string(),
            kind: "preview",
            note: self.note(towns.len()),
            problems: self.problems.clone(),
            towns: views.collect(),
            follows,
        })
    }

    fn note(&self, towns: usize) -> String {
        let number = |count: usize, thing: &str| format!("{count} {thing}{}", if count == 1 { "" } else { "s" });
        let errors = if self.errors == 0 { "no errors".to_string() } else { number(self.errors, "error") };
        let towns = if towns == 0 { "no town to show".to_string() } else { number(towns, "town") };
        let outdated = if self.outdated { "; the maps are those of the last version that could be drawn" } else { "" };
        format!("{errors}, {towns}{outdated}")
    }
}
