use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::{failed, misused};
use crate::cli::input::{GivenArgs, language, session};
use crate::cli::{console, network_trial};
use base::diagnostic::{Severity, Sources};
use compile::Plan;
use lang::{Checked, outline};
use world::env::Scenario;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify debug ast my.scn                   what was written
  falsify debug hir my.scn                   what is meant: names resolved, SI values, defaults filled in
  falsify debug plan my.scn                  what would be run, with every figure
  falsify debug hir --set 'far=20 m' my.scn  the same with another value";

/// Options of `falsify debug`.
#[derive(Debug, Args)]
pub struct DebugArgs {
    /// Which tree.
    #[arg(value_enum)]
    pub tree: Tree,
    /// A scenario file.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Replacements of parts of the file; maps affect only the plan.
    #[command(flatten)]
    pub given: GivenArgs,
}

/// The trees of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Tree {
    /// The syntax tree.
    Ast,
    /// The checked program: names resolved, SI values, defaults filled in.
    Hir,
    /// The plan of the run.
    Plan,
    /// No tree: a network on the standard input is loaded and run once, within limits. The program starts itself with this.
    #[value(hide = true)]
    Network,
}

/// `falsify debug`
pub fn debug(options: &DebugArgs) -> Ended {
    let input = options.given.input(std::slice::from_ref(&options.file));
    match options.tree {
        Tree::Plan => {}
        Tree::Network => return Ok(network_trial::carry_out()),
        tree => return show_tree(tree, &options.file, &input.settings),
    }
    let planned = session(options.given.allow_external).plan(&input).map_err(failed)?;
    console::say(show_plan(&planned.plan).trim_end());
    Ok(ExitCode::Done)
}

/// Shows the result of the front end for a file, up to the step that it reached.
fn show_tree(tree: Tree, file: &Path, settings: &[String]) -> Ended {
    let mut sources = Sources::default();
    let read = |path: &Path| base::files::text(path);
    let mut loaded = lang::load(&[file.to_path_buf()], &read, &mut sources).map_err(misused)?;
    let mut said = std::mem::take(&mut loaded.diagnostics);
    let (settings, wrong) = lang::settings(settings, &mut sources);
    said.extend(wrong);
    said.extend(lang::apply(&settings, &mut loaded));
    if let Tree::Ast = tree {
        let roots = loaded.files.iter().filter(|file| loaded.roots.contains(&file.source));
        roots.for_each(|root| console::say(outline(root).trim_end()));
    } else {
        let catalog = language();
        // A matrix belongs to the files, not to the program of one of its combinations.
        said.extend(lang::matrices(&mut loaded, &catalog.forms, &settings, &sources).1);
        let (program, more) = lang::check(&loaded, &sources, &catalog.forms, &mut Checked::new(&catalog.vocabulary));
        said.extend(more);
        console::say(outline(&program).trim_end());
    }
    console::show(&said, &sources);
    let wrong = said.iter().any(|each| each.severity == Severity::Error);
    Ok(if wrong { ExitCode::Scenario } else { ExitCode::Done })
}

fn show_plan(plan: &Plan) -> String {
    let mut text = String::new();
    for town in &plan.towns {
        text.push_str(&format!("town {}: {}\n", town.name, console::count(town.town.roads.len(), "road")));
    }
    for campaign in &plan.campaigns {
        text.push_str(&format!("campaign {}\n", campaign.name));
        for driver in &campaign.drivers {
            text.push_str(&format!("  driver {}: {}\n", driver.name, driver.kind));
            for (key, value) in driver.settings.iter() {
                text.push_str(&format!("    {key}: {value:?}\n"));
            }
            if let (Some(name), Some(model)) = (&driver.sensors, &driver.sensor_model) {
                text.push_str(&format!("    sensors {name}\n{}", indented(&outline(model))));
            }
        }
        for training in &campaign.trainings {
            let environments = console::count(training.environments, "environment");
            text.push_str(&format!("  training: {}, {environments}\n", training.key));
            training.scenarios().iter().for_each(|scenario| text.push_str(&show_scenario(scenario)));
            text.push_str(&indented(&outline(&training.config)));
        }
        for evaluation in &campaign.evaluations {
            let key = &evaluation.trained;
            text.push_str(&format!(
                "  evaluation: {} ({}, {}, {}, run {}) in {} against {} with {}, {}\n",
                evaluation.controller.name(),
                key.reward,
                key.town,
                key.policy,
                key.run,
                evaluation.town,
                evaluation.policy,
                evaluation.vehicle,
                console::count(evaluation.episodes as usize, "episode")
            ));
            text.push_str(&show_scenario(&evaluation.scenario));
        }
    }
    text
}

fn show_scenario(scenario: &Scenario) -> String {
    let parts = [
        outline(&scenario.cast.ego.blueprint),
        outline(&scenario.cast.pedestrian),
        outline(&scenario.spawn),
        outline(&scenario.reward),
        outline(&scenario.episode),
    ];
    indented(&parts.concat())
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}
