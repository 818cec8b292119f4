use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::exit_code::ExitCode;
use super::input::session;
use super::{console, failure};
use crate::lang::reason;
use crate::report;
use crate::road::{LaneKind, Town, opendrive};
use crate::session::{CheckOptions, Error, Input};

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify map Town02.xodr                    Town02.svg and Town02.html, and what the map holds
  falsify map my.scn --out maps              every town of a scenario, imported ones, too";

/// Options of `falsify map`.
#[derive(Debug, Args)]
pub struct MapOptions {
    /// An OpenDRIVE map, or a scenario file with towns.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Folder for the picture, `NAME.svg`, and the page with places to copy, `NAME.html`.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// Also write the waypoints of all driving lanes at this distance (m), as CARLA would: `NAME_waypoints.csv`.
    #[arg(long, value_name = "METRES", value_parser = spacing)]
    pub waypoints: Option<f64>,
}

fn spacing(text: &str) -> Result<f64, String> {
    let spacing: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.01..=1000.0).contains(&spacing) { Ok(spacing) } else { Err("must be from 0.01 to 1000".into()) }
}

/// `falsify map`
pub fn map(options: &MapOptions) -> ExitCode {
    let is_scenario = options.file.extension().is_some_and(|extension| extension == "scn");
    let towns =
        if is_scenario { declared(&options.file) } else { read(&options.file).map(|town| vec![Arc::new(town)]) };
    let towns = match towns {
        Ok(towns) => towns,
        Err(code) => return code,
    };
    if towns.is_empty() {
        console::fail("the file holds no town");
        return ExitCode::Nothing;
    }
    for town in &towns {
        describe(town);
        if let Err(error) = write(town, options) {
            console::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    }
    ExitCode::Done
}

/// The towns of a scenario file, and of the files that it imports.
fn declared(file: &Path) -> Result<Vec<Arc<Town>>, ExitCode> {
    // Drawing starts no program, so the file may name any program.
    let options = CheckOptions { input: Input::file(file), imported_towns: true };
    let checked = session(true).check(&options).map_err(|error| failure::failed(&error))?;
    // A town in which no pedestrian can be placed is drawn too: the map may show why.
    if checked.compiled.unplaced.is_none() {
        console::show(&checked.compiled.diagnostics, &checked.sources);
        checked.plan().map_err(|error| match error {
            Error::Scenario { .. } => {
                console::fail(&format!("{error}; nothing was drawn"));
                ExitCode::Scenario
            }
            other => failure::failed(&other),
        })?;
    }
    let plan = checked.compiled.plan.or(checked.compiled.unplaced);
    Ok(plan.into_iter().flat_map(|plan| plan.towns).map(|named| named.town).collect())
}

fn read(file: &Path) -> Result<Town, ExitCode> {
    let text = crate::files::text(file).map_err(|error| {
        console::fail(&format!("cannot read `{}`: {}", file.display(), reason(&error)));
        ExitCode::Usage
    })?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    opendrive::read(&text, &name).map(Town::new).map_err(|error| {
        console::fail(&format!("cannot use the map `{}`: {error}", file.display()));
        ExitCode::Scenario
    })
}

/// Reports what a town holds and what was skipped of its file.
fn describe(town: &Town) {
    let (low, high) = town.bounds();
    let kilometres = |kind: LaneKind| {
        let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| {
            let length = section.end - section.start;
            section.lanes.iter().filter(move |lane| lane.id != 0 && lane.kind == kind).map(move |_| length)
        });
        // The sum of no numbers is -0.0.
        lanes.sum::<f64>() / 1000.0 + 0.0
    };
    let inside = town.roads.iter().filter(|road| road.junction.is_some()).count();
    console::say(&format!("town {}", town.name));
    console::say(&format!("  extent          {:.0} m × {:.0} m", high.x - low.x, high.y - low.y));
    let junctions = console::count(town.junctions.len(), "junction");
    console::say(&format!("  roads           {} ({inside} inside {junctions})", town.roads.len()));
    console::say(&format!("  driving lanes   {:.2} km", kilometres(LaneKind::Driving)));
    console::say(&format!("  sidewalks       {:.2} km", kilometres(LaneKind::Sidewalk)));
    console::say(&format!("  traffic lights  {}", town.traffic_lights.len()));
    console::say(&format!("  speed signs     {}", town.speed_signs.len()));
    console::say(&format!("  crosswalks      {}", town.crosswalks.len()));
    console::say(&format!("  obstacles       {}", town.obstacles.len()));
    console::say(&format!("  warnings        {}", town.warnings.len()));
    for warning in &town.warnings {
        console::say(&format!("    {warning}"));
    }
}

fn write(town: &Town, options: &MapOptions) -> Result<(), report::WriteError> {
    let picture = options.out.join(format!("{}.svg", town.name));
    report::write_file(&picture, report::labelled_map(town).as_bytes())?;
    console::say(&format!("  {}", picture.display()));
    let page = options.out.join(format!("{}.html", town.name));
    report::write_file(&page, report::map_page(&page_of(town)).as_bytes())?;
    console::say(&format!("  {}", page.display()));
    if let Some(spacing) = options.waypoints {
        let table = options.out.join(format!("{}_waypoints.csv", town.name));
        report::write_csv(&table, &report::waypoints(town, spacing))?;
        console::say(&format!("  {}", table.display()));
    }
    Ok(())
}

/// The page of a town.
fn page_of(town: &Town) -> report::MapPage<'_> {
    let (low, high) = town.bounds();
    let note =
        format!("{}, {:.0} m × {:.0} m", console::count(town.roads.len(), "road"), high.x - low.x, high.y - low.y);
    report::MapPage {
        title: town.name.clone(),
        kind: "map",
        note,
        problems: Vec::new(),
        towns: vec![report::TownView { town, starts: Vec::new() }],
        follows: None,
    }
}
