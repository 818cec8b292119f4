//! `falsify preview`: a page of the towns of a scenario, which follows the file while it is edited, or of a map.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use clap::{Args, value_parser};

use crate::cli::failure::unwritten;
use crate::cli::input::{GivenArgs, session};
use crate::cli::{console, interrupt};
use crate::commands::starts::{SampledStarts, sampled_starts};
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Checked, Error, Session};
use base::diagnostic::{Colour, render};
use results::report::{self, MapPage, StartLayer, TownView};
use road::{AssumedLimit, Crossing, GiveWay, LEVEL, LaneKind, Town, opendrive};

pub const EXAMPLES: &str = "\
Examples:
  falsify preview my.scn                     write my.preview.html and follow my.scn until Ctrl-C
  falsify preview my.scn --once              write the page and end
  falsify preview Town02.xodr                the map with the names of its lanes, and what it holds

Exit codes: 0 the page is written   3 --once, and the file has errors   6 the page cannot be written   130 Ctrl-C";

/// Time between two checks of the files.
const PAUSE: Duration = Duration::from_millis(250);
/// Maximum number of layers of starts in a town.
const MAX_LAYERS: usize = 12;
/// Maximum number of problems on a page, and of pairs of roads that are named.
const MAX_PROBLEMS: usize = 50;
/// Roads that differ less in height lie on each other (m).
const SAME_HEIGHT: f64 = 0.5;

/// Options of `falsify preview`.
#[derive(Debug, Args)]
pub struct PreviewArgs {
    /// A scenario file, or an OpenDRIVE map.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Replacements of parts of the file.
    #[command(flatten)]
    pub given: GivenArgs,
    /// Folder for the page, `NAME.preview.html`, and the script that tells it of a new version, `NAME.preview.js`.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// Write the page once and end.
    #[arg(long)]
    pub once: bool,
    /// The number of starts that are drawn of every spawn in every town.
    #[arg(long, default_value_t = 300, value_name = "N", value_parser = value_parser!(u32).range(1..=100_000))]
    pub sample: u32,
    /// Seed of the starts.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
}

/// The towns of a file with starts of episodes, and what is wrong with the file.
#[derive(Debug, Clone, Default)]
struct Preview {
    /// The diagnostics as they are drawn under their lines, without colour.
    problems: Vec<String>,
    errors: usize,
    /// The files that were read, or that could not be read.
    files: Vec<PathBuf>,
    /// Whether the file has errors and the towns are those of an earlier preview.
    outdated: bool,
    towns: Vec<(String, Arc<Town>)>,
    starts: Vec<(String, SampledStarts)>,
}

pub fn preview(options: &PreviewArgs) -> Ended {
    let session = session(options.given.allow_external);
    if options.once || is_map(&options.file) {
        let preview = Preview::default().next(&session, options);
        let page = preview.write(options, None)?;
        preview.problems.iter().for_each(|problem| console::note(problem));
        if let Some((_, town)) = preview.towns.first().filter(|_| is_map(&options.file)) {
            describe(town);
        }
        console::say(&page.display().to_string());
        return if preview.errors == 0 { Ok(ExitCode::Done) } else { Err(ExitCode::Scenario) };
    }
    interrupt::end_when_asked();
    let mut preview = Preview::default();
    for version in 1u64.. {
        // Changes while the files are read count as later ones.
        let mut known = stamps(&preview.files);
        preview = preview.next(&session, options);
        if known.len() != preview.files.len() {
            known = stamps(&preview.files);
        }
        // A page of an earlier call has another number.
        let page = preview.write(options, Some(format!("{}-{version}", std::process::id())))?;
        if version == 1 {
            console::say(&format!("open {} in a browser; Ctrl-C ends", page.display()));
        }
        console::say(&preview.count_errors());
        while stamps(&preview.files) == known {
            std::thread::sleep(PAUSE);
        }
    }
    Ok(ExitCode::Done)
}

/// When each file was last changed, and its length; `None` for a missing file.
fn stamps(files: &[PathBuf]) -> Vec<Option<(SystemTime, u64)>> {
    let stamp = |file: &PathBuf| {
        let data = std::fs::metadata(file).ok()?;
        Some((data.modified().ok()?, data.len()))
    };
    files.iter().map(stamp).collect()
}

/// Whether a file is a map. Its page is written once.
fn is_map(file: &Path) -> bool {
    file.extension().is_none_or(|extension| extension != "scn")
}

impl Preview {
    /// Reads the file again. One with errors keeps the towns of this preview.
    fn next(&self, session: &Session, options: &PreviewArgs) -> Self {
        if is_map(&options.file) { self.next_map(&options.file) } else { self.next_scenario(session, options) }
    }

    /// A version with errors, which keeps the towns.
    fn kept(&self, problems: Vec<String>, errors: usize, files: Vec<PathBuf>) -> Self {
        Self { problems, errors, files, outdated: !self.towns.is_empty(), ..self.clone() }
    }

    fn next_map(&self, file: &Path) -> Self {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let read = base::files::text(file).map_err(|error| lang::reason(&error));
        let town = read.and_then(|text| opendrive::read(&text, &name).map_err(|error| error.to_string()));
        match town {
            Ok(parts) => {
                let town = Town::new(parts);
                let laneless = town.driving_lanes().is_empty();
                let problem = format!("error: {}: the map has no driving lane outside junctions", file.display());
                Self {
                    problems: Vec::from_iter(laneless.then_some(problem)),
                    errors: usize::from(laneless),
                    files: vec![file.into()],
                    towns: vec![(name.into_owned(), Arc::new(town))],
                    ..Self::default()
                }
            }
            Err(error) => {
                let problem = format!("error: cannot use the map `{}`: {error}", file.display());
                self.kept(vec![problem], 1, vec![file.into()])
            }
        }
    }

    fn next_scenario(&self, session: &Session, options: &PreviewArgs) -> Self {
        let input = options.given.input(std::slice::from_ref(&options.file));
        let checked = match session.check(&input) {
            Ok(checked) => checked,
            Err(Error::Unreadable { files }) => {
                let problems: Vec<String> = files.iter().map(|file| format!("error: {file}")).collect();
                return self.kept(problems, files.len(), input.files);
            }
            Err(other) => return self.kept(vec![format!("error: {other}")], 1, input.files),
        };
        let files = checked.records.iter().map(|record| PathBuf::from(&record.path)).collect();
        let errors = checked.errors();
        let Checked { compiled, sources, .. } = checked;
        let shown = compiled.diagnostics.iter().take(MAX_PROBLEMS).map(|each| render(each, &sources, Colour::Never));
        let more = compiled.diagnostics.len().saturating_sub(MAX_PROBLEMS);
        let problems = shown.chain((more > 0).then(|| format!("… and {more} more"))).collect();
        // Spawns that cannot be satisfied are drawn too: the map may show why.
        let Some(plan) = compiled.plan.or(compiled.unplaced) else { return self.kept(problems, errors, files) };
        let mut towns: Vec<(String, Arc<Town>)> = Vec::new();
        for town in plan.towns.iter().chain(plan.campaigns.iter().flat_map(|campaign| &campaign.towns)) {
            if towns.iter().all(|(name, _)| *name != town.name) {
                towns.push((town.name.clone(), town.town.clone()));
            }
        }
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
        Self { problems, errors, files, outdated: false, towns, starts }
    }

    /// Writes the page and, if it has a version, the script that names it; the error is the exit code, after the reason has been printed.
    fn write(&self, options: &PreviewArgs, version: Option<String>) -> Result<PathBuf, ExitCode> {
        let place = |ending: &str| {
            let mut name = OsString::from(options.file.file_stem().unwrap_or_default());
            name.push(ending);
            options.out.join(name)
        };
        let (page, script) = (place(".preview.html"), place(".preview.js"));
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let follows = version.as_ref().map(|version| (base::files::address(&name(&script), b"-_.~"), version.clone()));
        let text = self.page(&name(&options.file), follows);
        let written = report::write_file(&page, text.as_bytes()).and_then(|()| match version {
            // The page is there before the script names it.
            Some(version) => report::write_file(&script, format!("falsifyVersion(\"{version}\");\n").as_bytes()),
            None => Ok(()),
        });
        written.map(|()| page).map_err(unwritten)
    }

    /// The page with this title. A page that `follows` a script (its file name, and the version of this page) loads itself again when
    /// the script names another version.
    fn page(&self, title: &str, follows: Option<(String, String)>) -> String {
        let layers = |town: &str| {
            let here = self.starts.iter().filter(|(_, sampled)| sampled.town == town).take(MAX_LAYERS);
            here.map(|(name, sampled)| StartLayer { name: name.clone(), survey: &sampled.survey }).collect()
        };
        let views = self.towns.iter().map(|(name, town)| TownView { town, starts: layers(name) });
        let towns = match self.towns.len() {
            0 => "no town to show".to_owned(),
            towns => console::count(towns, "town"),
        };
        let outdated = if self.outdated { "; the maps are those of the last version that could be drawn" } else { "" };
        report::map_page(&MapPage {
            title: title.to_string(),
            note: format!("{}, {towns}{outdated}", self.count_errors()),
            problems: self.problems.clone(),
            towns: views.collect(),
            follows,
        })
    }

    fn count_errors(&self) -> String {
        if self.errors == 0 { "no errors".into() } else { console::count(self.errors, "error") }
    }
}

/// Prints what a map holds and what was skipped of its file.
fn describe(town: &Town) {
    let (low, high) = town.bounds();
    let kilometres = |kind: LaneKind| {
        let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| {
            let length = section.end - section.start;
            section.lanes.iter().filter(move |lane| lane.id != 0 && lane.kind == kind).map(move |_| length)
        });
        // The sum of no numbers is -0.0.
        format!("{:.2} km", lanes.sum::<f64>() / 1000.0 + 0.0)
    };
    let inside = town.roads.iter().filter(|road| road.junction.is_some()).count();
    let junctions = console::count(town.junctions.len(), "junction");
    let signs = |kind| town.give_way_signs.iter().filter(|sign| sign.kind == kind).count().to_string();
    let crossings = town.crossings();
    let odd: Vec<String> = crossings.iter().filter_map(|crossing| said_of(town, crossing)).collect();
    let above = crossings.iter().filter(|crossing| crossing.apart >= LEVEL).count();
    console::say(&format!("town {}", town.name));
    if above > 0 {
        console::say(&format!("  {:16}{}", "above others", console::count(above, "place")));
    }
    for (what, value) in [
        ("extent", format!("{:.0} m × {:.0} m", high.x - low.x, high.y - low.y)),
        ("roads", format!("{} ({inside} inside {junctions})", town.roads.len())),
        ("driving lanes", kilometres(LaneKind::Driving)),
        ("sidewalks", kilometres(LaneKind::Sidewalk)),
        ("traffic lights", town.traffic_lights.len().to_string()),
        ("speed limits", limits(town)),
        ("speed signs", town.speed_signs.len().to_string()),
        ("stop signs", signs(GiveWay::Stop)),
        ("yield signs", signs(GiveWay::Yield)),
        ("crosswalks", town.crosswalks.len().to_string()),
        ("obstacles", town.obstacles.len().to_string()),
        ("warnings", (town.warnings.len() + odd.len()).to_string()),
    ] {
        console::say(&format!("  {what:16}{value}"));
    }
    town.warnings.iter().for_each(|warning| console::say(&format!("    {warning}")));
    let more = odd.len().saturating_sub(MAX_PROBLEMS);
    let rest = (more > 0).then(|| format!("… and {more} more pairs of roads"));
    odd.iter().take(MAX_PROBLEMS).chain(&rest).for_each(|crossing| console::say(&format!("    {crossing}")));
}

/// What is odd about two roads at one place: they lie on each other, or one above the other and cannot be told apart.
fn said_of(town: &Town, Crossing { roads, place, apart, is_same_way }: &Crossing) -> Option<String> {
    let why = match *apart {
        ..SAME_HEIGHT => "on each other, or they cross without a junction: their cars meet".to_owned(),
        ..LEVEL => format!("only {apart:.1} m apart in height, which is one level: their cars meet"),
        _ if *is_same_way => {
            "above each other in one direction: a car that starts there is on the lower one".to_owned()
        }
        _ => return None,
    };
    let [one, other] = roads.map(|road| town.roads[road.0 as usize].id);
    Some(format!("roads {one} and {other} at ({:.1} m, {:.1} m): {why}", place.x, place.y))
}

/// The limits that the map gives its driving lanes.
fn limits(town: &Town) -> String {
    let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| &section.lanes);
    let driving = lanes.filter(|lane| lane.kind == LaneKind::Driving);
    let known = driving.flat_map(|lane| &lane.limits).filter_map(|(_, limit)| limit.map(|limit| limit * 3.6));
    let (min, max) = known.fold((f64::INFINITY, 0.0_f64), |(min, max), limit| (min.min(limit), max.max(limit)));
    let known = match (max - min).abs() {
        _ if max == 0.0 && !town.speed_signs.is_empty() => "those of the signs, 30 km/h before the first".to_owned(),
        _ if max == 0.0 => String::new(),
        difference if difference < 0.5 => format!("{max:.0} km/h"),
        _ => format!("{min:.0} to {max:.0} km/h"),
    };
    let assumed = AssumedLimit::of(&town.roads, &town.speed_signs).map(|assumed| assumed.to_string());
    [known, assumed.unwrap_or_default()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
}
