use std::f64::consts::PI;

use base::choice;

use super::{InstantFault, Recording, RecordingError};
use road::geometry::{Point, Pose};
use world::sim::{PedestrianState, VehicleState};

/// Columns that a file needs.
const NEEDED: [&str; 7] =
    ["time_s", "ego_x_m", "ego_y_m", "ego_yaw_deg", "ego_speed_mps", "pedestrian_x_m", "pedestrian_y_m"];
/// Columns of the pedestrian's velocity: both or none.
const VELOCITY: [&str; 2] = ["pedestrian_yaw_deg", "pedestrian_speed_mps"];
/// The most columns; what follows is not looked at.
const MAX_COLUMNS: usize = 10_000;
/// Characters of a header without the columns that are needed, and the first in any header: what they show, and what is needed.
const FORMATS: [(&[char], &str, &str); 4] = [
    (&['\r'], "lines end with a carriage return alone", "line feeds"),
    (&[';'], "fields are separated by `;`", "`,` between fields, and decimal points"),
    (&['\t'], "fields are separated by tabs", "`,`"),
    (
        &['\u{201c}', '\u{201d}', '\u{201e}', '\u{2018}', '\u{2019}'],
        "names are in typographic quotes",
        "`\"` or no quotes",
    ),
];
/// The greatest deviation of a time from a constant step, as a share of the step.
const UNEVEN: f64 = 0.1;
/// A speed of a pedestrian may be as far below 0 by noise (m/s); its direction is then the opposite.
const NOISE_OF_SPEED: f64 = 1.0;

/// The units of a file, where they are not seconds, m/s and degrees from x to y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// A unit of time in seconds, and one of speed in m/s.
    pub time: f64,
    pub speed: f64,
    pub heading: HeadingUnit,
    /// Whether the columns of the pedestrian's velocity are left out: they are those of its body.
    pub without_velocity: bool,
}

choice! {
    /// How headings are written.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum HeadingUnit {
        /// Degrees, from x to y.
        Degrees = "deg",
        /// Radians, from x to y.
        Radians = "rad",
        /// Degrees clockwise from y, as of a compass.
        Compass = "compass",
    }
}

impl Default for Units {
    fn default() -> Self {
        Self { time: 1.0, speed: 1.0, heading: HeadingUnit::Degrees, without_velocity: false }
    }
}

impl Units {
    /// A heading in radians, from x to y.
    fn yaw(&self, heading: f64) -> f64 {
        match self.heading {
            HeadingUnit::Degrees => heading.to_radians(),
            HeadingUnit::Radians => heading,
            HeadingUnit::Compass => (90.0 - heading).to_radians(),
        }
    }
}

/// A file that holds no recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingFileError {
    #[error("there is no column `{column}`; there is {}", if found.is_empty() { "none".to_owned() } else { found.join(", ") })]
    Column { column: &'static str, found: Vec<String> },
    #[error("the {found}; give {wanted}")]
    Format { found: &'static str, wanted: &'static str },
    #[error("the column `{column}` is there twice; give one")]
    Repeated { column: &'static str },
    #[error("line {line}: there are {found} fields; the header has {wanted}{}", if *found + 1 >= 2 * wanted { ". Give decimal points, no decimal commas" } else { "" })]
    Fields { line: usize, found: usize, wanted: usize },
    #[error("line {line}: there are more than {most} rows; cut the recording", most = Recording::MAX_INSTANTS)]
    Long { line: usize },
    #[error("line {line}, column `{column}`: `{text}` is not a number")]
    Number { line: usize, column: &'static str, text: String },
    #[error("line {line}: the time is {time} s, {}; the others are {step} s apart. Give rows at a constant step (within {} % of it): interpolate the positions to one", since(*.found), UNEVEN * 100.0)]
    Uneven { line: usize, time: f64, found: f64, step: f64 },
    #[error("line {line}: `pedestrian_speed_mps` is {speed}; it is a speed in the direction of motion, 0 or more")]
    Backwards { line: usize, speed: f64 },
    #[error("line {line}: {fault}")]
    Instant { line: usize, fault: InstantFault },
    #[error("{0}")]
    Recording(#[from] RecordingError),
}

impl Recording {
    /// Reads a CSV file with a header and a row for each instant, in any order of columns. Names and units are those of the ticks of a
    /// report: `time_s`, `ego_x_m`, `ego_y_m`, `ego_yaw_deg`, `ego_speed_mps`, `pedestrian_x_m`, `pedestrian_y_m`, and if the velocity is not to
    /// come from positions, `pedestrian_yaw_deg` (direction of motion) and `pedestrian_speed_mps`. Other columns are ignored.
    ///
    /// # Errors
    /// A column is absent, a field is not a number, times have no constant step, or what [`Recording::new`] refuses.
    pub fn from_csv(text: &str, units: &Units) -> Result<Self, RecordingFileError> {
        let mut lines =
            text.trim_start_matches('\u{feff}').lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let header: Vec<&str> =
            lines.next().map_or_else(Vec::new, |(_, line)| fields(line).take(MAX_COLUMNS).collect());
        let place = |column: &'static str| header.iter().position(|name| *name == column);
        let absent = |column: &'static str| {
            if let Some((_, found, wanted)) =
                FORMATS.iter().find(|(signs, ..)| header.iter().any(|name| name.contains(*signs)))
            {
                return RecordingFileError::Format { found, wanted };
            }
            let found = header.iter().take(40).map(|name| name.chars().take(40).collect()).collect();
            RecordingFileError::Column { column, found }
        };
        // All rows are then one header.
        let [(_, found, wanted), ..] = FORMATS;
        if header.iter().any(|name| name.contains('\r')) {
            return Err(RecordingFileError::Format { found, wanted });
        }
        if let Some(column) =
            NEEDED.iter().chain(&VELOCITY).find(|name| header.iter().filter(|is| is == name).count() > 1)
        {
            return Err(RecordingFileError::Repeated { column });
        }
        let mut places: Vec<(&'static str, usize)> = Vec::new();
        for column in NEEDED {
            places.push((column, place(column).ok_or_else(|| absent(column))?));
        }
        let velocity = VELOCITY.map(|column| Some((column, place(column)?)));
        let has_velocity = !units.without_velocity && velocity.iter().any(Option::is_some);
        if has_velocity {
            for (column, found) in VELOCITY.into_iter().zip(velocity) {
                places.push(found.ok_or_else(|| absent(column))?);
            }
        }
        let (mut times, mut ego, mut positions, mut walkers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (index, line) in lines {
            if times.len() == Self::MAX_INSTANTS {
                return Err(RecordingFileError::Long { line: index + 1 });
            }
            let row: Vec<&str> = fields(line).take(MAX_COLUMNS).collect();
            if row.len() != header.len() {
                return Err(RecordingFileError::Fields { line: index + 1, found: row.len(), wanted: header.len() });
            }
            let mut numbers = [0.0; NEEDED.len() + VELOCITY.len()];
            for (number, (column, place)) in numbers.iter_mut().zip(&places) {
                *number = row[*place].parse().map_err(|_| RecordingFileError::Number {
                    line: index + 1,
                    column,
                    text: row[*place].chars().take(40).collect(),
                })?;
            }
            let [time, x, y, yaw, speed, walker_x, walker_y, walker_yaw, walker_speed] = numbers;
            let [speed, walker_speed] = [speed, walker_speed].map(|speed| speed * units.speed);
            if walker_speed < -NOISE_OF_SPEED {
                return Err(RecordingFileError::Backwards { line: index + 1, speed: walker_speed });
            }
            times.push((index + 1, time * units.time));
            ego.push(VehicleState { pose: Pose::new(x, y, units.yaw(yaw)), speed, ..VehicleState::default() });
            positions.push(Point::new(walker_x, walker_y));
            let direction = units.yaw(walker_yaw) + if walker_speed < 0.0 { PI } else { 0.0 };
            walkers.push(PedestrianState::moving(Pose::new(walker_x, walker_y, direction), walker_speed.abs()));
        }
        let dt = step(&times)?;
        let made = if has_velocity { Self::new(dt, ego, walkers) } else { Self::of_positions(dt, ego, &positions) };
        let lines: Vec<usize> = times.iter().map(|(line, _)| *line).collect();
        match made {
            Ok(mut recording) => {
                recording.tell_lines(&lines);
                Ok(recording)
            }
            Err(RecordingError::Instant { instant, fault }) => {
                Err(RecordingFileError::Instant { line: lines[instant], fault })
            }
            Err(error) => Err(RecordingFileError::Recording(error)),
        }
    }
}

fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|field| field.trim().trim_matches('"'))
}

/// The constant step of some times (s); not a number for fewer than two.
fn step(times: &[(usize, f64)]) -> Result<f64, RecordingFileError> {
    let [(_, first), .., (_, last)] = times else { return Ok(f64::NAN) };
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    let mean = (last - first) / steps.len() as f64;
    let found = steps.clone();
    steps.sort_by(f64::total_cmp);
    let usual = steps[steps.len() / 2];
    // Times that are rounded to as few decimals as a step has differ from it by as much.
    let is_even = |(instant, (_, time)): (usize, &(usize, f64))| {
        (time - first - instant as f64 * mean).abs() <= UNEVEN * mean.abs()
    };
    if times.iter().enumerate().all(is_even) {
        return Ok(mean);
    }
    let deviates = |step: &f64| (step - usual).abs() > UNEVEN * usual.abs() || step.is_nan();
    // Without a step that deviates by itself, many small ones add up: the largest is named.
    let worst = || (0..found.len()).max_by(|a, b| (found[*a] - usual).abs().total_cmp(&(found[*b] - usual).abs()));
    let at = found.iter().position(deviates).or_else(worst).unwrap_or(0);
    let (line, time) = times[at + 1];
    let rounded = |number: f64| (number * 1e6).round() / 1e6;
    Err(RecordingFileError::Uneven { line, time, found: rounded(found[at]), step: rounded(usual) })
}

/// How a time (s) follows on the one before.
fn since(step: f64) -> String {
    match step {
        0.0 => "as in the row before".to_owned(),
        step if step < 0.0 => format!("{} s before the row before", -step),
        step => format!("{step} s after the row before"),
    }
}
