//! `falsify judge`: verdicts of recordings in CSV files.

use std::fmt::Write;
use std::path::Path;

use needs::needs;
use proptest::prelude::*;
use verdict::{Recording, Units};

use crate::program::{error, falsify, said};
use crate::reference;

/// A car that drives east at this speed (m/s), and a pedestrian that walks across its axis at 40 m when the car's middle arrives.
fn crossing(speed: f64, walking: f64, dt: f64) -> String {
    let mut text =
        String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps,note\n");
    let arrives = 40.0 / speed;
    for instant in 0..((arrives + 1.0) / dt) as u32 {
        let time = f64::from(instant) * dt;
        let _ = writeln!(text, "{time:.4},40,{},{},0,0,{speed},x", (time - arrives) * walking, speed * time);
    }
    text
}

fn judged(folder: &Path, text: &str, options: &[&str]) -> serde_json::Value {
    std::fs::write(folder.join("trace.csv"), text).unwrap();
    let output = falsify(&[&["judge", "trace.csv", "--json"], options].concat(), folder);
    assert!(output.status.success(), "{}", error(&output));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    found["encounters"][0].clone()
}

#[test]
fn no_output_is_written_onto_the_recording_or_onto_another_output() {
    let folder = tempfile::tempdir().unwrap();
    let text = crossing(8.0, 1.4, 0.05);
    std::fs::write(folder.path().join("trace.csv"), &text).unwrap();
    for outputs in [["--csv", "trace.csv"].as_slice(), &["--page", "./trace.csv"], &["--csv", "a", "--page", "./a"]] {
        let output = falsify(&[&["judge", "trace.csv"], outputs].concat(), folder.path());
        assert_eq!(output.status.code(), Some(2), "{outputs:?}: {}", error(&output));
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("trace.csv")).unwrap(), text);
    assert!(!folder.path().join("a").exists());
}

#[test]
fn a_recording_that_ends_on_the_way_to_a_touch_passes_no_gate() {
    let folder = tempfile::tempdir().unwrap();
    let text: Vec<String> = crossing(8.0, 1.4, 0.05).lines().map(String::from).collect();
    let touch = judged(folder.path(), &text.join("\n"), &[])["touch_s"].as_f64().unwrap();
    let cut = text[..1 + (touch / 0.05) as usize].join("\n");
    assert_eq!(judged(folder.path(), &cut, &[])["verdict"], "cannot_tell");
    let output = falsify(&["judge", "trace.csv", "--fail-if", "preventable > 0"], folder.path());
    assert_eq!(output.status.code(), Some(7), "{}", error(&output));
}

#[test]
fn a_recorded_touch_has_a_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let found = judged(folder.path(), &crossing(8.0, 1.4, 0.05), &[]);
    assert_eq!(found["verdict"], "preventable");
    assert_eq!((&found["foreseeable"], &found["fault"]), (&true.into(), &true.into()));
    assert_eq!(found["avoided_by"]["cc"], true);
    let touch = found["touch_s"].as_f64().unwrap();
    assert!((touch - (40.0 - 2.395) / 8.0).abs() < 0.05, "the bumper is 2.395 m ahead of the middle: {touch} s");
    // A shorter car is later; the rate of the recording does not matter.
    let shorter = judged(folder.path(), &crossing(8.0, 1.4, 0.05), &["--length", "3.0"])["touch_s"].as_f64().unwrap();
    assert!((shorter - touch - 0.895 / 8.0).abs() < 0.02, "{touch} s, {shorter} s");
    let slow = judged(folder.path(), &crossing(8.0, 1.4, 0.1), &[]);
    assert_eq!(slow["verdict"], "preventable");
    assert!((slow["touch_s"].as_f64().unwrap() - touch).abs() < 1e-3);
    let far: Vec<String> = crossing(8.0, 1.4, 0.05).lines().map(|line| line.replacen(",40,", ",400,", 1)).collect();
    let missed = judged(folder.path(), &far.join("\n"), &[]);
    assert!(missed["verdict"].is_null() && missed["touch_s"].is_null(), "{missed}");

    let output = falsify(&["judge", "trace.csv"], folder.path());
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("no touch; the least distance is "), "{output:?}");
    std::fs::write(folder.path().join("trace.csv"), crossing(8.0, 1.4, 0.05)).unwrap();
    let output = falsify(&["judge", "trace.csv"], folder.path());
    let text = said(&output).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains(
            "verdict: preventable counts as fault: it counts against the driver, since every careful driver avoids it"
        ),
        "{text}"
    );
}

/// A pedestrian 4 m beside the axis of a car at 50 km/h who sets off at 1.4 m/s when its front is this far away (m).
fn steps_out(ahead: f64, dt: f64) -> String {
    let mut text = String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps\n");
    let (speed, starts) = (50.0 / 3.6, 4.0);
    for instant in 0..(10.0 / dt) as u32 {
        let time = f64::from(instant) * dt;
        let walked = 1.4 * (time - starts).max(0.0);
        let _ = writeln!(
            text,
            "{time:.4},0,{:.4},{:.4},0,0,{speed}",
            walked - 4.0,
            speed * (time - starts) - ahead - 2.395
        );
    }
    text
}

#[test]
fn a_motion_has_one_verdict_however_often_it_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    for (ahead, steps) in [(39.0, &[0.01, 0.05, 0.1, 0.2, 0.25][..]), (50.0, &[0.02, 0.05, 0.1, 0.25, 0.4, 0.5])] {
        for dt in steps {
            let found = judged(folder.path(), &steps_out(ahead, *dt), &[]);
            assert_eq!(found["counts_as"], "fault", "{ahead} m, {dt} s: {found}");
        }
    }
    let early: Vec<String> = steps_out(39.0, 0.05).lines().take(132).map(String::from).collect();
    let found = judged(folder.path(), &early.join("\n"), &[]);
    assert!(found["touch_s"].is_null() && (0.1..1.0).contains(&found["ends_before_s"].as_f64().unwrap()), "{found}");
    let output = falsify(&["judge", "trace.csv"], folder.path());
    assert!(String::from_utf8_lossy(&output.stdout).contains("before a touch, if both go on"), "{output:?}");
}

/// Euro NCAP's running adult: 8 km/h within 1.5 m, which are the bounds of a foreseeable pedestrian. Its positions deviate by up to `noise` (m).
fn runs_into_the_way(noise: f64, dt: f64) -> String {
    let mut text = String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps\n");
    let (speed, car) = (8.0 / 3.6, 13.9);
    let acceleration = speed * speed / 3.0;
    let gains = speed / acceleration;
    let begins = 6.0 - gains - 4.5 / speed;
    for instant in 0..(6.5 / dt) as u32 {
        let time = f64::from(instant) * dt;
        let since = (time - begins).max(0.0);
        let gained = since.min(gains);
        let way = acceleration * gained * gained / 2.0 + speed * (since - gained);
        let deviates = |by: f64| noise * (2.0 * (libm::sin(f64::from(instant) * by) * 43758.5).rem_euclid(1.0) - 1.0);
        let (x, y) = (2.4 + deviates(78.2), way - 6.0 + deviates(12.9));
        let _ = writeln!(text, "{time:.4},{x},{y},{},0,0,{car}", car * (time - 6.0));
    }
    text
}

#[test]
fn a_car_that_reverses_touches_with_its_rear() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps\n");
    for instant in 0..100 {
        let time = f64::from(instant) * 0.05;
        let _ = writeln!(text, "{time:.2},-10,0,{},0,0,-3", -3.0 * time);
    }
    assert_eq!(judged(folder.path(), &text, &[])["side"], "rear");
}

/// A car that drives on at 3 m/s, and a pedestrian that comes from the left at 1.7 m/s and touches the corner of its rear, which has just passed.
#[test]
fn who_walks_into_the_rear_of_a_car_that_passes_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps\n");
    // The radius of the pedestrian and half the width of the car.
    let beside = 0.188 + 1.08;
    for instant in 0..160 {
        let time = f64::from(instant) * 0.05 - 6.0;
        let _ = writeln!(text, "{:.2},0,{},{},0,0,3", time + 6.0, beside + 0.02 - 1.7 * time, 2.395 + 3.0 * time);
    }
    let found = judged(folder.path(), &text, &[]);
    assert_eq!((&found["side"], &found["counts_as"]), (&"rear".into(), &"flank".into()), "{found}");
}

#[test]
fn a_car_that_brakes_better_is_compared_with_careful_humans_who_do() {
    let folder = tempfile::tempdir().unwrap();
    // At 50 km/h, a pedestrian sets off 2.45 s before the touch.
    let mut text = String::from("time_s,pedestrian_x_m,pedestrian_y_m,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps\n");
    let (speed, walking, before) = (13.889, 1.389, 2.45);
    for instant in 0..140 {
        let time = f64::from(instant) * 0.05 - 6.0;
        let y = walking * ((time + before).max(0.0) - before);
        let _ = writeln!(text, "{:.2},2.6,{y},{},0,0,{speed}", time + 6.0, speed * time);
    }
    let [worse, better] = ["7.01", "8"].map(|brake| judged(folder.path(), &text, &["--full-brake", brake]));
    assert_eq!((&worse["full_brake_mps2"], &worse["avoided_by"]["cc"]), (&7.01.into(), &false.into()));
    assert_eq!(better["avoided_by"]["cc"], true);
    let output = falsify(&["judge", "trace.csv", "--full-brake", "-1"], folder.path());
    assert!(!output.status.success(), "{output:?}");
    let text = falsify(&["judge", "trace.csv", "--width", "1.8"], folder.path());
    let said = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(said.contains("assumed: a car of 4.79 m by 1.80 m that brakes with at most 7.01 m/s^2"), "{said}");
}

#[test]
fn noise_makes_no_runner_of_the_fastest_pedestrian() {
    let folder = tempfile::tempdir().unwrap();
    for dt in [0.05, 0.1] {
        for noise in [0.0, 1e-6, 1e-3, 0.01, 0.03] {
            let found = judged(folder.path(), &runs_into_the_way(noise, dt), &[]);
            assert_eq!(found["counts_as"], "fault", "{noise} m every {dt} s: {found}");
        }
    }
}

#[test]
fn a_recording_that_begins_too_late_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let whole = crossing(14.0, 0.0, 0.05);
    assert_eq!(judged(folder.path(), &whole, &[])["counts_as"], "fault");
    // A person stands in the lane, and the recording begins a second before the touch.
    let rows: Vec<&str> = whole.lines().collect();
    let late = [&rows[..1], &rows[35..]].concat().join("\n");
    let found = judged(folder.path(), &late, &[]);
    assert_eq!(found["verdict"], "cannot_tell", "{found}");
    assert!(found["fault"].is_null() && found["counts_as"].is_null() && found["foreseeable"].is_null(), "{found}");
    // The gate of the careful human opens at 1.75 s + v/2a, with the brake of the car.
    let (missing, begins) = (found["begins_late_s"].as_f64().unwrap(), found["touch_s"].as_f64().unwrap());
    assert!((missing + begins - (1.75 + 14.0 / (2.0 * 7.01))).abs() < 0.02, "{found}");
    let output = falsify(&["judge", "trace.csv"], folder.path());
    let text = String::from_utf8_lossy(&output.stdout).replace("\n  ", " ");
    assert!(
        text.contains(
            "verdict: cannot tell. The danger was under way when the recording begins; give at least 1.8 s more"
        ),
        "{text}"
    );
}

#[test]
fn a_file_that_is_no_recording_is_an_error_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let good = crossing(8.0, 1.4, 0.05);
    let rows: Vec<&str> = good.lines().collect();
    let changed = |line: usize, row: &str| {
        let mut rows = rows.clone();
        rows[line - 1] = row;
        rows.join("\n")
    };
    for (text, wanted) in [
        (String::new(), "there is no column `time_s`"),
        (good.replace("ego_yaw_deg", "yaw"), "there is no column `ego_yaw_deg`; there is time_s, "),
        (good.replace("note", "pedestrian_speed_mps"), "there is no column `pedestrian_yaw_deg`"),
        (changed(5, "0.15,40"), "line 5: there are 2 fields; the header has 8"),
        (changed(5, "0.15,40,-6,fast,0,0,8,x"), "line 5, column `ego_x_m`: `fast` is not a number"),
        (
            changed(5, "0.19,40,-6,1.2,0,0,8,x"),
            "line 5: the time is 0.19 s, 0.09 s after the row before; the others are 0.05 s apart",
        ),
        (changed(5, "0.15,40,-6,NaN,0,0,8,x"), "line 5: the x of the car (m) is NaN"),
        (changed(5, "0.15,40,-6,1.2,0,0,-800,x"), "line 5: the speed of the car (m/s) is -800; give -150 to 150"),
        (
            rows[..5].iter().chain(&rows[6..]).copied().collect::<Vec<_>>().join("\n"),
            "line 6: the time is 0.25 s, 0.1 s after the row before",
        ),
        (changed(6, rows[4]), "line 6: the time is 0.15 s, as in the row before"),
        (good.replace("note", "ego_speed_mps"), "the column `ego_speed_mps` is there twice; give one"),
        (good.replace(",0,0,8,x", ",0,180,8,x"), "the car moves at 180 deg from its heading"),
        (good.replace(",0,0,8,x", ",0,0,0,x"), "the car moves farther than its speed"),
        (
            good.replace("note", "pedestrian_speed_mps,pedestrian_yaw_deg").replace(",x", ",-1.4,90"),
            "line 2: `pedestrian_speed_mps` is -1.4; it is a speed in the direction of motion",
        ),
        (
            format!("{}\n{}", rows[0], vec![rows[1]; 100_001].join("\n")),
            "there are more than 100000 rows; cut the recording",
        ),
        (rows.join("\r"), "the lines end with a carriage return alone; give line feeds"),
        (good.replace(',', ";"), "the fields are separated by `;`; give `,` between fields, and decimal points"),
        (good.replacen("time_s", "\u{201c}time_s\u{201d}", 1), "the names are in typographic quotes"),
        (changed(5, "0,15,40,0,-6,5,1,2,0,0,0,0,8,0,x"), "there are 15 fields; the header has 8. Give decimal points"),
        (rows[..2].join("\n"), "there are 1 instants of the car and 1 of the pedestrian"),
        (crossing(8.0, 1.4, 1.0), "the time between two instants is 1 s"),
        (good.replace(",0,0,8,x", ",0,0,28.8,x"), "the car moves 0.28 times as far as its speed"),
        (good.replace(",0,0,8,x", ",0,0,28.8,x"), "the speeds look like km/h; give m/s (`--speed-unit km/h`)"),
    ] {
        std::fs::write(folder.path().join("trace.csv"), text).unwrap();
        let output = falsify(&["judge", "trace.csv"], folder.path());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(error(&output).starts_with("error: cannot judge `trace.csv`: "), "{}", error(&output));
        assert!(error(&output).contains(wanted), "{wanted}: {}", error(&output));
    }
    let output = falsify(&["judge", "nowhere.csv"], folder.path());
    assert_eq!(error(&output), "error: cannot judge `nowhere.csv`: there is no such file\n");
    std::fs::write(folder.path().join("trace.csv"), &good).unwrap();
    let output = falsify(&["judge", "trace.csv", "--width", "0"], folder.path());
    assert!(
        output.status.code() == Some(2) && error(&output).contains("`width` is 0; give 0.1 to 100 m"),
        "{output:?}"
    );
}

/// Recordings of the reference folder are read, and refused with a speed, a time or a heading in another unit.
#[needs(reference = "reference/next/ticks .csv")]
#[test]
fn recordings_of_the_reference_folder_have_units_that_fit() {
    let folder = reference::folder().join("reference/next");
    let files = std::fs::read_dir(&folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut read = 0;
    for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "csv")) {
        let text = std::fs::read_to_string(&file).unwrap();
        if !text.lines().next().is_some_and(|header| header.contains("ego_yaw_deg")) {
            continue;
        }
        Recording::from_csv(&text, &Units::default()).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let wrong = |column: &str, change: fn(f64) -> f64| {
            let place =
                text.lines().next().and_then(|header| header.split(',').position(|name| name == column)).unwrap();
            let line = |(number, line): (usize, &str)| {
                let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
                if number > 0 {
                    fields[place] = change(fields[place].parse().unwrap()).to_string();
                }
                fields.join(",")
            };
            let changed: Vec<String> = text.lines().enumerate().map(line).collect();
            Recording::from_csv(&changed.join("\n"), &Units::default()).unwrap_err().to_string()
        };
        assert!(wrong("ego_speed_mps", |speed| 3.6 * speed).contains("the speeds look like km/h"));
        let hasty = wrong("time_s", |time| time / 10.0);
        assert!(hasty.contains("s after the one before"), "{hasty}");
        assert!(wrong("ego_yaw_deg", |_| 90.0).contains("the car moves at"));
        read += 1;
    }
    assert!(read > 0, "no recording in {} has headings of the ego", folder.display());
}

proptest! {
    #[test]
    fn any_text_is_a_recording_or_an_error_that_names_its_place(rows in "([-0-9.,eNainf\" ]{0,40}\n){0,6}", header in any::<bool>()) {
        let names = "time_s,ego_x_m,ego_y_m,ego_yaw_deg,ego_speed_mps,pedestrian_x_m,pedestrian_y_m\n";
        let text = if header { format!("{names}{rows}") } else { rows };
        if let Err(error) = Recording::from_csv(&text, &Units::default()) {
            let text = error.to_string();
            let names_a_place = ["line ", "column ", "instant"].iter().any(|word| text.contains(word));
            prop_assert!(names_a_place || text.contains("between two instants"), "{}", text);
        }
    }
}

/// Damage is told with its line, and what rests on it has no verdict; what lies elsewhere changes nothing.
#[test]
fn damage_is_told_with_its_line_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let good = crossing(8.0, 1.4, 0.05);
    let rows: Vec<&str> = good.lines().collect();
    let halted = |from: usize| {
        let row = |(place, row): (usize, &&str)| match place < from {
            true => (*row).to_owned(),
            false => row.replace(",8,x", ",0,x"),
        };
        rows.iter().enumerate().map(row).collect::<Vec<_>>().join("\n")
    };
    let mut jumped = rows.clone();
    jumped[4] = "0.15,40,-6,9000,0,0,8,x";
    for (text, wanted, told) in [
        (halted(60), "line 61 to 121: in 0.05 s from here on the car moves at 8.0 m/s", "cannot_tell"),
        (jumped.join("\n"), "line 5: the car has moved 89", "cannot_tell"),
        (halted(110), " s from here on the car moves at 8.0 m/s", "preventable"),
    ] {
        let found = judged(folder.path(), &text, &[]);
        assert!(found["findings"].to_string().contains(wanted), "{wanted}: {found}");
        assert_eq!(found["verdict"], told, "{found}");
        let output = falsify(&["judge", "trace.csv"], folder.path());
        assert!(said(&output).contains("found: line "), "{output:?}");
        // What cannot be judged fails a gate about verdicts.
        let gate = ["judge", "trace.csv", "--fail-if", "faults > 5"];
        let codes = [&gate[..], &[&gate[..], &["--allow-unjudged"]].concat()]
            .map(|words| falsify(words, folder.path()).status.code().unwrap());
        assert_eq!(codes, if told == "cannot_tell" { [7, 0] } else { [0, 0] });
    }
    // The option that a refusal names makes the recording that of before.
    for (text, options) in [
        (good.replace(",0,0,8,x", ",0,0,28.8,x"), ["--speed-unit", "km/h"]),
        (good.replace(",0,0,8,x", ",0,90,8,x"), ["--heading-unit", "compass"]),
    ] {
        assert_eq!(judged(folder.path(), &text, &options)["verdict"], "preventable");
    }
}

/// Drivers of others come with their sources, triggers and times; those of ours are not counted.
#[test]
fn a_touch_has_a_table_of_published_drivers() {
    let folder = tempfile::tempdir().unwrap();
    let found = judged(folder.path(), &crossing(8.0, 1.4, 0.05), &[]);
    let drivers = found["drivers"].as_array().unwrap();
    let named = |name: &str| drivers.iter().find(|driver| driver["driver"] == name).unwrap();
    let touch = found["touch_s"].as_f64().unwrap();
    for driver in drivers {
        let [trigger, brake] = ["trigger_s", "brake_s"].map(|key| driver[key].as_f64());
        assert!(trigger.is_none_or(|time| time <= touch) && brake.is_none_or(|time| Some(time) >= trigger), "{driver}");
        assert_eq!(driver["avoids"] == true, driver["impact_mps"].is_null(), "{driver}");
        assert_eq!(driver["avoids"] == true, driver["spare_m"].is_number(), "{driver}");
    }
    for (name, avoids) in found["avoided_by"].as_object().unwrap() {
        assert_eq!(named(name)["avoids"], *avoids, "{name}: one driver has one answer");
    }
    assert!(named("rss_free")["source"] == "ad-rss, CARLA" && named("cc")["published"] == false);
    let count = |of: &dyn Fn(&serde_json::Value) -> bool| drivers.iter().filter(|driver| of(driver)).count();
    // Drivers whose trigger fails a clause on pedestrians of their own source are shown, and so are ours.
    let without = ["r157_cc", "r157_cc_lane", "esmini", "cc", "cc_attentive", "rss_straight", "ideal", "bound"];
    for driver in drivers {
        assert_eq!(driver["votes"] == true, !without.contains(&driver["driver"].as_str().unwrap()), "{driver}");
    }
    let votes = count(&|driver| driver["votes"] == true);
    let avoid = count(&|driver| driver["votes"] == true && driver["avoids"] == true);
    let text = said(&falsify(&["judge", "trace.csv", "--csv", "all.csv"], folder.path()));
    assert!(text.contains(&format!("{avoid} of {votes} published drivers avoid it")), "{text}");
    let table = std::fs::read_to_string(folder.path().join("all.csv")).unwrap();
    assert!(table.contains("votes_avoid,votes,") && table.contains(&format!(",{avoid},{votes},")), "{table}");
    let [variations, avoided] = ["variations", "avoided_in"].map(|key| found[key].as_u64().unwrap());
    assert!(variations > 900 && avoided > variations / 2 && avoided < variations, "{avoided} of {variations}");
}

#[test]
fn a_gate_a_page_and_a_table_come_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("trace.csv"), crossing(8.0, 1.4, 0.05)).unwrap();
    for (condition, code) in [("preventable > 0", 7), ("faults > 1", 0), ("cannot_tell > 0", 0), ("blame > 0", 2)] {
        let output = falsify(&["judge", "trace.csv", "--fail-if", condition], folder.path());
        assert_eq!(output.status.code(), Some(code), "{condition}: {output:?}");
    }
    let output = falsify(&["judge", "trace.csv", "--page", "page.html", "--csv", "all.csv"], folder.path());
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("data-replay") && page.contains("r152_aeb") && page.contains("published drivers avoid it"));
    let table = std::fs::read_to_string(folder.path().join("all.csv")).unwrap();
    assert!(table.starts_with("car,pedestrian,touch_s,verdict,") && table.contains("\nego,pedestrian,"), "{table}");
}

/// Traces that others wrote have the verdict of the episode that they were made of, in both forms of the standard.
#[needs(reference = "reference/next/osi .osi")]
#[test]
fn traces_of_the_reference_folder_are_judged() {
    let folder = reference::folder().join("reference/next/osi");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if !path.to_string_lossy().contains("_gt_") {
            continue;
        }
        let output = falsify(&["judge", path.to_str().unwrap(), "--json"], &folder);
        assert!(output.status.success(), "{}", error(&output));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(json["encounters"][0]["touch_s"].is_number(), "{json}");
        found.push(json);
        // A part of it is no trace.
        let bytes = std::fs::read(&path).unwrap();
        let cut = tempfile::tempdir().unwrap();
        let name = path.file_name().unwrap();
        std::fs::write(cut.path().join(name), &bytes[..bytes.len() / 2]).unwrap();
        let output = falsify(&["judge", name.to_str().unwrap()], cut.path());
        assert!(output.status.code() == Some(2) && error(&output).contains("cannot judge"), "{output:?}");
    }
    assert!(found.len() > 1 && found.windows(2).all(|pair| pair[0] == pair[1]), "{found:?}");
}

/// An episode of ours that is exported has the verdict of the report.
#[test]
fn an_exported_episode_has_its_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
import "std/paper.scn"
campaign rt {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  drivers: [blind, behavior]  pedestrians: [intercept]  episodes: 12 }
}
"#;
    std::fs::write(folder.path().join("rt.scn"), scenario).unwrap();
    let output = falsify(&["run", "rt.scn"], folder.path());
    assert!(output.status.success(), "{}", error(&output));
    let names = said(&falsify(&["failures", "--names"], folder.path()));
    let mut asked = 0;
    for (place, name) in names.lines().enumerate() {
        let json = |output: std::process::Output| -> serde_json::Value {
            assert!(output.status.success(), "{name}: {}", error(&output));
            serde_json::from_slice(&output.stdout).unwrap()
        };
        let replayed = json(falsify(&["replay", name, "--json"], folder.path()));
        let out = folder.path().join(place.to_string());
        let output = falsify(&["export", name, "--as", "osi", "--out", out.to_str().unwrap()], folder.path());
        assert!(output.status.success(), "{name}: {}", error(&output));
        let files = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
        let trace = files.into_iter().find(|path| path.extension().is_some_and(|end| end == "mcap")).unwrap();
        let found = json(falsify(&["judge", trace.to_str().unwrap(), "--json"], folder.path()));
        let encounter = &found["encounters"][0];
        assert!(encounter["verdict"] == replayed["verdict"], "{name}: {encounter}, {replayed}");
        asked += 1;
    }
    assert!(asked > 3, "{names}");
}

/// The bytes of a field of protobuf: a number, or a part.
fn field(number: u8, inner: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2, u8::try_from(inner.len()).unwrap()], inner].concat()
}

fn triple(number: u8, numbers: [f64; 3]) -> Vec<u8> {
    let each = |(place, number): (usize, f64)| [&[(place as u8 + 1) << 3 | 1][..], &number.to_le_bytes()].concat();
    field(number, &numbers.into_iter().enumerate().flat_map(each).collect::<Vec<u8>>())
}

/// A trace of OSI of a car at 8 m/s and pedestrians who cross its way: of one the velocities contradict the positions.
fn trace() -> Vec<u8> {
    let mut bytes = Vec::new();
    for instant in 0..140_u8 {
        let time = f64::from(instant) * 0.05;
        let object = |id: u8, kind: u8, size: [f64; 3], place: [f64; 3], velocity: [f64; 3]| {
            let base = [triple(1, size), triple(2, place), triple(3, [0.0; 3]), triple(4, velocity)].concat();
            field(5, &[field(1, &[8, id]), field(2, &base), vec![24, kind]].concat())
        };
        let body = [0.4, 0.4, 1.7];
        let y = 1.4 * (time - 6.0);
        let nanos = u64::from(instant) * 50_000_000;
        let mut stamp = vec![8, (nanos / 1_000_000_000) as u8, 16];
        let mut rest = nanos % 1_000_000_000;
        while rest > 127 {
            stamp.push((rest & 127) as u8 | 128);
            rest >>= 7;
        }
        stamp.push(rest as u8);
        let message = [
            field(2, &stamp),
            object(1, 2, [4.8, 2.0, 1.5], [8.0 * (time - 6.0) - 2.4, 0.0, 0.0], [8.0, 0.0, 0.0]),
            object(2, 3, body, [0.2, y, 0.0], [0.0, 1.4, 0.0]),
            object(3, 3, body, [0.3, y, 0.0], [0.0, 5.04, 0.0]),
        ]
        .concat();
        bytes.extend((message.len() as u32).to_le_bytes());
        bytes.extend(message);
    }
    bytes
}

/// A pair that cannot be judged is told with its reason; the others are judged, and a gate about verdicts fails.
#[test]
fn a_pair_that_cannot_be_judged_hinders_no_other() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("drive.osi"), trace()).unwrap();
    let judge = ["judge", "drive.osi"];
    let json = falsify(&[&judge[..], &["--json", "--csv", "all.csv"]].concat(), folder.path());
    let found: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let [judged, unjudged] = ["encounters", "unjudged"].map(|key| found[key].as_array().unwrap());
    assert!(judged.len() == 1 && judged[0]["pedestrian"] == "2" && judged[0]["verdict"] == "preventable", "{found}");
    assert!(unjudged.len() == 1 && unjudged[0]["pedestrian"] == "3", "{found}");
    assert!(unjudged[0]["reason"].as_str().unwrap().contains("the pedestrian moves 0.28 times as far"), "{found}");
    let table = std::fs::read_to_string(folder.path().join("all.csv")).unwrap();
    assert!(table.contains("\n1,3,,not judged,"), "{table}");
    let text = said(&falsify(&judge, folder.path()));
    assert!(text.contains("car 1, pedestrian 3 cannot be judged: the pedestrian moves"), "{text}");
    let gate = [&judge[..], &["--fail-if", "faults > 5"]].concat();
    let open = [&gate[..], &["--allow-unjudged"]].concat();
    assert_eq!([gate, open].map(|words| falsify(&words, folder.path()).status.code().unwrap()), [7, 0]);
    // What the option takes from the positions is judged.
    let without = falsify(&[&judge[..], &["--no-velocity", "--json"]].concat(), folder.path());
    let found: serde_json::Value = serde_json::from_slice(&without.stdout).unwrap();
    assert!(
        found["encounters"].as_array().unwrap().len() == 2 && found["unjudged"] == serde_json::json!([]),
        "{found}"
    );
}

/// A record of MCAP.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// A chunk with this compression, and this many bytes before it was compressed.
fn chunk(compression: &str, size: u64, data: &[u8]) -> Vec<u8> {
    let name = [&(compression.len() as u32).to_le_bytes(), compression.as_bytes()].concat();
    let head = [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &name, &(data.len() as u64).to_le_bytes()].concat();
    record(6, &[&head, data].concat())
}

/// A frame of zstd with these bytes and then as many blocks of 128 KiB of zeros.
fn zeros_after(first: &[u8], blocks: usize) -> Vec<u8> {
    let block = |kind: u32, size: u32, last: u32| (size << 3 | kind << 1 | last).to_le_bytes()[..3].to_vec();
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0, 0x38];
    frame.extend([block(0, first.len() as u32, 0), first.to_vec()].concat());
    for number in 1..=blocks {
        frame.extend([block(1, 1 << 17, u32::from(number == blocks)), vec![0]].concat());
    }
    frame
}

/// A damaged container ends as a clear error, within a gigabyte.
#[test]
fn a_damaged_container_is_an_error_within_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let magic = b"\x89MCAP0\r\n";
    let gigabytes: u64 = 3 << 30;
    let huge = |opcode: u8, length: u64| [&[opcode][..], &length.to_le_bytes()].concat();
    let bomb = |length: u64| zeros_after(&huge(0x80, length), 24 << 10);
    let mut open = chunk("", 29, &record(0x80, &[0; 20]));
    // The length of what it holds.
    open[41] = 9;
    let empty = [&(16_u32 << 20).to_le_bytes()[..], &[0x2a, 0].repeat(8 << 20)].concat();
    for (name, bytes, wanted) in [
        ("a record of gigabytes", chunk("zstd", gigabytes, &bomb(gigabytes - 9)), "exceeds limit"),
        ("a record of 2^60", chunk("zstd", 1 << 20, &bomb(1 << 60)), "exceeds limit"),
        ("a chunk of terabytes", chunk("zstd", 5 << 40, &bomb(9)), "cut the recording"),
        ("a chunk with a lying size", chunk("zstd", 4, &bomb(9)), "damaged MCAP"),
        ("an open chunk with a lying size", chunk("", 9, &huge(0x80, 1 << 40)), "damaged MCAP"),
        ("an open chunk that ends within a record", open, "a chunk ends within a record"),
        ("a chunk that ends beyond the file", chunk("lz4", 9, &[4; 30])[..40].to_vec(), "damaged MCAP"),
        ("a file of 2^60", huge(6, 1 << 60), "damaged MCAP"),
        ("another compression", chunk("xz", 9, &[1; 9]), "xz"),
        ("osi: a message of gigabytes", vec![255, 255, 255, 127, 1], "is cut"),
        ("osi: a message of empty objects", empty, "8388608 objects"),
    ] {
        let is_osi = name.starts_with("osi");
        let path = folder.path().join(if is_osi { "drive.osi" } else { "drive.mcap" });
        let whole =
            [&magic[..], &record(1, &[0; 8]), &bytes, &record(15, &[0; 4]), &record(2, &[0; 20]), magic].concat();
        std::fs::write(&path, if is_osi { bytes } else { whole }).unwrap();
        let command = format!("ulimit -v 1500000; exec '{}' judge '{}'", env!("CARGO_BIN_EXE_falsify"), path.display());
        let output = std::process::Command::new("sh").args(["-c", &command]).output().unwrap();
        let said = error(&output);
        assert!(output.status.code() == Some(2) && said.contains("cannot judge"), "{name}: {output:?}");
        assert!(said.replace("\n  ", " ").contains(wanted), "{name}: {said}");
    }
}
