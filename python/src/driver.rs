//! A driver that is a Python object. It speaks the protocol of external drivers, so it perceives what they do.

use std::sync::{Arc, Mutex, PoisonError};

use episode::{PolicyMaker, Scenario};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use world::av::external::{External, Link, Opener, Program, Settings};
use world::av::{Exit, Fault};

/// The first exception that a driver has raised since the last look.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Takes it.
    pub fn take(&self) -> PyResult<()> {
        match self.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    fn note(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Makes a function from messages to answers for each driver: it is called without arguments, as `falsify_av.drivers` has it.
struct PythonOpener {
    make: Py<PyAny>,
    raised: Raised,
}

impl Opener for PythonOpener {
    fn open(&self, _: &Program) -> Result<Box<dyn Link>, Fault> {
        let answer = Python::attach(|py| self.make.call0(py)).map_err(|error| {
            self.raised.note(error);
            Fault::NotStarted
        })?;
        Ok(Box::new(PythonLink { answer, raised: self.raised.clone(), answered: Vec::new() }))
    }
}

/// One driver and its last answer.
struct PythonLink {
    answer: Py<PyAny>,
    raised: Raised,
    answered: Vec<u8>,
}

impl Link for PythonLink {
    fn send(&mut self, message: &[u8], _limit: f64) -> Result<(), Fault> {
        let answered = Python::attach(|py| {
            let answer = self.answer.call1(py, (PyBytes::new(py, message),))?;
            answer.extract::<Vec<u8>>(py)
        });
        match answered {
            Ok(answered) => {
                self.answered = answered;
                Ok(())
            }
            Err(error) => {
                self.raised.note(error);
                Err(Fault::Ended(Exit::Unknown))
            }
        }
    }

    fn line(&mut self, line: &mut Vec<u8>, _longest: usize) -> Result<(), Fault> {
        line.append(&mut self.answered);
        Ok(())
    }

    fn exact(&mut self, _bytes: &mut [u8]) -> Result<(), Fault> {
        // It greets with JSON, so no message has a length.
        Err(Fault::Ended(Exit::Unknown))
    }

    fn note(&self, text: &str) {
        // A program's wrong answer ends its episode; here it is a mistake in the caller's own code.
        self.raised.note(PyValueError::new_err(format!("the driver {text}")));
    }
}

/// The scenario with a Python driver in the place of the one under test. `make` is called once for each driver that is needed.
pub fn with_driver(scenario: &Scenario, make: Py<PyAny>, raised: &Raised) -> Scenario {
    let opener: Arc<dyn Opener> = Arc::new(PythonOpener { make, raised: raised.clone() });
    let program = Program { words: vec!["a Python driver".into()], ..Program::default() };
    let settings = Settings { worlds: 1, ..Settings::default() };
    let policy: PolicyMaker = Arc::new(move || Box::new(External::new(program.clone(), settings, opener.clone())));
    let mut scenario = scenario.clone();
    scenario.cast.vehicles[0].policy = policy;
    scenario
}
