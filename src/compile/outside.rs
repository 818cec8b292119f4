//! Kinds of driving policies that need a program or a file in addition to their arguments.

use std::sync::Arc;

use super::lowering::Lowering;
use lang::hir::Declaration;
use lang::{Reader, diagnostics, reason};
use world::av::external::{External, ExternalKeys, Opener, Program, ProgramKeys, Settings};
use world::av::onnx::{Model, Onnx, OnnxKeys};
use world::env::PolicyMaker;

/// A program, if the user allows programs. It is not started here.
pub fn external(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<PolicyMaker> {
    let (program, opener) = lowering.allowed_program(declaration)?;
    let settings = Settings::from(declaration.block.keys::<ExternalKeys>());
    Some(Arc::new(move || Box::new(External::new(program.clone(), settings, opener.clone()))))
}

impl Lowering<'_> {
    /// The program of the key `command` and its opener; none after reporting what is wrong. The program is not started.
    pub fn allowed_program(&mut self, declaration: &Declaration) -> Option<(Program, Arc<dyn Opener>)> {
        let place = declaration.block.place("command");
        let ProgramKeys { command, .. } = &declaration.block.keys();
        let program = match Program::parse(command, self.beside(declaration, "")) {
            Ok(program) => program,
            Err(reason) => {
                self.said.push(diagnostics::unusable_command(place, command, reason));
                return None;
            }
        };
        let Some(opener) = self.catalog.opener.clone() else {
            self.said.push(diagnostics::external_not_allowed(place, command));
            return None;
        };
        if let Err(reason) = opener.find(&program) {
            self.said.push(diagnostics::unusable_command(place, command, &reason));
            return None;
        }
        // The contents of a command's files are part of the scenario.
        self.read.note(self.beside(declaration, command), opener.digest(&program));
        Some((program, opener))
    }
}

/// A network from a file.
pub fn onnx(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<PolicyMaker> {
    let OnnxKeys { model: path, worlds } = declaration.block.keys();
    let bytes = lowering.read.bytes(&lowering.beside(declaration, &path)).map_err(|error| reason(&error));
    match bytes.and_then(|bytes| Model::read(bytes).map_err(|error| error.to_string())) {
        Ok(model) => {
            let model = Arc::new(model);
            Some(Arc::new(move || Box::new(Onnx::new(worlds, model.clone()))))
        }
        Err(reason) => {
            lowering.said.push(diagnostics::unusable_model(declaration.block.place("model"), &path, &reason));
            None
        }
    }
}
