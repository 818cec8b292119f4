//! Recordings as other tools and roads give them: each disturbed one has the class of the undisturbed one.

use std::fmt::Write;

use world::env::Scenario;
use world::judge::{Encountered, Recording, RecordingFileError};

/// An encounter on a straight road. The car drives east; its bumper is at `x = 0` at time 0.
#[derive(Clone, Copy)]
struct Encounter {
    /// Speed of the car (m/s), and the time before the meeting from which it brakes (s) with 5 m/s².
    speed: f64,
    brakes: f64,
    /// Velocity of the pedestrian (m/s) from a time before the meeting (s) on; before it, it stands. At the meeting it is at this `y` (m).
    walks: f64,
    from: f64,
    at: f64,
}

/// Steady crossing in full view: a fault.
const CROSSING: Encounter = Encounter { speed: 10.0, brakes: 0.0, walks: 1.4, from: 20.0, at: 0.0 };
/// A step out of one second: too late for a careful human.
const STEP_OUT: Encounter = Encounter { speed: 10.0, brakes: 0.0, walks: 1.4, from: 1.1, at: -0.4 };
/// A person who stands in the lane.
const STANDING: Encounter = Encounter { speed: 13.0, brakes: 0.0, walks: 0.0, from: 20.0, at: 0.2 };
/// A person who stands in the lane, before a car that brakes too late.
const LATE: Encounter = Encounter { speed: 14.0, brakes: 0.8, walks: 0.0, from: 20.0, at: -0.3 };

const ALL: [(Encounter, &str); 4] =
    [(CROSSING, "fault"), (STEP_OUT, "not_preventable"), (STANDING, "fault"), (LATE, "fault")];

/// A row: time, x, y, yaw (deg) and speed of the car, x, y, yaw (deg) and speed of the pedestrian.
type Row = [f64; 9];

const COLUMNS: &str = "time_s,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps,pedestrian_x_m,pedestrian_y_m,pedestrian_yaw_deg,pedestrian_speed_mps";

impl Encounter {
    /// The rows from nine seconds before the meeting to one second after it.
    fn rows(&self, rate: f64) -> Vec<Row> {
        let row = |instant: u32| {
            let time = f64::from(instant) / rate - 9.0;
            let braked = (time + self.brakes).clamp(0.0, self.speed / 5.0);
            let lost = 2.5 * self.brakes * self.brakes;
            let x = self.speed * time + lost
                - 2.395
                - 2.5 * braked * braked
                - 5.0 * braked * (time + self.brakes - braked).max(0.0);
            let walked = self.walks * (time.max(-self.from));
            let speed = if time >= -self.from { self.walks } else { 0.0 };
            [time + 9.0, x, 0.0, 0.0, self.speed - 5.0 * braked, 0.188, self.at + walked, 90.0, speed]
        };
        (0..=(10.0 * rate) as u32).map(row).collect()
    }
}

fn csv(rows: &[Row], columns: usize) -> String {
    let mut text = COLUMNS.split(',').take(columns).collect::<Vec<_>>().join(",");
    for row in rows {
        text.push('\n');
        for (place, number) in row[..columns].iter().enumerate() {
            let _ = write!(text, "{}{number}", if place == 0 { "" } else { "," });
        }
    }
    text
}

/// With or without the columns of the pedestrian's velocity.
const WITH_AND_WITHOUT: [usize; 2] = [9, 7];

fn judged(scenario: &Scenario, rows: &[Row], columns: usize) -> Result<Encountered, RecordingFileError> {
    Ok(Recording::from_csv(&csv(rows, columns))?.judged_without_obstacles(scenario))
}

/// The class of a recording, or why it is refused.
fn class(scenario: &Scenario, rows: &[Row], columns: usize) -> String {
    match judged(scenario, rows, columns) {
        Ok(Encountered { begins_late: Some(_), .. }) => "cannot_tell".to_owned(),
        Ok(found) => found.verdict.map_or("no touch".to_owned(), |verdict| verdict.class().name().to_owned()),
        Err(error) => error.to_string(),
    }
}

/// Wants the class of the undisturbed recording of each disturbed one.
fn unchanged(rates: &[f64], name: &str, mut disturb: impl FnMut(&mut Vec<Row>, f64)) {
    let scenario = crate::case_book::scenario();
    let mut wrong = Vec::new();
    for rate in rates {
        for (encounter, wanted) in ALL {
            for columns in WITH_AND_WITHOUT {
                let mut rows = encounter.rows(*rate);
                disturb(&mut rows, *rate);
                let found = class(&scenario, &rows, columns);
                if found != wanted {
                    wrong.push(format!("{name}, {rate} Hz, {columns} columns: {found} instead of {wanted}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn undisturbed_recordings_have_their_classes() {
    unchanged(&[10.0, 20.0, 50.0, 100.0], "undisturbed", |_, _| ());
}

#[test]
fn a_row_without_speed_is_no_stop() {
    unchanged(&[10.0, 20.0, 50.0], "a row with speed 0", |rows, rate| rows[(7.3 * rate) as usize][4] = 0.0);
}
