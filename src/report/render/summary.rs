use std::collections::BTreeSet;
use std::fmt::Write;

use super::sections::{conclusions, errors, results};
use super::table::Section;
use crate::compile::{Campaign, Driver};
use crate::report::{Cell, Evidence, Manifest};

/// The limits of the simulator, for every summary.
pub const LEFT_OUT: &str = "\
The simulator is flat and has one car and one pedestrian: no other traffic, no kerbs, no weather. There are parked cars and trees \
only where the scenario puts them. The car is a kinematic bicycle whose pedals are fitted to published figures of CARLA. Its driver \
perceives without error and without delay, unless the scenario gives it sensors. The pedestrian is a disc. Maps from OpenDRIVE have \
no buildings unless the scenario adds them.";

/// The text to read first: tables of cells and the conclusions from them, further sections, the origin of the report, and its limits.
pub fn summary(
    campaign: &Campaign,
    cells: &[Cell],
    evidence: &Evidence,
    manifest: &Manifest,
    sections: &[Section],
) -> String {
    let mut page = format!("# {}\n\n", campaign.name);
    for line in &campaign.docs {
        let _ = writeln!(page, "{line}");
    }
    if !campaign.docs.is_empty() {
        page.push('\n');
    }
    if manifest.smoke {
        let _ = writeln!(page, "**{SMOKE}**\n");
    }
    if !manifest.complete {
        let _ = writeln!(page, "**{INCOMPLETE}**\n");
    }
    if !cells.is_empty() {
        page.push_str(&results(cells).to_markdown());
        page.push_str(&errors(cells));
        conclusions(cells, evidence).iter().for_each(|section| page.push_str(&section.to_markdown()));
    }
    sections.iter().for_each(|section| page.push_str(&section.to_markdown()));
    page.push_str(&drivers(&campaign.drivers));
    let _ = write!(
        page,
        "\nSeed {}, falsify {}.\n\n{}## What the simulator leaves out\n\n{LEFT_OUT}\n",
        manifest.seed,
        manifest.version,
        words(campaign)
    );
    page
}

/// A notice for readers of a smoke run.
pub const SMOKE: &str = "A smoke run: it shows that everything works. Its numbers have no meaning.";
/// A notice for readers of an incomplete report.
pub const INCOMPLETE: &str = "Incomplete: the run was stopped, something failed or reached its limit, or a reward was not a number. \
The manifest says which.";

/// The scenario's documentation of the names above.
fn words(campaign: &Campaign) -> String {
    let mut text = String::new();
    if campaign.words.is_empty() {
        return text;
    }
    text.push_str("## Names of the scenario\n\n");
    for word in &campaign.words {
        let _ = writeln!(text, "- {} **{}**: {}", word.form, word.name, word.docs);
    }
    text.push('\n');
    text
}

/// The drivers, and which of them are surrogates.
fn drivers(drivers: &[Driver]) -> String {
    let mut text = String::from("\n## Driving policies\n\n");
    for driver in drivers {
        let sensors = match &driver.sensors {
            Some(name) => format!("with the sensors `{name}`"),
            None => "without sensors: it perceives exactly and without delay".into(),
        };
        let surrogate = if driver.surrogate.is_empty() { "" } else { ". **A surrogate**" };
        let _ = writeln!(text, "- `{}` (`{}`), {sensors}{surrogate}", driver.name, driver.kind);
    }
    let mut seen = BTreeSet::new();
    for driver in drivers.iter().filter(|driver| !driver.surrogate.is_empty()) {
        if seen.is_empty() {
            text.push_str("\n### Surrogates\n\n");
        }
        if seen.insert(driver.kind) {
            let _ = writeln!(text, "- `{}`: {}", driver.kind, driver.surrogate);
        }
    }
    text
}
