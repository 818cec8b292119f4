//! Recordings as other tools and roads give them: each disturbed one has the class of the undisturbed one, or tells where it is damaged and that it cannot tell.

use std::fmt::Write;

use base::seed::{Seed, Stream};
use episode::Scenario;
use rand::RngExt;
use verdict::{Encountered, Recording, RecordingFileError, Units};

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

/// A jogger who crosses in full view.
const JOGGING: Encounter = Encounter { walks: 2.8, ..CROSSING };

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
    Ok(Recording::from_csv(&csv(rows, columns), &Units::default())?.judged_without_obstacles(scenario))
}

/// The class of a recording, or why it is refused.
fn class(scenario: &Scenario, rows: &[Row], columns: usize) -> String {
    match judged(scenario, rows, columns) {
        Ok(Encountered { begins_late: Some(_), .. }) => "cannot_tell".to_owned(),
        Ok(Encountered { undecided: Some(finding), .. }) => finding.to_string(),
        Ok(found) => found.verdict.map_or("no touch".to_owned(), |verdict| verdict.class().name().to_owned()),
        Err(error) => error.to_string(),
    }
}

/// Wants the class of the undisturbed recording of each disturbed one.
fn unchanged(rates: &[f64], name: &str, disturb: impl FnMut(&mut Vec<Row>, f64)) {
    unchanged_or(rates, name, disturb, &[]);
}

/// Wants that class, or one of these words about a finding that decides.
fn unchanged_or(rates: &[f64], name: &str, mut disturb: impl FnMut(&mut Vec<Row>, f64), told: &[&str]) {
    let scenario = crate::case_book::scenario();
    let mut wrong = Vec::new();
    for rate in rates {
        for (encounter, wanted) in ALL {
            for columns in WITH_AND_WITHOUT {
                let mut rows = encounter.rows(*rate);
                disturb(&mut rows, *rate);
                let found = class(&scenario, &rows, columns);
                if found != wanted && !told.iter().any(|words| found.contains(words)) {
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

fn normal(stream: &mut Stream, deviation: f64) -> f64 {
    let (radius, angle) = (stream.random_range(1e-12..1.0_f64), stream.random_range(0.0..std::f64::consts::TAU));
    deviation * (-2.0 * libm::log(radius)).sqrt() * libm::cos(angle)
}

#[test]
fn a_row_without_speed_is_no_stop() {
    for before in [0.1, 0.6, 1.1, 1.2, 1.9, 2.4, 2.5] {
        unchanged_or(
            &[10.0, 20.0, 50.0],
            "a row with speed 0",
            |rows, rate| {
                rows[((9.0 - before) * rate).round() as usize][4] = 0.0;
            },
            &["the speed of the car leaps"],
        );
    }
    unchanged_or(
        &[20.0],
        "a first row with speed 0",
        |rows, _| rows[0][4] = 0.0,
        &["line 2: the speed of the car leaps"],
    );
    for place in [1, 150] {
        unchanged_or(
            &[20.0],
            "a row with another heading",
            |rows, _| rows[place][3] = 90.0,
            &["the heading of the car leaps"],
        );
    }
    unchanged_or(
        &[20.0],
        "the last row but one with speed 0",
        |rows, _| {
            let place = rows.len() - 2;
            rows[place][4] = 0.0;
        },
        &["the speed of the car leaps"],
    );
}

#[test]
fn positions_may_be_rounded_or_held() {
    let round = |number: &mut f64, step: f64| *number = (*number / step).round() * step;
    let rounded = |rows: &mut Vec<Row>, _| {
        rows.iter_mut().for_each(|row| [1, 2, 5, 6].map(|place| round(&mut row[place], 0.1)).into_iter().collect());
    };
    unchanged(&[10.0, 20.0, 50.0], "rounded to 0.1 m", rounded);
    // As coarse as a step of the car.
    unchanged_or(&[100.0], "rounded to 0.1 m", rounded, &["positions of the car have a noise"]);
    unchanged(&[50.0, 100.0], "held for 0.1 s", |rows, rate| {
        let held = rows.clone();
        let every = (0.1 * rate) as usize;
        rows.iter_mut()
            .enumerate()
            .for_each(|(number, row)| row[5..].copy_from_slice(&held[number / every * every][5..]));
    });
}

#[test]
fn noise_of_positions_speeds_and_headings_changes_no_class() {
    let mut stream = Seed::root(7).stream();
    for seed in 0..4 {
        for (name, places, deviation) in [
            ("3 cm in all positions", &[1, 2, 5, 6][..], 0.03),
            ("0.1 m/s in speeds", &[4, 8], 0.1),
            ("0.2 m/s in the car's speed", &[4], 0.2),
            ("1 deg in headings", &[3], 1.0),
            ("5 deg in the pedestrian's heading", &[7], 5.0),
        ] {
            unchanged(&[10.0, 20.0, 50.0], &format!("{name}, {seed}"), |rows, _| {
                for row in rows {
                    places.iter().for_each(|place| row[*place] += normal(&mut stream, deviation));
                }
            });
        }
    }
}

#[test]
fn a_time_in_another_unit_is_no_jump() {
    let scenario = crate::case_book::scenario();
    for rate in [5.0, 20.0, 100.0] {
        let mut rows = STANDING.rows(rate);
        rows.iter_mut().for_each(|row| row[0] /= 10.0);
        let found = class(&scenario, &rows, 9);
        assert!(found.starts_with("the car moves 10.00 times as far"), "{rate} Hz: {found}");
        // Three rows have no unit.
        let few = class(&scenario, &rows[..3], 9);
        assert!(rate > 20.0 || few == "no touch", "{rate} Hz: {few}");
    }
}

#[test]
fn a_standing_pedestrian_may_have_noisy_speeds_below_0() {
    let mut stream = Seed::root(11).stream();
    let scenario = crate::case_book::scenario();
    let mut rows = STANDING.rows(50.0);
    rows.iter_mut().for_each(|row| row[8] += normal(&mut stream, 0.2));
    assert!(rows.iter().any(|row| row[8] < -0.5));
    assert_eq!(class(&scenario, &rows, 9), "fault");
    // One who walks along its direction at a negative speed is refused.
    let mut backwards = CROSSING.rows(50.0);
    backwards.iter_mut().for_each(|row| row[8] = -0.9);
    assert!(class(&scenario, &backwards, 9).starts_with("the pedestrian moves at 180 deg from its heading"));
}

#[test]
fn what_follows_the_touch_does_not_matter() {
    let mut stream = Seed::root(8).stream();
    unchanged(&[20.0, 50.0], "the pedestrian is thrown", |rows, rate| {
        for row in rows.iter_mut() {
            (row[5], row[6]) = (row[5] + normal(&mut stream, 0.02), row[6] + normal(&mut stream, 0.02));
        }
        let first = rows.iter().position(|row| row[1] + 2.3 > row[5]).unwrap();
        for place in first..rows.len() {
            let speed = 9.0;
            (rows[place][5], rows[place][6]) = (rows[place - 1][5] + speed / rate, rows[place - 1][6]);
            (rows[place][7], rows[place][8]) = (0.0, speed);
        }
    });
}

#[test]
fn large_coordinates_are_as_good_as_small_ones() {
    unchanged(&[20.0, 100.0], "UTM", |rows, _| {
        for row in rows {
            (row[1], row[2], row[5], row[6]) =
                (row[1] + 461_000.0, row[2] + 5_481_000.0, row[5] + 461_000.0, row[6] + 5_481_000.0);
        }
    });
}

#[test]
fn a_late_beginning_is_no_narrow_escape() {
    let scenario = crate::case_book::scenario();
    let mut told = 0;
    for begin in 50..87 {
        let late = class(&scenario, &STANDING.rows(10.0)[begin..], 9);
        assert!(["fault", "cannot_tell"].contains(&&*late), "row {begin}: {late}");
        told += u32::from(late == "fault");
    }
    assert!((5..35).contains(&told), "{told}");
}

#[test]
fn a_jump_that_nobody_makes_is_told_with_its_row() {
    let scenario = crate::case_book::scenario();
    for rate in [10.0, 20.0, 100.0] {
        for (place, who) in [(6, "pedestrian"), (2, "car")] {
            for columns in WITH_AND_WITHOUT {
                let mut rows = STANDING.rows(rate);
                rows[70][place] += 1.0;
                let found = class(&scenario, &rows, columns);
                let all = judged(&scenario, &rows, columns).unwrap().findings;
                let is_there =
                    |finding: &verdict::Finding| finding.who == who && (finding.first..=finding.last).contains(&70);
                assert!(all.iter().any(is_there), "{rate} Hz, {columns}: {all:?}");
                assert!(rate > 20.0 || found.starts_with("line "), "{rate} Hz, {columns}: {found}");
            }
        }
    }
}

/// A recording of 99,000 rows whose pedestrian stands there all the time, or is never touched.
#[test]
fn a_long_recording_is_judged_at_once() {
    let mut stream = Seed::root(9).stream();
    for (rate, noise, aside) in
        [(20.0, 0.0, 0.0), (20.0, 0.02, 0.0), (1000.0, 0.0, 0.0), (20.0, 0.0, 5.0), (20.0, 0.02, 5.0)]
    {
        let mut rows = STANDING.rows(rate);
        let (first, missing) = (rows[0], 99_000 - rows.len() as u32);
        let earlier = (0..missing).map(|instant| {
            let before = f64::from(missing - instant) / rate;
            [-before, first[1] - 13.0 * before, 0.0, 0.0, 13.0, first[5], first[6], 90.0, 0.0]
        });
        rows.splice(0..0, earlier);
        for row in &mut rows {
            row[6] += aside;
            [1, 2, 5, 6].iter().for_each(|place| row[*place] += normal(&mut stream, noise));
        }
        let begun = std::time::Instant::now();
        let class = class(&crate::case_book::scenario(), &rows, 9);
        assert!(begun.elapsed().as_secs() < 90, "{rate} Hz, {noise} m: {:?}", begun.elapsed());
        assert_eq!(class, if aside > 0.0 { "no touch" } else { "fault" });
    }
}

/// A car that drives into somebody and has speed 0 in the last rows does not stand.
#[test]
fn a_speed_of_0_in_the_last_rows_is_told() {
    let scenario = crate::case_book::scenario();
    for (rate, zeros) in [(10, 2), (20, 2), (20, 3), (50, 3), (50, 5), (100, 6)] {
        let row = |instant: u32| {
            let time = f64::from(instant) / f64::from(rate);
            [time, 8.0 * time, 0.0, 0.0, 8.0, 26.3, -4.2 + 1.4 * time, 90.0, 1.4]
        };
        let mut rows: Vec<Row> = (0..=3 * rate).map(row).collect();
        assert_eq!(class(&scenario, &rows, 9), "fault");
        rows.iter_mut().rev().take(zeros).for_each(|row| row[4] = 0.0);
        let found = class(&scenario, &rows, 9);
        assert!(found.starts_with("line "), "{rate} Hz, {zeros} rows: {found}");
    }
}

/// Columns of a car (3 to 4) or of a pedestrian (7 to 8) that contradict the positions in a part of the recording change verdicts, and are told there.
#[test]
fn a_part_that_contradicts_its_positions_is_told() {
    let scenario = crate::case_book::scenario();
    let row = |instant: u32| {
        let instant = f64::from(instant);
        [0.05 * instant, 0.5 * instant, 0.0, 0.0, 10.0, 32.0, -5.0 + 0.07 * instant, 90.0, 1.4]
    };
    let plain: Vec<Row> = (0..70).map(row).collect();
    let good = class(&scenario, &plain, 9);
    let mut stream = Seed::root(12).stream();
    for (from, column, value, who) in [
        (35, 4, 0.0, "car"),
        (57, 4, 0.0, "car"),
        (45, 4, -10.0, "car"),
        (30, 4, 6.5, "car"),
        (30, 4, 36.0, "car"),
        (40, 3, 90.0, "car"),
        (40, 3, 180.0, "car"),
        (30, 8, 0.0, "pedestrian"),
        (30, 8, 5.0, "pedestrian"),
        (30, 7, 270.0, "pedestrian"),
        (30, 7, 0.0, "pedestrian"),
    ] {
        for noise in [0.0, 0.001, 0.03] {
            let mut rows = plain.clone();
            for row in &mut rows {
                [1, 2, 5, 6].iter().for_each(|place| row[*place] += normal(&mut stream, noise));
            }
            assert_eq!(class(&scenario, &rows, 9), good);
            rows[from..].iter_mut().for_each(|row| row[column] = value);
            let found = class(&scenario, &rows, 9);
            let wanted = format!(" s from here on the {who} moves at ");
            assert!(
                found.starts_with("line ") && found.contains(&wanted),
                "{from}, {column}, {value}, {noise}: {found}"
            );
            let line: usize = found[5..7].parse().unwrap();
            assert!((from - 3..from + 15).contains(&line), "{from}, {column}, {value}, {noise}: {found}");
        }
    }
    // Below the boundary nothing is refused: a speed that is wrong by a fifth, one that is late by 0.3 s, a slip of 15 deg, a drift.
    let accepted = |change: &dyn Fn(usize, &mut Row)| {
        let mut rows = plain.clone();
        rows.iter_mut().enumerate().for_each(|(instant, row)| change(instant, row));
        let found = class(&scenario, &rows, 9);
        assert!(!found.contains("line"), "{found}");
    };
    accepted(&|instant, row| row[4] = if instant < 30 { 10.0 } else { 8.0 });
    accepted(&|instant, row| row[4] = if instant < 30 { 10.0 } else { 12.5 });
    accepted(&|instant, row| row[3] = if instant < 30 { 0.0 } else { 15.0 });
    accepted(&|instant, row| row[5] += if instant < 30 { 0.0 } else { 0.015 * (instant - 30) as f64 });
    for late in [-0.3, 0.3_f64] {
        accepted(&|instant, row| {
            let braked = |time: f64| (time - 1.0).clamp(0.0, 1.25);
            let time = 0.05 * instant as f64;
            row[1] = 10.0 * time - 4.0 * braked(time).powi(2) - 10.0 * (time - 2.25).max(0.0);
            row[4] = 10.0 - 8.0 * braked(time - late);
        });
    }
}

/// Boxes of data sets have the heading of the body, which a walker may turn beside its motion.
#[test]
fn the_heading_of_a_body_may_be_left_out_with_its_speed() {
    let scenario = crate::case_book::scenario();
    for off in [25.0, -25.0, 90.0, 180.0] {
        let mut rows = CROSSING.rows(10.0);
        rows.iter_mut().for_each(|row| row[7] += off);
        let found = class(&scenario, &rows, 9);
        assert!(found.ends_with("leave out speed and heading: they then come from the positions"), "{off}: {found}");
        assert_eq!(class(&scenario, &rows, 7), "fault");
    }
}

#[test]
fn times_in_parts_of_a_second_are_named() {
    let scenario = crate::case_book::scenario();
    for (factor, unit) in [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")] {
        for rate in [2.0, 10.0, 100.0] {
            let mut rows = CROSSING.rows(rate);
            rows.iter_mut().for_each(|row| row[0] *= factor);
            let found = class(&scenario, &rows, 9);
            assert!(
                found.contains(&format!("the times look like {unit}; give 0.001 s to 0.5 s")),
                "{rate} Hz: {found}"
            );
        }
    }
    let mut slow = CROSSING.rows(2.0);
    slow.iter_mut().for_each(|row| row[0] *= 4.0);
    assert!(class(&scenario, &slow, 9).contains("is 2 s; give 0.001 s"), "one frame in two seconds is one");
}

#[test]
fn a_heading_that_is_wrong_from_end_to_end_is_refused() {
    let scenario = crate::case_book::scenario();
    // The whole encounter at 15 deg, and a person who stands clear of the car.
    let turned = |heading: &dyn Fn(f64) -> f64| {
        let mut rows = Encounter { at: 1.6, ..STANDING }.rows(20.0);
        let (sin, cos) = libm::sincos(15.0_f64.to_radians());
        for row in &mut rows {
            for (x, y) in [(1, 2), (5, 6)] {
                (row[x], row[y]) = (row[x] * cos - row[y] * sin, row[x] * sin + row[y] * cos);
            }
            row[3] = heading(15.0);
        }
        rows
    };
    assert_eq!(class(&scenario, &turned(&|degrees| degrees), 7), "no touch");
    let radians = class(&scenario, &turned(&f64::to_radians), 7);
    assert_eq!(
        radians,
        "the car moves at 15 deg from its heading: the numbers look like radians where degrees are needed"
    );
    for off in [-20.0, -4.0, 4.0, 10.0, 20.0] {
        let found = class(&scenario, &turned(&|degrees| degrees + off), 7);
        assert!(
            found.contains(" deg from its heading: it does so from the first instant to the last"),
            "{off}: {found}"
        );
    }
    assert_eq!(class(&scenario, &turned(&|degrees| degrees + 2.0), 7), "no touch");
    // The middle of a car in a bend slips from the first instant to the last.
    let bend = |instant: u32| {
        let turned = f64::from(instant) * 0.025;
        let (sin, cos) = libm::sincos(turned);
        let slip = libm::atan(1.4 / 10.0).to_degrees();
        [
            0.05 * f64::from(instant),
            10.0 * sin,
            10.0 - 10.0 * cos,
            turned.to_degrees() - slip,
            5.0,
            30.0,
            30.0,
            90.0,
            0.0,
        ]
    };
    assert_eq!(class(&scenario, &(0..60).map(bend).collect::<Vec<_>>(), 7), "no touch");
}

#[test]
fn speeds_that_are_wrong_from_end_to_end_are_refused() {
    let scenario = crate::case_book::scenario();
    for (column, who) in [(4, "the car moves "), (8, "the pedestrian moves ")] {
        let is_car = column == 4;
        for (factor, is_refused) in [
            (0.6, true),
            (0.75, true),
            (0.85, is_car),
            (0.97, false),
            (1.03, false),
            (1.2, is_car),
            (1.4, true),
            (1.6, true),
        ] {
            let mut rows = CROSSING.rows(20.0);
            rows.iter_mut().for_each(|row| row[column] *= factor);
            let found = class(&scenario, &rows, 9);
            assert!(if is_refused { found.starts_with(who) } else { found == "fault" }, "{column}, {factor}: {found}");
        }
    }
}

/// Numbers of the pedestrian that are wrong for an instant, or for less than a third of a second, are told with their rows, and none is put right.
#[test]
fn wrong_numbers_of_the_pedestrian_are_told() {
    let scenario = crate::case_book::scenario();
    let told = |encounter: Encounter, columns, rate: f64, lasts: f64, change: &dyn Fn(&mut Row, &Row)| {
        for before in [1.0, 2.0] {
            let mut rows = encounter.rows(rate);
            let first = ((9.0 - before) * rate).round() as usize;
            let end = first + ((lasts * rate).round() as usize).max(1);
            let last_right = rows[first - 1];
            rows[first..end].iter_mut().for_each(|row| change(row, &last_right));
            let found = judged(&scenario, &rows, columns).unwrap();
            let is_there = |finding: &verdict::Finding| {
                finding.who == "pedestrian" && (finding.first, finding.last) == (first, end - 1)
            };
            assert!(found.findings.iter().any(is_there), "{rate} Hz, {columns}: {:?}", found.findings);
            assert!(found.told().is_none(), "{rate} Hz, {columns}");
        }
    };
    for rate in [10.0, 20.0] {
        for lasts in [0.0, 0.2, 0.3] {
            told(JOGGING, 9, rate, lasts, &|row, _| row[8] = 0.0);
            told(JOGGING, 9, rate, lasts, &|row, _| row[7] += 180.0);
            told(JOGGING, 9, rate, lasts, &|row, _| row[7] += 90.0);
        }
        told(CROSSING, 7, rate, 0.3, &|row, last| row[5..7].copy_from_slice(&last[5..7]));
        told(JOGGING, 7, rate, 0.0, &|row, last| row[5..7].copy_from_slice(&last[5..7]));
    }
    for rate in [10.0, 20.0, 50.0] {
        for encounter in [CROSSING, JOGGING] {
            told(encounter, 7, rate, 0.0, &|row, _| row[5] += 0.4);
            told(encounter, 7, rate, 0.0, &|row, _| row[6] -= 0.5);
        }
        told(CROSSING, 9, rate, 0.0, &|row, _| row[5] += 0.4);
    }
}

#[test]
fn positions_that_are_held_are_told() {
    let scenario = crate::case_book::scenario();
    for (rate, every) in [(10.0, 3), (10.0, 5), (10.0, 6), (10.0, 10), (20.0, 10), (25.0, 12), (100.0, 50)] {
        for encounter in [CROSSING, JOGGING] {
            let mut rows = encounter.rows(rate);
            let held = rows.clone();
            rows.iter_mut()
                .enumerate()
                .for_each(|(number, row)| row[5..].copy_from_slice(&held[number / every * every][5..]));
            let found = judged(&scenario, &rows, 7).unwrap();
            let wanted = f64::from(every as u32) / rate;
            let is_held = |finding: &verdict::Finding| matches!(finding.what, verdict::Damage::Held(time) if (time - wanted).abs() < 1e-9);
            assert!(found.findings.iter().any(is_held), "{rate} Hz, {every} rows: {:?}", found.findings);
            assert!(found.told().is_none(), "{rate} Hz, {every} rows");
        }
    }
}

#[test]
fn a_narrow_escape_is_the_same_at_every_rate() {
    let scenario = crate::case_book::scenario();
    for (at, pet, gap) in [(2.0, 0.55, 0.75), (1.5, 0.19, 0.25)] {
        for rate in [5.0, 10.0, 20.0, 100.0] {
            let found = judged(&scenario, &Encounter { at, ..CROSSING }.rows(rate), 9).unwrap();
            let least = found.near_miss.pet.unwrap();
            assert!(
                (least - pet).abs() < 0.03 && (found.least_gap - gap).abs() < 0.02,
                "{rate} Hz: {least}, {found:?}"
            );
        }
    }
}
