use std::collections::BTreeSet;

use maud::{Markup, html};

use super::markup::prose;
use crate::report::render::summary::LEFT_OUT;
use crate::report::render::table::{Selection, Value};
use crate::report::{Manifest, ScenarioFile};
use compile::Campaign;

/// The drivers, the names of the scenario, and the limits of the simulator.
pub fn meaning(campaign: &Campaign) -> Markup {
    let documented = |name: &str| campaign.words.iter().find(|word| word.form == "driver" && word.name == name);
    let known = |name: &str| campaign.drivers.iter().any(|driver| driver.name == name);
    let mut seen = BTreeSet::new();
    let surrogates = campaign.drivers.iter().filter(|driver| !driver.surrogate.is_empty() && seen.insert(driver.kind));
    let surrogates: Vec<_> = surrogates.collect();
    html! {
        dl.words {
            @for driver in &campaign.drivers {
                dt { (driver.name) }
                dd {
                    @if let Some(word) = documented(&driver.name) { (prose(&word.docs)) " " }
                    "Driver of kind " code { (driver.kind) } ", "
                    @match &driver.sensors {
                        Some(name) => { "with the sensors " code { (name) } "." },
                        None => "without sensors: it perceives exactly and without delay.",
                    }
                    @if !driver.surrogate.is_empty() { " " b.warn { "A surrogate." } }
                }
            }
            @for word in campaign.words.iter().filter(|word| word.form != "driver" || !known(&word.name)) {
                dt { (word.name) }
                dd { i { (word.form) "." } " " (prose(&word.docs)) }
            }
        }
        @for driver in surrogates {
            p { b { "Surrogate " code { (driver.kind) } "." } " " (prose(driver.surrogate)) }
        }
        h3 { "What the simulator leaves out" }
        p { (prose(LEFT_OUT)) }
    }
}

/// The files of the report, and the command that makes it again.
pub fn data(manifest: &Manifest, files: &[String]) -> Markup {
    let there = WHAT.iter().filter(|(name, _)| files.iter().any(|file| file == name));
    let known = |file: &str| WHAT.iter().any(|(name, _)| *name == file);
    let others = files.iter().filter(|file| !known(file) && [".csv", ".svg"].iter().any(|end| file.ends_with(end)));
    let read = Selection::new()
        .text("file", |file: &ScenarioFile| file.path.clone())
        .text("BLAKE3", |file| Value::code(file.blake3.chars().take(16).collect::<String>() + "…"))
        .table(&manifest.files);
    html! {
        ul.files {
            @for (name, what) in there { li { a href=(name) { (name) } " " (what) } }
            @for file in others { li { a href=(file) { (file) } } }
        }
        h3 { "Reproduce this report" }
        pre { code { (manifest.command()) } }
        p {
            "falsify " (manifest.version) ", vector instructions " (manifest.vector_instructions)
            ". The manifest has the times. The same files, seed and version give the same numbers."
        }
        details {
            summary { "Files read" }
            (read.to_html())
        }
    }
}

/// The files of a report that may interest a reader.
const WHAT: [(&str, &str); 8] = [
    ("summary.md", "the tables of this page as text"),
    ("results.csv", "one row for each pedestrian, town and driver; open it first"),
    ("metrics.csv", "all metrics of these, one a row"),
    ("episodes.csv", "one row for each episode"),
    ("episodes.parquet", "the same, smaller"),
    ("comparisons.csv", "paired comparisons"),
    ("learning_curve.csv", "one row for each update of each training"),
    ("manifest.toml", "version, seed, files and times"),
];
