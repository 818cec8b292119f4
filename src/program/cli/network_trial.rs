//! Trials of networks: the program starts itself, and the child loads a network and runs it once, within limits.

use std::io::Read;
use std::sync::Arc;

use crate::exit_code::ExitCode;
use compile::NetworkTrial;
use world::av::onnx::{Model, Network};

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
    // It is a driver or a pedestrian.
    if Model::read(bytes.clone()).is_err() {
        let _ = Network::read(bytes);
    }
    ExitCode::Done
}
