mod avoidable;
mod searches;

use std::collections::BTreeSet;
use std::fmt::Write;

use avoidable::avoidable;
pub use searches::{average, median, search_summary, search_table, who};

use super::super::{Cell, Evidence, Manifest, Spread, evidence};
use crate::compile::{Campaign, Driver};

/// What the simulator leaves out, for every summary.
pub const LEFT_OUT: &str = "\
The simulator is flat and has one car and one pedestrian: no other traffic, no kerbs, no weather, and parked cars and trees \
only where the scenario puts them. The car is a kinematic bicycle whose pedals are fitted to figures that others printed from \
CARLA, and its driver knows without error and at once whatever it looks at, unless the scenario gives it sensors. The pedestrian is a disc. Maps from OpenDRIVE hold \
no buildings unless the scenario adds them.";

/// The page to read first: tables of cells and of what they show, further sections, how it was made, and what it does not say.
pub fn summary(
    campaign: &Campaign,
    cells: &[Cell],
    evidence: &Evidence,
    manifest: &Manifest,
    sections: &str,
) -> String {
    let mut page = format!("# {}\n\n", campaign.name);
    for line in &campaign.docs {
        let _ = writeln!(page, "{line}");
    }
    if !campaign.docs.is_empty() {
        page.push('\n');
    }
    if manifest.smoke {
        page.push_str("**A smoke run: it shows that everything works, and its numbers mean nothing.**\n\n");
    }
    if !manifest.complete {
        page.push_str("**Incomplete: it was stopped, something failed or reached its limit, or a reward was no number. The manifest says which.**\n\n");
    }
    if !cells.is_empty() {
        episodes(&mut page, cells);
        page.push_str(&evidence::page(cells, evidence));
    }
    page.push_str(sections);
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

/// What the scenario says of the things that are named above.
fn words(campaign: &Campaign) -> String {
    let mut text = String::new();
    if campaign.words.is_empty() {
        return text;
    }
    text.push_str("## What is what\n\n");
    for word in &campaign.words {
        let _ = writeln!(text, "- {} **{}**: {}", word.form, word.name, word.docs);
    }
    text.push('\n');
    text
}

/// The table of cells, and how it is to be read.
fn episodes(page: &mut String, cells: &[Cell]) {
    page.push_str(
        "| pedestrian | reward | trained in, against | town | policy | runs × episodes | collision rate | 95 % of episodes \
         | front of collisions | moving | reward | length | impact speed |\n",
    );
    page.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for cell in cells {
        let trained = training(cell);
        let _ = writeln!(
            page,
            "| {} | {} | {trained} | {} | {} | {} × {} | {} | {:.2}..{:.2} | {} | {} | {} | {} s | {} m/s |",
            cell.key.controller,
            cell.key.reward,
            place(cell, cells),
            cell.key.policy,
            cell.runs,
            cell.episodes / cell.runs.max(1),
            spread(cell.collision),
            cell.interval.0,
            cell.interval.1,
            spread(cell.front),
            spread(cell.moving),
            spread(cell.reward_sum),
            spread(cell.length),
            spread(cell.impact_speed),
        );
    }
    page.push_str(
        "\n\"±\" is the standard deviation over runs, each a training of its own (`random`: other draws). \
         The interval is Wilson's over the episodes of all runs, which share their beginnings; it says nothing about further \
         trainings. Front: share \
         of collisions within the front sector. Moving: share of episodes that end in a collision with a moving car. All \
         pedestrians of a town and policy meet the same beginnings (in one `evaluate` block).\n",
    );
    errors(page, cells);
    page.push_str(&avoidable(cells));
}

/// What the drivers are, and which of them are surrogates.
fn drivers(drivers: &[Driver]) -> String {
    let mut text = String::from("\n## Who drives\n\n");
    for driver in drivers {
        let sensors = match &driver.sensors {
            Some(name) => format!("behind the sensors `{name}`"),
            None => "without sensors: exact and at once".into(),
        };
        let surrogate = if driver.surrogate.is_empty() { "" } else { ". **A surrogate**" };
        let _ = writeln!(text, "- `{}` (`{}`), {sensors}{surrogate}", driver.name, driver.kind);
    }
    let mut said = BTreeSet::new();
    for driver in drivers.iter().filter(|driver| !driver.surrogate.is_empty()) {
        if said.is_empty() {
            text.push_str("\n### What is a surrogate\n\n");
        }
        if said.insert(driver.kind) {
            let _ = writeln!(text, "- `{}`: {}", driver.kind, driver.surrogate);
        }
    }
    text
}

/// Says in how many episodes a driver failed as a program, if any.
fn errors(page: &mut String, cells: &[Cell]) {
    let failed: u32 = cells.iter().map(|cell| cell.errors).sum();
    if failed == 0 {
        return;
    }
    let _ = writeln!(
        page,
        "\n**In {failed} more episodes the driver failed as a program, or they were not tried. They count neither as passed nor as failed and enter no \
         number above;** `episodes.csv` holds the cause of each in the column `error`:\n"
    );
    for cell in cells.iter().filter(|cell| cell.errors > 0) {
        let (errors, all) = (cell.errors, cell.episodes + cell.errors);
        let _ = writeln!(
            page,
            "- {} in {} against {}: {errors} of {all}",
            cell.key.controller,
            place(cell, cells),
            cell.key.policy
        );
    }
}

/// What the pedestrian of a cell was trained in and against.
pub fn training(cell: &Cell) -> String {
    if cell.key.is_trained() {
        format!("{}, {}", cell.key.train_town, cell.key.train_policy)
    } else {
        "–".to_string()
    }
}

/// The town of a cell, with whatever else differs between the cells: vehicle, adversary, `evaluate` block.
pub fn place(cell: &Cell, cells: &[Cell]) -> String {
    let mut text = cell.key.town.clone();
    if cells.iter().any(|other| other.key.vehicle != cell.key.vehicle) {
        let _ = write!(text, ", {}", cell.key.vehicle);
    }
    if cells.iter().any(|other| other.key.adversary != cell.key.adversary) {
        let _ = write!(text, ", {}", cell.key.adversary);
    }
    if cells.iter().any(|other| other.key.block != cell.key.block) {
        let _ = write!(text, " #{}", cell.key.block);
    }
    text
}

/// A mean with its spread, to two digits.
pub fn spread(value: Spread) -> String {
    match (value.mean, value.sd) {
        (None, _) => "–".into(),
        (Some(mean), None) => short(mean),
        (Some(mean), Some(sd)) => format!("{} ± {}", short(mean), short(sd)),
    }
}

fn short(number: f64) -> String {
    if number.abs() < 1e5 { format!("{number:.2}") } else { format!("{number:.2e}") }
}

/// Runs × episodes, and the episodes in error if there are any.
fn number(cell: &Cell) -> String {
    let number = format!("{} × {}", cell.runs, cell.episodes / cell.runs.max(1));
    if cell.errors > 0 { format!("{number}, {} errors", cell.errors) } else { number }
}

/// The cells as text for a terminal.
pub fn table(name: &str, cells: &[Cell]) -> String {
    let head = ["pedestrian", "town", "policy", "collision", "front", "moving", "reward", "n"];
    let mut rows: Vec<[String; 8]> = vec![head.map(String::from)];
    for cell in cells {
        let who = match cell.key.train_town.as_str() {
            "" => format!("{} ({})", cell.key.controller, cell.key.reward),
            town => format!("{} {} ({town}, {})", cell.key.controller, cell.key.reward, cell.key.train_policy),
        };
        rows.push([
            who,
            place(cell, cells),
            cell.key.policy.clone(),
            spread(cell.collision),
            spread(cell.front),
            spread(cell.moving),
            spread(cell.reward_sum),
            number(cell),
        ]);
    }
    let widths: Vec<usize> =
        (0..head.len()).map(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0)).collect();
    let mut text = format!("campaign {name}\n");
    if cells.is_empty() {
        return text;
    }
    for row in &rows {
        let line: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "  {}", line.join("  ").trim_end());
    }
    text
}
