//! Encounters that were recorded elsewhere, and their verdicts.

use std::sync::Arc;

use ::episode::Scenario;
use numpy::PyReadonlyArray2;
use numpy::ndarray::{ArrayView1, ArrayView2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use road::geometry::{Obstacles, OrientedBox, Point, Pose};
use verdict::{Encountered, RecordedRequirement, Recording, RecordingError, Reference, Sizes};
use world::sim::{PedestrianState, VehicleState};

use super::episode;

/// Judges the first touch of a car and a pedestrian whose tracks were recorded every `dt` seconds. `ego` has rows of x, y, yaw, speed;
/// `pedestrian` has rows of x, y or of x, y, yaw, speed. `boxes` has rows of x, y, yaw, length, width: the obstacles in the place of the scenario's.
pub fn judged<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    ego: &PyReadonlyArray2<'_, f64>,
    pedestrian: &PyReadonlyArray2<'_, f64>,
    dt: f64,
    sizes: Sizes,
    boxes: Option<&PyReadonlyArray2<'_, f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (ego, pedestrian) = (ego.as_array(), pedestrian.as_array());
    columns("ego", &ego, &[4], "x, y, heading, speed")?;
    columns("pedestrian", &pedestrian, &[2, 4], "x, y or x, y, heading, speed")?;
    let mut scenario = scenario.clone();
    sizes.apply(&mut scenario).map_err(refused)?;
    let obstacles = match boxes {
        Some(boxes) => Arc::new(Obstacles::new(&solids(&boxes.as_array())?)),
        None => scenario.obstacles.clone(),
    };
    let cars = ego.rows().into_iter().map(|row| VehicleState {
        pose: Pose { x: row[0], y: row[1], yaw: row[2] },
        speed: row[3],
        ..VehicleState::default()
    });
    let rows = pedestrian.rows().into_iter();
    let recording = match pedestrian.ncols() {
        2 => {
            let places: Vec<Point> = rows.map(|row| Point::new(row[0], row[1])).collect();
            Recording::of_positions(dt, cars.collect(), &places)
        }
        _ => {
            let state =
                |row: ArrayView1<'_, f64>| PedestrianState::moving(Pose { x: row[0], y: row[1], yaw: row[2] }, row[3]);
            Recording::new(dt, cars.collect(), rows.map(state).collect())
        }
    };
    let recording = recording.map_err(refused)?;
    let found = py.detach(|| recording.judged(&scenario, obstacles));
    dictionary(py, &found, boxes.is_none())
}

/// Names are those of the table of episodes; a number that does not apply is not a number. An episode of ours begins where its danger begins.
fn dictionary<'py>(py: Python<'py>, found: &Encountered, is_ours: bool) -> PyResult<Bound<'py, PyDict>> {
    let is_told = found.undecided.is_none() && (is_ours || found.begins_late.is_none());
    let verdict = found.verdict.as_ref().filter(|_| is_told);
    let dict = PyDict::new(py);
    dict.set_item("touch_s", found.touch.unwrap_or(f64::NAN))?;
    dict.set_item("impact_speed_mps", verdict.map_or(f64::NAN, |verdict| verdict.impact_speed))?;
    episode::verdict_of(&dict, verdict)?;
    if !is_told {
        dict.set_item("verdict", "cannot_tell")?;
    }
    dict.set_item("begins_late_s", found.begins_late.unwrap_or(f64::NAN))?;
    dict.set_item("counts_as", verdict.map_or("", |verdict| verdict.class().name()))?;
    dict.set_item("side", verdict.map_or("", |verdict| verdict.side.name()))?;
    let findings: Vec<String> = found.findings.iter().map(ToString::to_string).collect();
    dict.set_item("findings", findings)?;
    let avoided = PyDict::new(py);
    if let Some(verdict) = verdict {
        for reference in Reference::ALL {
            avoided.set_item(reference.name(), verdict.trial(reference).is_avoided())?;
        }
    }
    dict.set_item("avoided_by", avoided)?;
    let (answers, touch) = (found.answers(), found.touch.unwrap_or(f64::NAN));
    let drivers: Vec<_> = answers.iter().filter(|_| is_told).map(|answer| answer.to_json(touch)).collect();
    let json = py.import("json")?;
    dict.set_item("drivers", json.call_method1("loads", (serde_json::Value::from(drivers).to_string(),))?)?;
    let sensitivity = found.sensitivity();
    dict.set_item("variations", sensitivity.map(|sensitivity| sensitivity.variations))?;
    dict.set_item("avoided_in", sensitivity.map(|sensitivity| sensitivity.avoided))?;
    dict.set_item("least_gap_m", found.least_gap)?;
    dict.set_item("min_ttc_s", found.near_miss.min_ttc.unwrap_or(f64::NAN))?;
    dict.set_item("pet_s", found.near_miss.pet.unwrap_or(f64::NAN))?;
    let requirements = PyDict::new(py);
    for RecordedRequirement { named, degree, verdict } in &found.requirements {
        match degree {
            Some(degree) => requirements.set_item(&*named.name, episode::requirement(py, named, degree, *verdict)?)?,
            None => requirements.set_item(&*named.name, py.None())?,
        }
    }
    dict.set_item("requirements", requirements)?;
    Ok(dict)
}

fn columns(name: &str, array: &ArrayView2<'_, f64>, allowed: &[usize], meaning: &str) -> PyResult<()> {
    let found = array.ncols();
    match allowed.contains(&found) {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!("`{name}` has {found} columns; give {meaning}"))),
    }
}

fn refused(error: RecordingError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

fn solids(boxes: &ArrayView2<'_, f64>) -> PyResult<Vec<OrientedBox>> {
    columns("boxes", boxes, &[5], "x, y, heading, length, width")?;
    let solid = |(number, row): (usize, ArrayView1<'_, f64>)| {
        let is_bad = !row.iter().all(|value| value.abs() <= 1e6) || row[3] <= 0.0 || row[4] <= 0.0;
        if is_bad {
            let text =
                format!("row {number} of `boxes` needs finite numbers up to 1e6, and a length and a width above 0");
            return Err(PyValueError::new_err(text));
        }
        Ok(OrientedBox::new(Pose::new(row[0], row[1], row[2]), row[3] / 2.0, row[4] / 2.0))
    };
    boxes.rows().into_iter().enumerate().map(solid).collect()
}
