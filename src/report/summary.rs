use std::fmt::Write;

use super::{Cell, Manifest, Spread};

/// What the simulator leaves out, for every summary.
const LEFT_OUT: &str = "\
The simulator is flat and has one car and one pedestrian: no other traffic, no kerbs, no weather, and parked cars and trees \
only where the scenario puts them. The car is a kinematic bicycle whose pedals are fitted to figures that others printed from \
CARLA, and its driver knows without error and at once whatever it looks at. The pedestrian is a disc. Maps from OpenDRIVE hold \
no buildings unless the scenario adds them.";

/// The page to read first: one table of cells, how it was made, and what it does not say.
pub fn summary(name: &str, docs: &[String], cells: &[Cell], manifest: &Manifest) -> String {
    let mut page = format!("# {name}\n\n");
    for line in docs {
        let _ = writeln!(page, "{line}");
    }
    if !docs.is_empty() {
        page.push('\n');
    }
    if manifest.smoke {
        page.push_str("**A smoke run: it shows that everything works, and its numbers mean nothing.**\n\n");
    }
    if !manifest.complete {
        page.push_str("**Incomplete: it was stopped, a training failed, or a reward was no number. The manifest says which.**\n\n");
    }
    if !cells.is_empty() {
        episodes(&mut page, cells);
    }
    let _ = write!(
        page,
        "Seed {}, falsify {}.\n\n## What the simulator leaves out\n\n{LEFT_OUT}\n",
        manifest.seed, manifest.version
    );
    page
}

/// The table of cells, and how it is to be read.
fn episodes(page: &mut String, cells: &[Cell]) {
    page.push_str(
        "| pedestrian | reward | trained in, against | town | policy | runs × episodes | collision rate | 95 % of episodes \
         | front of collisions | moving | reward | length | impact speed |\n",
    );
    page.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for cell in cells {
        let trained = match &cell.trained {
            (town, _) if town.is_empty() => "–".to_string(),
            (town, policy) => format!("{town}, {policy}"),
        };
        let _ = writeln!(
            page,
            "| {} | {} | {trained} | {} | {} | {} × {} | {} | {:.2}..{:.2} | {} | {} | {} | {} s | {} m/s |",
            cell.pedestrian,
            cell.reward,
            place(cell, cells),
            cell.policy,
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
         pedestrians of a town and policy meet the same beginnings (in one `evaluate` block).\n\n",
    );
}

/// The town of a cell, with whatever else differs between the cells: vehicle, adversary, `evaluate` block.
fn place(cell: &Cell, cells: &[Cell]) -> String {
    let mut text = cell.town.clone();
    if cells.iter().any(|other| other.vehicle != cell.vehicle) {
        let _ = write!(text, ", {}", cell.vehicle);
    }
    if cells.iter().any(|other| other.adversary != cell.adversary) {
        let _ = write!(text, ", {}", cell.adversary);
    }
    if cells.iter().any(|other| other.block != cell.block) {
        let _ = write!(text, " #{}", cell.block);
    }
    text
}

/// A mean with its spread, to two digits.
pub(crate) fn spread(value: Spread) -> String {
    match (value.mean, value.sd) {
        (None, _) => "–".into(),
        (Some(mean), None) => short(mean),
        (Some(mean), Some(sd)) => format!("{} ± {}", short(mean), short(sd)),
    }
}

fn short(number: f64) -> String {
    if number.abs() < 1e5 { format!("{number:.2}") } else { format!("{number:.2e}") }
}

/// The cells as text for a terminal.
pub fn table(name: &str, cells: &[Cell]) -> String {
    let head = ["pedestrian", "town", "policy", "collision", "front", "moving", "reward", "n"];
    let mut rows: Vec<[String; 8]> = vec![head.map(String::from)];
    for cell in cells {
        let who = match cell.trained.0.as_str() {
            "" => format!("{} ({})", cell.pedestrian, cell.reward),
            town => format!("{} {} ({town}, {})", cell.pedestrian, cell.reward, cell.trained.1),
        };
        rows.push([
            who,
            place(cell, cells),
            cell.policy.clone(),
            spread(cell.collision),
            spread(cell.front),
            spread(cell.moving),
            spread(cell.reward_sum),
            format!("{} × {}", cell.runs, cell.episodes / cell.runs.max(1)),
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
