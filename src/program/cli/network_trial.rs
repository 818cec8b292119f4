//! Trials of networks: the program starts itself, and the child loads a network and runs it once, within limits.

use std::io::Read;
use std::sync::Arc;

use crate::cli::console;
use crate::exit_code::ExitCode;
use compile::NetworkTrial;
use world::av::onnx::{Model, Network, outputs};

/// The argument with which the program starts itself.
pub const WORD: &str = "try-network";

/// The trial of a network before it is loaded.
pub fn trial() -> Arc<NetworkTrial> {
    Arc::new(|bytes| process::trial(&[WORD], bytes))
}

/// What the child does. Whether the network can be used is found out later, by the program that started it.
pub fn carry_out() -> ExitCode {
    let mut bytes = Vec::new();
    if std::io::stdin().lock().take(base::files::MAX_BYTES).read_to_end(&mut bytes).is_err() {
        return ExitCode::Usage;
    }
    process::limit_trial(bytes.len());
    let names = outputs(bytes.clone());
    let (loaded, mut longest) = (process::used_seconds(), 0.0_f64);
    // Each output may be chosen, of a driver or of a pedestrian.
    for name in &names {
        let begun = process::used_seconds();
        if Model::read(bytes.clone(), Some(name)).is_err() {
            let _ = Network::read(bytes.clone(), Some(name));
        }
        longest = longest.max(process::used_seconds() - begun - loaded);
    }
    console::say(&longest.to_string());
    ExitCode::Done
}
