//! What makes a run pass or fail, and what a server of continuous integration is told.

use std::sync::{Mutex, PoisonError};

use super::repeat_args::GateOptions;
use super::{ExitCode, front};
use crate::report::{self, Gate, Judged, Manifest, Metrics, Suite};

/// The gates of a run, and what they have seen.
pub struct Gates<'a> {
    options: &'a GateOptions,
    gates: Vec<Gate>,
    suites: Mutex<Vec<Suite>>,
}

impl<'a> Gates<'a> {
    /// Reads the gates, before anything is run.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn new(options: &'a GateOptions) -> Result<Self, ExitCode> {
        let gates = options.fail_if.iter().map(|text| Gate::parse(text)).collect::<Result<_, _>>();
        let gates = gates.map_err(|error| {
            front::fail(&format!("--fail-if: {error}"));
            ExitCode::Usage
        })?;
        Ok(Self { options, gates, suites: Mutex::default() })
    }

    /// Judges the cells of a campaign and says which gates are broken; whether none is.
    pub fn judge(&self, manifest: &Manifest, metrics: &Metrics) -> bool {
        if self.gates.is_empty() && self.options.junit.is_none() {
            return true;
        }
        let cells = metrics.cells().unwrap_or_default();
        let mut passed = true;
        let judge = |gate: &Gate| (gate.clone(), gate.judge(&metrics.cells));
        let gates: Vec<(Gate, Vec<Judged>)> = self.gates.iter().map(judge).collect();
        for (gate, judged) in &gates {
            for (cell, judged) in cells.iter().zip(judged) {
                let cell = format!("{}, {}", manifest.campaign, cell.key.in_full());
                match judged {
                    Judged::Broken(values) => {
                        passed = false;
                        front::fail(&format!("--fail-if {}: {} in {cell}", gate.text(), report::shown(values)));
                    }
                    Judged::Missing(column) => {
                        front::warn(&format!("--fail-if {}: there is no {column} in {cell}", gate.text()));
                    }
                    Judged::Passed | Judged::Elsewhere => {}
                }
            }
            if judged.iter().all(|judged| *judged == Judged::Elsewhere) {
                front::warn(&format!("--fail-if {}: it speaks of no cell of {}", gate.text(), manifest.campaign));
            }
        }
        self.suites.lock().unwrap_or_else(PoisonError::into_inner).push(Suite {
            manifest: manifest.clone(),
            cells,
            gates,
        });
        passed
    }

    /// Writes the JUnit file, if one is wanted.
    ///
    /// # Errors
    /// The message to print.
    pub fn write(&self) -> Result<(), String> {
        let Some(path) = &self.options.junit else { return Ok(()) };
        let page = report::junit(&self.suites.lock().unwrap_or_else(PoisonError::into_inner));
        report::write_file(path, page.as_bytes()).map_err(|error| error.to_string())
    }
}
