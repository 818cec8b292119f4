mod recordings;

use std::path::PathBuf;

use clap::Args;

use super::condition;
use crate::cli::console;
use crate::cli::failure::{failed, misused, unwritten};
use crate::cli::input::refuse_overwriting;
use crate::exit_code::{Ended, ExitCode};
use crate::session::Error;
use recordings::Recordings;
use results::report::{self, Gate, JudgedMeeting, JudgedRecording};
use verdict::{HeadingUnit, Sizes, Units};

pub const EXAMPLES: &str = "\
Examples:
  falsify judge trace.csv                    would a careful driver have avoided the touch?
  falsify judge drive.mcap --page drive.html every encounter of a recording, the worst first, each with its player
  falsify judge drive.osi --car 7 --fail-if 'preventable > 0'
                                             those of the car 7; exit code 7 if a careful driver avoids a touch of them
  falsify replay 1a2b3c4d:17 --ticks way.csv && falsify judge way.csv
                                             an episode of ours, as if no building stood there; `cannot tell` if it begins in danger

Files:
  .mcap, .osi                                ASAM OSI: `GroundTruth` or `SensorView`. What stands still hides a pedestrian
  .csv                                       a car and a pedestrian, with these columns in any order; others are ignored:
    time_s                                   time, with a constant step of 0.001 s to 0.5 s
    ego_x_m, ego_y_m                         middle of the car's box
    ego_yaw_deg, ego_speed_mps               its heading, from x to y, and its speed along it: negative when it reverses
    pedestrian_x_m, pedestrian_y_m           middle of the pedestrian
    pedestrian_yaw_deg, pedestrian_speed_mps direction and speed of its motion; without both they come from the positions

The frame is right-handed. Of recordings from CARLA change the signs of y and of the heading.
A recording begins before the pedestrian is a danger. It cannot say that it was dark or wet. What is damaged in it is told with its place; an answer that rests on it is `cannot tell`.

--fail-if counts `encounters`, `touches`, `preventable`, `faults` and `cannot_tell`. A touch or a pair that cannot be judged fails a condition about verdicts.

Exit codes: 0 it was judged   2 the file cannot be read, or is not a recording   6 a file cannot be written
  7 a condition is true";

/// Options of `falsify judge`.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// A recording: .mcap or .osi of ASAM OSI, or .csv with a row for each instant.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The car that is judged, by its number in the recording; without it the one that recorded, or all that move.
    #[arg(long, value_name = "ID")]
    pub car: Option<String>,
    /// Pedestrians that come nearer to a car than this are encounters (m).
    #[arg(long, value_name = "METRES", default_value_t = 2.0, value_parser = near)]
    pub near: f64,
    /// The unit of `time_s`: s, ms, us or ns.
    #[arg(long, value_name = "UNIT", default_value = "s", value_parser = ["s", "ms", "us", "ns"])]
    pub time_unit: String,
    /// The unit of speeds: m/s, km/h or mph.
    #[arg(long, value_name = "UNIT", default_value = "m/s", value_parser = ["m/s", "km/h", "mph"])]
    pub speed_unit: String,
    /// What headings are: deg or rad from x to y, or compass, in degrees clockwise from y.
    #[arg(long, value_name = "UNIT", default_value = "deg", value_parser = ["deg", "rad", "compass"])]
    pub heading_unit: String,
    /// Take the velocity of the pedestrian from its positions: its columns are those of its body.
    #[arg(long)]
    pub no_velocity: bool,
    /// Length of the car (m); without it that of the recording, or of the paper's car, 4.79.
    #[arg(long, value_name = "METRES")]
    pub length: Option<f64>,
    /// Width of the car (m); without it that of the recording, or of the paper's car, 2.16.
    #[arg(long, value_name = "METRES")]
    pub width: Option<f64>,
    /// Radius of the pedestrian (m); without it that of the recording, or of the paper's pedestrian, 0.188.
    #[arg(long, value_name = "METRES")]
    pub radius: Option<f64>,
    /// Deceleration of the car at full brake (m/s²); without it that of the paper's car, 7.01. Careful humans brake with it, at most with 7.59.
    #[arg(long, value_name = "M/S2")]
    pub full_brake: Option<f64>,
    /// Write a page with a player of each encounter.
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
    /// Write a row for each encounter, as CSV.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Fail with exit code 7 if this is true, such as `preventable > 0`.
    #[arg(long, value_name = "CONDITION")]
    pub fail_if: Vec<String>,
    /// Let touches and pairs that cannot be judged pass a condition about `preventable` or `faults`, which they fail otherwise.
    #[arg(long, requires = "fail_if")]
    pub allow_unjudged: bool,
    /// Print one JSON object, for programs.
    #[arg(long)]
    pub json: bool,
}

pub fn judge(options: &JudgeArgs) -> Ended {
    let reference = report::counted_reference();
    let gate =
        |text: &String| Gate::of_table(text, &reference).map(|gate| gate.allowing_unjudged(options.allow_unjudged));
    let gates = options.fail_if.iter().map(gate);
    let gates = gates.collect::<Result<Vec<Gate>, _>>().map_err(|error| misused(format!("--fail-if: {error}")))?;
    let sizes =
        Sizes { length: options.length, width: options.width, radius: options.radius, full_brake: options.full_brake };
    refuse_overwriting(&[options.csv.as_ref(), options.page.as_ref()], std::slice::from_ref(&options.file))?;
    let recordings = Recordings::read(&options.file, options.near, options.car.as_deref(), &units(options));
    let judged = recordings.and_then(|recordings| recordings.judged(sizes));
    let all = judged
        .map_err(|reason| failed(Error::Usage(format!("cannot judge `{}`: {}", options.file.display(), reason))))?;
    if options.json {
        console::say(&all.to_json().to_string());
    } else {
        tell_all(&all, options);
    }
    if let Some(path) = &options.csv {
        report::write_file(path, report::csv_text(&report::meetings_table(&all)).as_bytes()).map_err(unwritten)?;
    }
    if let Some(path) = &options.page {
        let name = options.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        report::write_file(path, report::judgement_page(&name, &all).as_bytes()).map_err(unwritten)?;
        console::note(&path.display().to_string());
    }
    let mut passes = true;
    for gate in &gates {
        let judged = gate.judge(&report::counted_table(&all));
        condition::tell(gate, &judged, &["the recording".to_owned()]);
        passes &= !judged.iter().any(report::Judged::fails);
    }
    Ok(ExitCode::of_gate(passes))
}

fn near(text: &str) -> Result<f64, String> {
    let near = text.parse().ok().filter(|near| (0.01..=100.0).contains(near));
    near.ok_or_else(|| "give 0.01 to 100".to_owned())
}

fn units(options: &JudgeArgs) -> Units {
    let time = match &*options.time_unit {
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        _ => 1.0,
    };
    let speed = match &*options.speed_unit {
        "km/h" => 1.0 / 3.6,
        "mph" => 0.44704,
        _ => 1.0,
    };
    let heading = HeadingUnit::named(&options.heading_unit).unwrap_or(HeadingUnit::Degrees);
    Units { time, speed, heading, without_velocity: options.no_velocity }
}

fn say_wrapped(text: &str) {
    console::say(console::wrapped(text).trim_end());
}

/// Prints the encounters for people: all in a table if there are several, and the worst in words.
fn tell_all(recording: &JudgedRecording, options: &JudgeArgs) {
    let all = &recording.encounters;
    for pair in &recording.unjudged {
        say_wrapped(&pair.to_string());
    }
    let Some(worst) = all.first() else {
        say_wrapped(&format!("no pedestrian comes nearer than {} m to a car that is judged", options.near));
        return;
    };
    if all.len() > 1 {
        console::say(&format!("{}, the worst first", console::count(all.len(), "encounter")));
        console::say(report::meetings_for_terminal(all, console::width()).trim_end());
        console::say(&format!("\nthe worst, {}:", worst.title()));
    }
    tell(worst);
    let car = &worst.found.scenario.cast.ego().blueprint;
    say_wrapped(&format!(
        "assumed: a car of {:.2} m by {:.2} m that brakes with at most {:.2} m/s^2, daylight, and a dry road",
        2.0 * car.half_length,
        2.0 * car.half_width,
        car.full_brake
    ));
}

/// Prints an encounter for people.
fn tell(each: &JudgedMeeting) {
    let found = &each.found;
    for finding in &found.findings {
        say_wrapped(&format!("found: {finding}"));
    }
    for line in report::judgement_lines(each) {
        say_wrapped(&line);
    }
    if let Some(answers) = each.answers().filter(|_| found.told().is_some()) {
        console::say(answers.to_terminal(console::width()).trim_end());
    }
}
