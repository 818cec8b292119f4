//! The extension module `falsify_av._core`: scenarios, and worlds of them that are stepped with numpy arrays.
//!
//! The package's Python files give these classes the interfaces of Gymnasium, stable-baselines3 and PettingZoo. All checks of a user's
//! input are here or there; no call ends the interpreter.

mod scenarios;
mod driver;
mod world;
mod worlds;
mod recording;
mod episode;
mod top_view;

use pyo3::prelude::*;

/// Scenarios and worlds.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::scenarios::{Choice, Scenarios, load, shipped_network};
    #[pymodule_export]
    use super::worlds::Worlds;

    /// Adds the version of the simulator.
    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        pyo3::types::PyModuleMethods::add(module, "__version__", env!("CARGO_PKG_VERSION"))
    }
}
