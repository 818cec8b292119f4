use std::path::Path;

use super::args::{DebugOptions, Tree};
use super::{ExitCode, front};
use crate::compile::{Catalog, Plan};
use crate::diagnostic::{Severity, Sources};
use crate::env::Scenario;
use crate::lang::{self, Checked, outline};

/// `falsify debug`
pub fn debug(options: &DebugOptions) -> ExitCode {
    match options.tree {
        Tree::Plan => match front::compile_files(std::slice::from_ref(&options.file), &options.given) {
            Ok((plan, _)) => {
                front::say(show_plan(&plan).trim_end());
                ExitCode::Done
            }
            Err(code) => code,
        },
        tree => show_tree(tree, &options.file, &options.given.set),
    }
}

/// Shows what the front end made of a file, as far as it came.
fn show_tree(tree: Tree, file: &Path, settings: &[String]) -> ExitCode {
    let mut sources = Sources::default();
    let read = |path: &Path| std::fs::read_to_string(path);
    let mut loaded = match lang::load(&[file.to_path_buf()], &read, &mut sources) {
        Ok(loaded) => loaded,
        Err(error) => {
            front::fail(&error.to_string());
            return ExitCode::Usage;
        }
    };
    let mut said = std::mem::take(&mut loaded.diagnostics);
    let (settings, wrong) = lang::settings(settings, &mut sources);
    said.extend(wrong);
    said.extend(lang::apply(&settings, &mut loaded));
    if let Tree::Ast = tree {
        let roots = loaded.files.iter().filter(|file| loaded.roots.contains(&file.source));
        roots.for_each(|root| front::say(outline(root).trim_end()));
    } else {
        let catalog = Catalog::builtin();
        // A matrix belongs to the files, not to the program that one of its combinations makes.
        said.extend(lang::matrices(&mut loaded, &catalog.forms, &settings, &sources).1);
        let (program, more) = lang::check(&loaded, &sources, &catalog.forms, &mut Checked::new(&catalog.vocabulary));
        said.extend(more);
        front::say(outline(&program).trim_end());
    }
    front::show(&said, &sources);
    if said.iter().any(|each| each.severity == Severity::Error) { ExitCode::Scenario } else { ExitCode::Done }
}

fn show_plan(plan: &Plan) -> String {
    let mut text = String::new();
    for town in &plan.towns {
        text.push_str(&format!("town {}: {}\n", town.name, front::count(town.town.roads.len(), "road")));
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
            let key = &training.key;
            let environments = front::count(training.environments, "environment");
            text.push_str(&format!(
                "  training: {} in {} against {}, run {}, {environments}\n",
                key.reward, key.town, key.policy, key.run
            ));
            text.push_str(&show_scenario(&training.scenario));
            text.push_str(&indented(&outline(&training.config)));
        }
        for evaluation in &campaign.evaluations {
            let key = &evaluation.trained;
            text.push_str(&format!(
                "  evaluation: {} ({}, {}, {}, run {}) in {} against {} with {}, {}\n",
                evaluation.pedestrian.name(),
                key.reward,
                key.town,
                key.policy,
                key.run,
                evaluation.town,
                evaluation.policy,
                evaluation.vehicle,
                front::count(evaluation.episodes as usize, "episode")
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
