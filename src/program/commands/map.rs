use std::path::Path;

use super::preview::PreviewArgs;
use crate::cli::console;
use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::{misused, unwritten};
use lang::reason;
use results::report;
use world::road::{AssumedLimit, GiveWay, LaneKind, Town, opendrive};

/// The distance between two waypoints (m).
///
/// # Errors
/// A text that is no number, or one that is out of bounds.
pub fn spacing(text: &str) -> Result<f64, String> {
    let spacing: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.01..=1000.0).contains(&spacing) { Ok(spacing) } else { Err("must be from 0.01 to 1000".into()) }
}

/// `falsify preview` of an OpenDRIVE map: its picture, its page, and what it holds.
pub fn map(options: &PreviewArgs) -> Ended {
    let town = read(&options.file)?;
    describe(&town);
    write(&town, options).map_err(unwritten)?;
    Ok(ExitCode::Done)
}

fn read(file: &Path) -> Result<Town, ExitCode> {
    let text = base::files::text(file);
    let text = text.map_err(|error| misused(format!("cannot read `{}`: {}", file.display(), reason(&error))))?;
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
    console::say(&format!("  speed limits    {}", limits(town)));
    console::say(&format!("  speed signs     {}", town.speed_signs.len()));
    let signs = |kind| town.give_way_signs.iter().filter(|sign| sign.kind == kind).count();
    console::say(&format!("  stop signs      {}", signs(GiveWay::Stop)));
    console::say(&format!("  yield signs     {}", signs(GiveWay::Yield)));
    console::say(&format!("  crosswalks      {}", town.crosswalks.len()));
    console::say(&format!("  obstacles       {}", town.obstacles.len()));
    console::say(&format!("  warnings        {}", town.warnings.len()));
    for warning in &town.warnings {
        console::say(&format!("    {warning}"));
    }
}

/// The limits that the map gives its driving lanes.
fn limits(town: &Town) -> String {
    let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| &section.lanes);
    let driving = lanes.filter(|lane| lane.kind == LaneKind::Driving);
    let known = driving.flat_map(|lane| &lane.limits).filter_map(|(_, limit)| limit.map(|limit| limit * 3.6));
    let (least, most) =
        known.fold((f64::INFINITY, 0.0_f64), |(least, most), limit| (least.min(limit), most.max(limit)));
    let known = match (most - least).abs() {
        _ if most == 0.0 && !town.speed_signs.is_empty() => "those of the signs, 30 km/h before the first".to_owned(),
        _ if most == 0.0 => String::new(),
        apart if apart < 0.5 => format!("{most:.0} km/h"),
        _ => format!("{least:.0} to {most:.0} km/h"),
    };
    let assumed = AssumedLimit::of(&town.roads, &town.speed_signs).map(|assumed| assumed.to_string());
    [known, assumed.unwrap_or_default()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
}

fn write(town: &Town, options: &PreviewArgs) -> Result<(), report::WriteError> {
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
