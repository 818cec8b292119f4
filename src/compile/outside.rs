//! Programs and networks of the user: drivers of them, and what a task depends on.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::lowering::Lowering;
use super::policy_kind::FromArguments;
use super::programs::{ExternalProgram, Programs};
use super::reached::reached;
use base::signature::{Arguments, DeclarationId, Keys};
use episode::BridgeKeys;
use lang::hir::Declaration;
use lang::{Reader, diagnostics, reason};
use ported::pufferdrive::{BLAKE3, Network, ORIGIN, PufferDrive, PufferDriveKeys};
use world::av::BrakeKeys;
use world::av::external::{External, ExternalKeys, Opener, Program, ProgramKeys, Settings};
use world::av::onnx::{Model, Onnx, OnnxKeys};

/// The bridges of the Python package.
pub const BRIDGES: [&str; 4] = ["metadrive", "sumo", "carla", "esmini"];

/// The command of a bridge: that of the Python package if the text begins with a name of it, as `metadrive mended`, else the text.
pub fn bridge_command(text: &str) -> String {
    let is_known = text.split_whitespace().next().is_some_and(|name| BRIDGES.contains(&name));
    if is_known { format!("python3 -m falsify_av.bridges {text}") } else { text.into() }
}

/// A program, if the user allows programs. It is not started here. Other arguments may have other parameters for it.
pub fn external(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let ExternalKeys { parameters, .. } = declaration.block.keys();
    for (place, text) in parameters.iter().flatten().enumerate() {
        if let Err(reason) = Program::parameter(text) {
            let spans = declaration.block.members("parameters");
            let span = spans.get(place).copied().unwrap_or(declaration.block.head);
            let message = format!("`{text}` is not a parameter: {reason}");
            lowering.said.push(diagnostics::contradiction(span, message).help("write it as \"gap=0.5\""));
            return None;
        }
    }
    let (program, opener) = lowering.allowed_program(declaration)?;
    Some(Arc::new(move |arguments: &Arguments| {
        let keys = ExternalKeys::read(arguments);
        let parameters = keys.parameters.iter().flatten().filter_map(|text| Program::parameter(text).ok()).collect();
        let program = Program { parameters, ..program.clone() };
        let brake = keys.aeb.then(BrakeKeys::default);
        let settings = Settings::from(keys);
        let opener = opener.clone();
        Arc::new(move || {
            let driver = External::new(program.clone(), settings, opener.clone());
            Box::new(match brake {
                Some(brake) => driver.guarded(brake),
                None => driver,
            })
        })
    }))
}

impl Lowering<'_> {
    /// The program of the key `command` and its opener; `None` after reporting what is wrong. The program is not started.
    pub fn allowed_program(&mut self, declaration: &Declaration) -> Option<(Program, Arc<dyn Opener>)> {
        let place = declaration.block.place("command");
        let ProgramKeys { command, files, .. } = &declaration.block.keys();
        let is_bridge = declaration.kind == BridgeKeys::KIND;
        let words = if is_bridge { bridge_command(command) } else { command.clone() };
        let program = match Program::parse(&words, self.beside(declaration, "")) {
            Ok(program) => Program { files: files.clone().unwrap_or_default(), ..program },
            Err(reason) => {
                self.said.push(diagnostics::unusable_command(place, command, reason));
                return None;
            }
        };
        let opener = self.catalog.opener.clone();
        if opener.is_none() || self.catalog.looks_up {
            diagnostics::external_not_allowed(self.said, place, command, opener.is_none());
        }
        let opener = opener?;
        if let Err(reason) = opener.find(&program) {
            self.said.push(diagnostics::unusable_command(place, command, &reason));
            return None;
        }
        if let Err(reason) = self.note_program(declaration, &program, opener.as_ref()) {
            self.said.push(diagnostics::unusable_command(declaration.block.place("files"), command, &reason));
            return None;
        }
        Some((program, opener))
    }

    /// Finds the digests of the files that the program of a declaration consists of.
    ///
    /// # Errors
    /// A file cannot be read, as a part of a sentence.
    fn note_program(
        &mut self,
        declaration: &Declaration,
        program: &Program,
        opener: &dyn Opener,
    ) -> Result<(), String> {
        if !self.read.wanted() || self.catalog.looks_up || self.noted(declaration).is_some() {
            return Ok(());
        }
        let ProgramKeys { command, version, .. } = declaration.block.keys();
        let (name, folder) = (declaration.name.clone(), program.folder.clone());
        let found = ExternalProgram { name, command, version, folder, files: opener.digests(program)? };
        self.shared.programs.entry(declaration.id).or_default().push((declaration.block.clone(), Arc::new(found)));
        Ok(())
    }

    /// Notes what the program of a declaration says of its version, unless the scenario states its version or its files.
    pub(super) fn note_version(&mut self, declaration: &Declaration, version: &str) {
        let known = self.shared.programs.get_mut(&declaration.id).into_iter().flatten();
        for (_, program) in known.filter(|(block, program)| *block == declaration.block && program.is_unknown()) {
            Arc::make_mut(program).version = Some(version.into());
        }
    }

    /// The program of a declaration, if it has one.
    pub(super) fn noted(&self, declaration: &Declaration) -> Option<&Arc<ExternalProgram>> {
        let known = self.shared.programs.get(&declaration.id)?;
        known.iter().find(|(block, _)| *block == declaration.block).map(|(_, program)| program)
    }

    /// The programs that a task depends on which depends on these declarations.
    pub(super) fn programs(&self, parts: &[DeclarationId]) -> Programs {
        let all: BTreeSet<DeclarationId> = parts.iter().flat_map(|part| reached(self.program, *part)).collect();
        all.into_iter().filter_map(|id| self.noted(self.program.get(id))).cloned().collect()
    }

    /// The network in the file of the key `model`. It is tried before it is loaded; `None` after reporting what is wrong.
    pub fn network<T>(
        &mut self,
        declaration: &Declaration,
        path: &str,
        load: impl FnOnce(Vec<u8>) -> Result<T, String>,
    ) -> Option<T> {
        let place = declaration.block.place("model");
        let file = self.beside(declaration, path);
        let mut is_missing = false;
        let bytes = self.read.bytes(&file).map_err(|error| {
            is_missing = error.kind() == std::io::ErrorKind::NotFound;
            reason(&error)
        });
        if let (Ok(bytes), Some(trial)) = (&bytes, &self.catalog.network_trial) {
            match trial(bytes) {
                Ok(None) => {}
                Ok(Some(seconds)) => self.said.push(diagnostics::slow_model(place, path, seconds)),
                Err(reason) => {
                    self.said.push(diagnostics::untrusted_model(place, path, &reason));
                    return None;
                }
            }
        }
        let loaded = bytes.and_then(load);
        loaded.map_err(|reason| self.said.push(diagnostics::unusable_model(place, path, &reason, is_missing))).ok()
    }
}

/// A network from a file.
pub fn onnx(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let OnnxKeys { model, output, worlds } = declaration.block.keys();
    let model = lowering.network(declaration, &model, |bytes| {
        Model::read(bytes, output.as_deref()).map_err(|error| error.to_string())
    })?;
    let model = Arc::new(model);
    lowering.shared.carried.extend(model.carries().map(|state| (declaration.id, state)));
    Some(Arc::new(move |_: &Arguments| {
        let model = model.clone();
        Arc::new(move || Box::new(Onnx::new(worlds, model.clone())))
    }))
}

/// PufferDrive's policy with weights from a file.
pub fn pufferdrive(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let PufferDriveKeys { weights: path, .. } = declaration.block.keys();
    let (place, file) = (declaration.block.place("weights"), lowering.beside(declaration, &path));
    let bytes = lowering.read.bytes(&file).map_err(|error| reason(&error));
    let network = bytes.and_then(|bytes| Ok((blake3::hash(&bytes), Network::read(&bytes)?)));
    let unusable = |reason: String| diagnostics::unusable_model(place, &path, &reason, false).help(ORIGIN);
    let (digest, network) = network.map_err(|reason| lowering.said.push(unusable(reason))).ok()?;
    if digest.to_hex().as_str() != BLAKE3 {
        lowering.said.push(diagnostics::other_weights(place, &path).help(ORIGIN));
    }
    let network = Arc::new(network);
    Some(Arc::new(move |arguments: &Arguments| {
        let (network, keys) = (network.clone(), PufferDriveKeys::read(arguments));
        Arc::new(move || Box::new(PufferDrive::new(network.clone(), keys.clone())))
    }))
}
