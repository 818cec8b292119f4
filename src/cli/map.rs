use std::path::Path;

use super::args::{GivenOptions, MapOptions};
use super::{ExitCode, front};
use crate::compile::Overrides;
use crate::lang::reason;
use crate::report;
use crate::road::{LaneKind, Town, opendrive};

/// `falsify map`
pub fn map(options: &MapOptions) -> ExitCode {
    let is_scenario = options.file.extension().is_some_and(|extension| extension == "scn");
    let towns = if is_scenario {
        // Drawing starts no program.
        let given = GivenOptions { allow_external: true, ..GivenOptions::default() };
        let overrides = Overrides { imported_towns: true, only_checked: true, ..Overrides::default() };
        let gathered = match front::gather(std::slice::from_ref(&options.file), &given, overrides) {
            Ok(gathered) => gathered,
            Err(code) => return code,
        };
        // Where nobody can be placed, one wants to see the town all the more.
        if gathered.compiled.unplaced.is_none()
            && let Err(code) = front::tell(&gathered, &given, "nothing was drawn")
        {
            return code;
        }
        let plan = gathered.compiled.plan.or(gathered.compiled.unplaced);
        plan.into_iter().flat_map(|plan| plan.towns).map(|named| named.town).collect()
    } else {
        match read(&options.file) {
            Ok(town) => vec![std::sync::Arc::new(town)],
            Err(code) => return code,
        }
    };
    if towns.is_empty() {
        front::fail("the file holds no town");
        return ExitCode::Nothing;
    }
    for town in &towns {
        describe(town);
        if let Err(error) = write(town, options) {
            front::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    }
    ExitCode::Done
}

fn read(file: &Path) -> Result<Town, ExitCode> {
    let text = std::fs::read_to_string(file).map_err(|error| {
        front::fail(&format!("cannot read `{}`: {}", file.display(), reason(&error)));
        ExitCode::Usage
    })?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    opendrive::read(&text, &name).map(Town::new).map_err(|error| {
        front::fail(&format!("cannot use the map `{}`: {error}", file.display()));
        ExitCode::Scenario
    })
}

/// Says what a town holds and what was skipped of its file.
fn describe(town: &Town) {
    let (low, high) = town.bounds();
    let kilometres = |kind: LaneKind| {
        let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| {
            let length = section.end - section.start;
            section.lanes.iter().filter(move |lane| lane.id != 0 && lane.kind == kind).map(move |_| length)
        });
        lanes.sum::<f64>() / 1000.0
    };
    let inside = town.roads.iter().filter(|road| road.junction.is_some()).count();
    front::say(&format!("town {}", town.name));
    front::say(&format!("  extent          {:.0} m × {:.0} m", high.x - low.x, high.y - low.y));
    let junctions = front::count(town.junctions.len(), "junction");
    front::say(&format!("  roads           {} ({inside} inside {junctions})", town.roads.len()));
    front::say(&format!("  driving lanes   {:.2} km", kilometres(LaneKind::Driving)));
    front::say(&format!("  sidewalks       {:.2} km", kilometres(LaneKind::Sidewalk)));
    front::say(&format!("  traffic lights  {}", town.traffic_lights.len()));
    front::say(&format!("  speed signs     {}", town.speed_signs.len()));
    front::say(&format!("  crosswalks      {}", town.crosswalks.len()));
    front::say(&format!("  obstacles       {}", town.obstacles.len()));
    front::say(&format!("  warnings        {}", town.warnings.len()));
    for warning in &town.warnings {
        front::say(&format!("    {warning}"));
    }
}

fn write(town: &Town, options: &MapOptions) -> Result<(), report::WriteError> {
    let picture = options.out.join(format!("{}.svg", town.name));
    report::write_file(&picture, report::town_map(town, &report::Starts::default()).as_bytes())?;
    front::say(&format!("  {}", picture.display()));
    if let Some(spacing) = options.waypoints {
        let table = options.out.join(format!("{}_waypoints.csv", town.name));
        report::write_csv(&table, &report::waypoints(town, spacing))?;
        front::say(&format!("  {}", table.display()));
    }
    Ok(())
}
