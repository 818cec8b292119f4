//! Episodes as Python values: their ends as dictionaries, their ticks as arrays.

use episode::requirement::{Degree, NamedRequirement};
use episode::{Ending, Scenario, Trace};
use numpy::IntoPyArray;
use numpy::ndarray::{Array1, Array2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use verdict::{Verdict, ViolationVerdict};
use world::sim::PedestrianState;

use super::world::End;

/// The end of an episode. Names are those of the table of episodes, with angles in radians; a number that does not apply is not a number.
pub fn end<'py>(py: Python<'py>, end: &End) -> PyResult<Bound<'py, PyDict>> {
    let (outcome, verdict) = (&end.outcome, end.verdict.as_ref());
    let dict = PyDict::new(py);
    let name = match outcome.ending {
        Ending::Touch { moving: true, .. } => "collision",
        Ending::Touch { moving: false, .. } => "bump",
        Ending::OtherContact { .. } => "other_contact",
        Ending::Lost => "lost",
        Ending::Timeout => "timeout",
        Ending::Error(_) | Ending::ControllerError(_) | Ending::WorldError(_) => "error",
    };
    let (front, bearing) = match outcome.ending {
        Ending::Touch { front, bearing, .. } => (front, bearing),
        _ => (false, f64::NAN),
    };
    dict.set_item("seed", end.seed)?;
    dict.set_item("episode_number", end.episode)?;
    dict.set_item("outcome", name)?;
    dict.set_item("is_success", end.is_failure)?;
    dict.set_item("front", front)?;
    dict.set_item("impact_speed_mps", outcome.impact_speed().unwrap_or(f64::NAN))?;
    dict.set_item("impact_bearing_rad", bearing)?;
    verdict_of(&dict, verdict)?;
    dict.set_item("episode_reward", outcome.reward)?;
    dict.set_item("ticks", outcome.ticks)?;
    dict.set_item("episode_length_s", outcome.duration)?;
    dict.set_item("least_gap_m", outcome.least_gap)?;
    dict.set_item("run_up_ticks", outcome.run_up)?;
    dict.set_item("placed", outcome.run_up > 0 && outcome.spawn.ego_speed == 0.0)?;
    dict.set_item("driving_mode", outcome.last_mode.name())?;
    dict.set_item("start", format!("{:016x}", outcome.start))?;
    dict.set_item("digest", format!("{:016x}", outcome.digest))?;
    dict.set_item("error", outcome.error().unwrap_or_default())?;
    if !end.requirements.is_empty() {
        dict.set_item("requirements", requirements(py, end)?)?;
    }
    Ok(dict)
}

/// The requirements of the scenario by their names.
fn requirements<'py>(py: Python<'py>, end: &End) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (named, degree, verdict) in &end.requirements {
        all.set_item(&*named.name, requirement(py, named, degree, *verdict)?)?;
    }
    Ok(all)
}

/// A requirement in an episode: whether it is violated, its robustness (SI units, or scaled), and the number of the sample and the text of the comparison
/// that decide. Of a violation also whether both careful humans satisfy it and whether it is a fault; `None` without a verdict.
pub fn requirement<'py>(
    py: Python<'py>,
    named: &NamedRequirement,
    degree: &Degree,
    verdict: Option<ViolationVerdict>,
) -> PyResult<Bound<'py, PyDict>> {
    let one = PyDict::new(py);
    let part = degree.part.and_then(|part| named.requirement.parts.get(usize::from(part)));
    one.set_item("violated", degree.is_violated())?;
    one.set_item("robustness", degree.robustness)?;
    one.set_item("sample", degree.sample)?;
    one.set_item("part", part.map_or("", |part| &part.text))?;
    one.set_item("preventable", verdict.map(|verdict| verdict.preventable))?;
    one.set_item("fault", verdict.map(|verdict| verdict.fault))?;
    Ok(one)
}

/// Adds a verdict; without a touch it is an empty text.
pub fn verdict_of(dict: &Bound<'_, PyDict>, verdict: Option<&Verdict>) -> PyResult<()> {
    dict.set_item("verdict", verdict.map_or("", |verdict| verdict.label.name()))?;
    dict.set_item("foreseeable", verdict.is_some_and(|verdict| verdict.foreseeable))?;
    dict.set_item("fault", verdict.is_some_and(Verdict::is_fault))?;
    dict.set_item("warning_s", verdict.map_or(f64::NAN, |verdict| verdict.warning))
}

/// An episode from tick to tick; row 0 is the start.
pub fn trace<'py>(py: Python<'py>, scenario: &Scenario, trace: &Trace) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let ego = trace.vehicle(0);
    let column = |of: &dyn Fn(usize) -> f64| (0..ego.len()).map(of).collect::<Array1<f64>>().into_pyarray(py);
    dict.set_item("time_s", column(&|tick| tick as f64 * scenario.episode.tick))?;
    dict.set_item("ego_x_m", column(&|tick| ego[tick].state.pose.x))?;
    dict.set_item("ego_y_m", column(&|tick| ego[tick].state.pose.y))?;
    dict.set_item("ego_yaw_rad", column(&|tick| ego[tick].state.pose.yaw))?;
    dict.set_item("ego_speed_mps", column(&|tick| ego[tick].state.speed))?;
    dict.set_item("throttle", column(&|tick| ego[tick].driven.control.throttle))?;
    dict.set_item("brake", column(&|tick| ego[tick].driven.control.brake))?;
    dict.set_item("steer", column(&|tick| ego[tick].driven.control.steer))?;
    let modes: Vec<&str> = ego.iter().map(|frame| frame.driven.mode.name()).collect();
    dict.set_item("driving_mode", modes)?;
    let walked = |of: fn(&PedestrianState) -> f64| {
        let shape = (ego.len(), trace.pedestrian_count());
        Array2::from_shape_fn(shape, |(tick, pedestrian)| of(&trace.pedestrian(pedestrian)[tick])).into_pyarray(py)
    };
    dict.set_item("pedestrian_x_m", walked(|state| state.pose.x))?;
    dict.set_item("pedestrian_y_m", walked(|state| state.pose.y))?;
    dict.set_item("pedestrian_yaw_rad", walked(|state| state.pose.yaw))?;
    dict.set_item("pedestrian_speed_mps", walked(PedestrianState::speed))?;
    Ok(dict)
}
