//! Worlds that are stepped together, with arrays in and out.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use ::episode::walker::{network_differs, network_fits};
use ::episode::{Cast, Scenario};
use numpy::ndarray::{Array1, Array2, Array3, ArrayView2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use verdict::Label;
use world::sim::WalkCommand;

use super::driver::Raised;
use super::episode;
use super::scenarios::Choice;
use super::top_view;
use super::world::World;

/// The greatest number of an episode: what a floating-point number holds exactly.
const MOST_EPISODES: u64 = 1 << 53;
/// The most worlds.
const MOST_WORLDS: usize = 1 << 20;

/// When a world whose episode is over starts the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Autoreset {
    /// When it is reset.
    Never,
    /// In the next step, whose action is ignored.
    NextStep,
    /// In the same step.
    SameStep,
    /// When it is reset; until then steps leave it as it is.
    Rest,
}

/// What a step returns: states, rewards, terminated, truncated, and with `same_step` the last states of episodes that ended.
type Stepped<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Option<Bound<'py, PyArray2<f32>>>,
);

/// An action array, in either precision.
#[derive(FromPyObject)]
enum Actions<'py> {
    Single(PyReadonlyArray2<'py, f32>),
    Double(PyReadonlyArray2<'py, f64>),
}

/// A pedestrian that actions control: its name, whether its states are scaled to order one, and bounds of numbers of its state.
type Agent = (String, bool, Vec<(f64, f64)>);

/// Worlds of one scenario. Each has its own seed and its own sequence of episodes.
#[pyclass(module = "falsify_av._core")]
pub struct Worlds {
    scenario: Arc<Scenario>,
    names: [String; 4],
    // One lock for all: a call has the worlds to itself, whatever thread it is from.
    worlds: Mutex<Vec<World>>,
    /// What a driver in Python has raised.
    raised: Raised,
}

impl Worlds {
    /// Worlds before their first episodes; world *i* has the seed `seed + i`.
    pub fn new(choice: &Choice, count: usize, seed: u64, raised: Raised) -> PyResult<Self> {
        if count == 0 || count > MOST_WORLDS {
            return Err(PyValueError::new_err(format!("the number of worlds is {count}; give 1 to {MOST_WORLDS}")));
        }
        let scenario = &choice.scenario;
        let seeds = (0..count as u64).map(|world| seed.wrapping_add(world));
        let worlds = seeds.map(|seed| World::new(scenario, &choice.starts, seed)).collect();
        let names = [&choice.campaign, &choice.town, &choice.policy, &choice.reward].map(String::clone);
        Ok(Self { scenario: scenario.clone(), names, worlds: Mutex::new(worlds), raised })
    }

    /// The worlds. A panic of an earlier call leaves them as they are.
    fn worlds(&mut self) -> &mut Vec<World> {
        self.worlds.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn world(&mut self, index: usize) -> PyResult<&mut World> {
        let worlds = self.worlds();
        let count = worlds.len();
        worlds
            .get_mut(index)
            .ok_or_else(|| PyValueError::new_err(format!("there is no world {index}; there are {count}")))
    }
}

/// Calls a function for each world, on all cores when there are several worlds.
fn each(worlds: &mut [World], act: impl Fn(usize, &mut World) + Send + Sync) {
    match worlds {
        [alone] => act(0, alone),
        worlds => worlds.par_iter_mut().enumerate().for_each(|(index, world)| act(index, world)),
    }
}

fn states(worlds: &[World], of: impl Fn(&World) -> &[f64]) -> Array2<f32> {
    let width = worlds.first().map_or(0, |world| of(world).len());
    let mut states = Vec::with_capacity(worlds.len() * width);
    states.extend(worlds.iter().flat_map(of).map(|number| *number as f32));
    Array2::from_shape_vec((worlds.len(), width), states).expect("all states have one length")
}

#[pymethods]
impl Worlds {
    /// The number of worlds.
    fn __len__(&mut self) -> usize {
        self.worlds().len()
    }

    /// Names of the campaign, the town, the driver and the reward.
    #[getter]
    fn names(&self) -> (&str, &str, &str, &str) {
        let [campaign, town, policy, reward] = &self.names;
        (campaign, town, policy, reward)
    }

    /// The number of pedestrians that actions control.
    #[getter]
    fn pedestrians(&self) -> usize {
        self.scenario.cast.controlled().count()
    }

    /// Length of a tick (s), ticks of a decision, and most ticks of an episode.
    #[getter]
    fn timing(&self) -> (f64, u32, u32) {
        let rule = &self.scenario.episode;
        (rule.tick, rule.hold, rule.ticks)
    }

    /// Least and greatest value of each number of an action.
    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.scenario.cast.action_bounds()
    }

    /// The pedestrians that actions control: the name of each, whether its states are scaled to order one, and the bounds of the numbers of a state
    /// after the first four. Members of a role are told apart by their numbers within it.
    fn agents(&self) -> Vec<Agent> {
        let cast = &self.scenario.cast;
        let agent = |(number, role): (usize, &::episode::PedestrianRole)| {
            let before = cast.pedestrians[..number].iter().filter(|other| other.name == role.name).count();
            let further = role.observation.components().into_iter().skip(::episode::ObservationSpec::DIM);
            let bounds =
                further.map(|each| (each.low.unwrap_or(f64::NEG_INFINITY), each.high.unwrap_or(f64::INFINITY)));
            let is_scaled = role.observation.scaling == ::episode::Scaling::Unit;
            (format!("{}_{before}", role.name), is_scaled, bounds.collect())
        };
        cast.controlled().map(agent).collect()
    }

    /// Whether a network with these properties of its file and this number of inputs can control the pedestrians, each alone if it is `shared`: why it cannot, and
    /// how their episodes differ from those of its training.
    fn unfit(
        &self,
        properties: BTreeMap<String, String>,
        inputs: usize,
        shared: bool,
    ) -> (Option<&'static str>, Option<String>) {
        let (cast, rule) = (&self.scenario.cast, &self.scenario.episode);
        let casts: Vec<Cast> = match shared {
            true => cast.controlled().map(|(number, _)| cast.alone(number)).collect(),
            false => vec![cast.clone()],
        };
        let reason = casts.iter().find_map(|cast| network_fits(&properties, inputs, cast, rule).err());
        (reason, casts.iter().find_map(|cast| network_differs(&properties, cast, rule)))
    }

    /// Gives worlds new seeds; their next episode is number 0. A negative seed leaves a world as it is.
    fn reseed(&mut self, py: Python<'_>, seeds: PyReadonlyArray1<'_, i64>) -> PyResult<()> {
        let seeds = seeds.as_array().to_vec();
        let worlds = self.worlds();
        if seeds.len() != worlds.len() {
            return Err(PyValueError::new_err(format!("{} seeds for {} worlds", seeds.len(), worlds.len())));
        }
        py.detach(|| {
            each(worlds, |index, world| {
                if let Ok(seed) = u64::try_from(seeds[index]) {
                    world.reseed(seed);
                }
            });
        });
        Ok(())
    }

    /// Starts episodes in the worlds of the mask: those of the numbers, or where a number is negative the next ones. Returns the states of
    /// all worlds.
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        mask: PyReadonlyArray1<'_, bool>,
        episodes: PyReadonlyArray1<'_, i64>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (mask, episodes) = (mask.as_array().to_vec(), episodes.as_array().to_vec());
        let worlds = self.worlds();
        if mask.len() != worlds.len() || episodes.len() != worlds.len() {
            return Err(PyValueError::new_err(format!(
                "the mask and the episodes need one entry for each of {} worlds",
                worlds.len()
            )));
        }
        if let Some(episode) = episodes.iter().find(|episode| **episode > MOST_EPISODES as i64) {
            return Err(PyValueError::new_err(format!(
                "the number of the episode is {episode}; at most 2^53 is allowed"
            )));
        }
        let states = py.detach(|| {
            each(worlds, |index, world| {
                if mask[index] {
                    world.reset(u64::try_from(episodes[index]).ok());
                }
            });
            states(worlds, |world| &world.state)
        });
        self.raised.take()?;
        Ok(states.into_pyarray(py))
    }

    /// Takes one decision in each world. `autoreset` is `never`, `next_step`, `same_step` or `rest`.
    fn step<'py>(&mut self, py: Python<'py>, actions: Actions<'_>, autoreset: &str) -> PyResult<Stepped<'py>> {
        let autoreset = match autoreset {
            "never" => Autoreset::Never,
            "next_step" => Autoreset::NextStep,
            "same_step" => Autoreset::SameStep,
            "rest" => Autoreset::Rest,
            other => return Err(PyValueError::new_err(format!("there is no autoreset `{other}`"))),
        };
        let width = self.scenario.cast.action_bounds().len();
        let raised = self.raised.clone();
        let worlds = self.worlds();
        let stepped = match &actions {
            Actions::Single(actions) => step(py, worlds, actions.as_array(), width, autoreset),
            Actions::Double(actions) => step(py, worlds, actions.as_array(), width, autoreset),
        };
        raised.take()?;
        stepped?;
        let last = (autoreset == Autoreset::SameStep && worlds.iter().any(|world| world.step.done()))
            .then(|| states(worlds, |world| &world.last_state).into_pyarray(py));
        let of_step = |of: fn(&World) -> bool| -> Array1<bool> { worlds.iter().map(of).collect() };
        let (terminated, truncated) = (of_step(|world| world.step.terminated), of_step(|world| world.step.truncated));
        let rewards: Array1<f64> = worlds.iter().map(|world| world.step.reward).collect();
        let states = states(worlds, |world| &world.state).into_pyarray(py);
        Ok((states, rewards.into_pyarray(py), terminated.into_pyarray(py), truncated.into_pyarray(py), last))
    }

    /// Whether an episode runs in a world.
    fn is_running(&mut self, world: usize) -> PyResult<bool> {
        Ok(self.world(world)?.is_running())
    }

    /// The seed and the number of the present episode of a world; `None` before the first.
    fn place(&mut self, world: usize) -> PyResult<Option<(u64, u64)>> {
        Ok(self.world(world)?.place())
    }

    /// The ticks of the run-up to the present episode of a world, and whether the driver did not reach its start and was placed there.
    fn run_up(&mut self, world: usize) -> PyResult<(u32, bool)> {
        let world = self.world(world)?;
        Ok((world.simulation().run_up_ticks(), world.placed))
    }

    /// The run-ups of all worlds up to now: how many did not reach their start, and how many there were.
    fn run_ups(&mut self) -> (u64, u64) {
        let each = self.worlds().iter().map(|world| world.run_ups);
        each.fold((0, 0), |sum, run_ups| (sum.0 + run_ups.0, sum.1 + run_ups.1))
    }

    /// The outcome and the verdict of the last episode that ended in a world, as a new dictionary; `None` before the first end.
    fn end<'py>(&mut self, py: Python<'py>, world: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.world(world)?.end.as_ref().map(|end| episode::end(py, end)).transpose()
    }

    /// The present episode of a world tick by tick, as a new dictionary of arrays.
    fn trace<'py>(&mut self, py: Python<'py>, world: usize) -> PyResult<Bound<'py, PyDict>> {
        let scenario = self.scenario.clone();
        let world = self.world(world)?;
        if world.place().is_none() {
            return Err(PyRuntimeError::new_err("there is no episode yet; call reset first"));
        }
        episode::trace(py, &scenario, world.trace())
    }

    /// The action that a built-in pedestrian, `homing` or `intercept`, would take now in a world.
    fn suggested<'py>(
        &mut self,
        py: Python<'py>,
        world: usize,
        pedestrian: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let scenario = self.scenario.clone();
        let world = self.world(world)?;
        if world.place().is_none() {
            return Err(PyRuntimeError::new_err("there is no episode yet; call reset first"));
        }
        let scene = world.simulation().scene();
        let command = |number| -> PyResult<WalkCommand> {
            match pedestrian {
                "homing" => Ok(scene.homing(number)),
                "intercept" => Ok(scene.intercept(number)),
                other => {
                    Err(PyValueError::new_err(format!("unknown pedestrian `{other}`; there is homing, intercept")))
                }
            }
        };
        let commands = (0..scenario.cast.pedestrians.len()).map(command).collect::<PyResult<Vec<_>>>()?;
        let mut action = vec![0.0; scenario.cast.action_bounds().len()];
        scene.write_action(&commands, &mut action);
        Ok(action.into_pyarray(py))
    }

    /// The view of a world from above: rows, columns, and red, green, blue.
    fn picture<'py>(&mut self, py: Python<'py>, world: usize, size: usize) -> PyResult<Bound<'py, PyArray3<u8>>> {
        if !(16..=2048).contains(&size) {
            return Err(PyValueError::new_err(format!("the picture has {size} pixels a side; give 16 to 2048")));
        }
        let world = self.world(world)?;
        if world.place().is_none() {
            return Err(PyRuntimeError::new_err("there is no episode yet; call reset before render"));
        }
        let pixels = py.detach(move || top_view::picture(world, size));
        let pixels = Array3::from_shape_vec((size, size, 3), pixels).expect("three bytes for each pixel");
        Ok(pixels.into_pyarray(py))
    }

    /// The labels that a verdict may have.
    #[staticmethod]
    fn labels() -> Vec<&'static str> {
        Label::ALL.into_iter().map(Label::name).collect()
    }
}

/// Takes the decisions; the interpreter is released meanwhile.
fn step<T: Copy + Into<f64> + Sync>(
    py: Python<'_>,
    worlds: &mut [World],
    actions: ArrayView2<'_, T>,
    width: usize,
    autoreset: Autoreset,
) -> PyResult<()> {
    if actions.dim() != (worlds.len(), width) {
        let (rows, columns) = actions.dim();
        let text = format!("the actions have the shape ({rows}, {columns}); this needs ({}, {width})", worlds.len());
        return Err(PyValueError::new_err(text));
    }
    for (index, (world, action)) in worlds.iter().zip(actions.rows()).enumerate() {
        let waits = [Autoreset::NextStep, Autoreset::Rest].contains(&autoreset);
        let dead = waits && world.place().is_some() && !world.is_running();
        if !dead && !world.is_running() {
            let text = match world.place() {
                None => format!("world {index} has no episode yet; call reset before step"),
                Some(_) => format!("the episode of world {index} is over; call reset before the next step"),
            };
            return Err(PyRuntimeError::new_err(text));
        }
        if let Some(column) = action.iter().position(|number| !(*number).into().is_finite()) {
            let text = format!("number {column} of the action of world {index} is not finite");
            return Err(PyValueError::new_err(text));
        }
    }
    let seen = actions.view();
    py.detach(|| {
        each(worlds, |index, world| {
            if !world.is_running() {
                match autoreset {
                    Autoreset::NextStep => return world.reset(None),
                    Autoreset::Rest => return,
                    Autoreset::Never | Autoreset::SameStep => {}
                }
            }
            world.decide(seen.row(index).iter().map(|number| (*number).into()));
            if autoreset == Autoreset::SameStep && world.step.done() {
                world.start_over();
            }
        });
    });
    match worlds.iter().find_map(|world| world.faults().hopeless()) {
        Some(fault) => Err(PyRuntimeError::new_err(format!("the driver failed in ten episodes in a row: it {fault}"))),
        None => Ok(()),
    }
}
