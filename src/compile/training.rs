use std::sync::Arc;

use super::lowering::Lowering;
use base::signature::{Form, Keys};
use lang::hir::Declaration;
use lang::{Reader, diagnostics, reason};
use learn::{ActorCritic, FirstNetworks, PpoConfig};

/// The form `training`.
pub fn form() -> Form {
    let doc = "How pedestrians are trained. The defaults are the paper's, and stable-baselines3's where it is silent.";
    Form::of_kinds("training", doc, vec![PpoConfig::signature()])
}

/// Reads the networks of the key `from`, for policies with these numbers of numbers of a state and an action; reports what is wrong.
pub fn read_networks(
    declaration: &Declaration,
    config: &mut PpoConfig,
    sizes: &[(usize, usize)],
    lowering: &mut Lowering<'_>,
) {
    let block = &declaration.block;
    let Some(path) = config.from.as_ref().map(|from| from.path.clone()) else { return };
    let mut is_missing = false;
    let bytes = lowering.read.bytes(&lowering.beside(declaration, &path)).map_err(|error| {
        is_missing = error.kind() == std::io::ErrorKind::NotFound;
        reason(&error)
    });
    let read = bytes.and_then(|bytes| ActorCritic::from_safetensors(&bytes).map_err(|error| error.to_string()));
    let fitting = read.and_then(|(networks, _)| {
        let accepted = sizes
            .iter()
            .try_for_each(|(state, action)| config.accepts(&networks, *state * config.frame_stack, *action));
        accepted.map_err(|error| error.to_string())?;
        Ok(Arc::new(networks))
    });
    let unusable = |reason: String| diagnostics::unusable_model(block.place("from"), &path, &reason, is_missing);
    match fitting {
        Ok(networks) => config.from = Some(FirstNetworks { path, networks: Some(networks) }),
        Err(reason) => lowering.said.push(unusable(reason)),
    }
}
