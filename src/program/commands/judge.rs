use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use crate::cli::console;
use crate::cli::failure::failed;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Error, Input, Session};
use episode::Scenario;
use lang::reason;
use results::report;
use verdict::{Encountered, Recording, RecordingFileError, Reference, RestsOn, Sizes, Verdict};
use world::sim::VehicleBlueprint;

pub const EXAMPLES: &str = "\
Examples:
  falsify judge trace.csv                    would a careful driver have avoided the first touch?
  falsify judge trace.csv --length 4.2 --width 1.8 --radius 0.25 --json
  falsify replay 1a2b3c4d:17 --ticks way.csv && falsify judge way.csv
                                             an episode of ours, as if no building stood there; `cannot tell` if it begins in danger

The columns, in any order, others are ignored:
  time_s                                     time, with a constant step of 0.001 s to 0.5 s
  ego_x_m, ego_y_m                           middle of the car's box
  ego_yaw_deg, ego_speed_mps                 its heading, from x to y, and its speed along it: negative when it reverses
  pedestrian_x_m, pedestrian_y_m             middle of the pedestrian
  pedestrian_yaw_deg, pedestrian_speed_mps   direction and speed of its motion; without both they come from the positions

The frame is right-handed. Of recordings from CARLA change the signs of y and of the heading.
A recording begins before the pedestrian is a danger. It cannot say that it was dark or wet, or that something hid the pedestrian.

Exit codes: 0 it was judged   2 the file cannot be read, or is not a recording";

/// Options of `falsify judge`.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// A recording: CSV with a header and a row for each instant.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Length of the car (m); without it that of the paper's car, 4.79.
    #[arg(long, value_name = "METRES")]
    pub length: Option<f64>,
    /// Width of the car (m); without it that of the paper's car, 2.16.
    #[arg(long, value_name = "METRES")]
    pub width: Option<f64>,
    /// Radius of the pedestrian (m); without it that of the paper's pedestrian, 0.188.
    #[arg(long, value_name = "METRES")]
    pub radius: Option<f64>,
    /// Deceleration of the car at full brake (m/s²); without it that of the paper's car, 7.01. Careful humans brake with it, at most with 7.59.
    #[arg(long, value_name = "M/S2")]
    pub full_brake: Option<f64>,
    /// Print one JSON object, for programs.
    #[arg(long)]
    pub json: bool,
}

/// The paper's car and pedestrian, whose sizes and grip a recording has when nothing else is stated.
const PAPER: &str = "\
edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import \"std/towns.scn\"
campaign recording {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random]  episodes: 1 }
}
";
/// Its name among the files of a session.
const PAPER_FILE: &str = "recording.scn";

pub fn judge(options: &JudgeArgs) -> Ended {
    let (found, recording, car) = judged(options).map_err(failed)?;
    if options.json {
        console::say(&as_json(&found, &car).to_string());
    } else {
        tell(&found, &recording);
        say_wrapped(&format!(
            "assumed: a car of {:.2} m by {:.2} m that brakes with at most {:.2} m/s^2, daylight, a dry road, and nothing that hides the pedestrian",
            2.0 * car.half_length,
            2.0 * car.half_width,
            car.full_brake
        ));
    }
    Ok(ExitCode::Done)
}

/// Judges the first touch of a car and a pedestrian that were recorded elsewhere, on a plane without obstacles.
fn judged(options: &JudgeArgs) -> Result<(Encountered, Recording, VehicleBlueprint), Error> {
    let refused = |reason: String| Error::Usage(format!("cannot judge `{}`: {reason}", options.file.display()));
    let text = base::files::text(&options.file).map_err(|error| refused(reason(&error)))?;
    let recording = Recording::from_csv(&text).map_err(|error| refused(error.to_string()))?;
    let mut scenario = paper()?;
    let sizes =
        Sizes { length: options.length, width: options.width, radius: options.radius, full_brake: options.full_brake };
    sizes.apply(&mut scenario).map_err(|error| refused(RecordingFileError::from(error).to_string()))?;
    let car = scenario.cast.ego().blueprint.clone();
    Ok((recording.judged_without_obstacles(&scenario), recording, car))
}

/// The scenario with the paper's car and pedestrian.
fn paper() -> Result<Scenario, Error> {
    let session = Session::default().with_reader(|path: &Path| match path.to_str() {
        Some(PAPER_FILE) => Ok(PAPER.to_string()),
        _ => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
    });
    let checked = session.check(&Input::file(PAPER_FILE))?;
    Ok(Scenario::clone(&checked.plan()?.campaigns[0].nth::<compile::Evaluation>(0).scenario))
}

fn say_wrapped(text: &str) {
    console::say(console::wrapped(text).trim_end());
}

/// Prints the result for people.
fn tell(found: &Encountered, recording: &Recording) {
    let near = &found.near_miss;
    if recording.parts() > 1 {
        console::say(&format!("rows are {:.2} s apart: the motion between them is interpolated", recording.dt()));
    }
    if let [first, rest @ ..] = &found.ignored[..] {
        let others = if rest.is_empty() { String::new() } else { format!(" and in {} others", rest.len()) };
        let line = recording.line(*first).unwrap_or(*first);
        say_wrapped(&format!(
            "ignored: the speed, heading or position in line {line}{others}, which those before and after contradict"
        ));
    }
    if let (Some(touch), Some(late)) = (found.touch, found.begins_late) {
        console::say(&format!("touch after {touch:.2} s"));
        say_wrapped(&format!(
            "verdict: cannot tell. The danger was under way when the recording begins; give at least {} s more before it",
            (late * 10.0).ceil() / 10.0
        ));
        return;
    }
    let (Some(touch), Some(verdict)) = (found.touch, &found.verdict) else {
        console::say(&format!("no touch; the least distance is {:.2} m", found.least_gap));
        if let Some(before) = found.ends_before {
            say_wrapped(&format!(
                "it ends {before:.2} s before a touch, if both go on as they do: record for longer, or it tells nothing"
            ));
        }
        if let Some(ttc) = near.min_ttc {
            console::say(&format!("the least time to collision is {ttc:.2} s"));
        }
        if let Some(pet) = near.pet {
            console::say(&format!("the post-encroachment time is {pet:.2} s"));
        }
        return;
    };
    console::say(&format!(
        "touch after {touch:.2} s at the {} of the car, which drives {:.2} m/s",
        verdict.side.name(),
        verdict.impact_speed
    ));
    console::say(&format!("verdict: {}", verdict.label.name()));
    let counts = if verdict.is_fault() { "counts" } else { "does not count" };
    let class = verdict.class();
    say_wrapped(&format!("counts as {}: it {counts} against the driver, since {}", class.name(), class.reason()));
    if verdict.warning + recording.dt() >= touch {
        console::say("the danger started in the first row, or before it");
    } else {
        console::say(&format!("the danger started {:.2} s before the touch", verdict.warning));
    }
    report::reference_lines(verdict).for_each(|line| console::say(&line));
}

/// Makes an object of the result, with the names of the table of episodes; what does not apply is null.
fn as_json(found: &Encountered, car: &VehicleBlueprint) -> serde_json::Value {
    let verdict = found.verdict.as_ref().filter(|_| found.begins_late.is_none());
    let avoided = verdict.map(|verdict| {
        let of = |reference: Reference| (reference.name(), json!(verdict.trial(reference).is_avoided()));
        Reference::ALL.map(of).into_iter().collect::<std::collections::BTreeMap<_, _>>()
    });
    json!({
        "touch_s": found.touch,
        "impact_speed_mps": verdict.map(|verdict| verdict.impact_speed),
        "side": verdict.map(|verdict| verdict.side.name()),
        "verdict": verdict.map(|verdict| verdict.label.name()).or(found.begins_late.map(|_| "cannot_tell")),
        "begins_late_s": found.begins_late,
        "counts_as": verdict.map(|verdict| verdict.class().name()),
        "foreseeable": verdict.map(|verdict| verdict.foreseeable),
        "fault": verdict.map(Verdict::is_fault),
        "warning_s": verdict.map(|verdict| verdict.warning),
        "rests_on": verdict.and_then(|verdict| verdict.rests_on).map(RestsOn::name),
        "avoided_by": avoided,
        "least_gap_m": found.least_gap,
        "ends_before_s": found.ends_before,
        "min_ttc_s": found.near_miss.min_ttc,
        "pet_s": found.near_miss.pet,
        "ignored_instants": found.ignored,
        "car_length_m": 2.0 * car.half_length,
        "car_width_m": 2.0 * car.half_width,
        "full_brake_mps2": car.full_brake,
    })
}
