use std::sync::Arc;

use super::lowering::Lowering;
use base::signature::{DeclarationId, Form, Keys, Signature};
use episode::walker::{Controller, Natural, NaturalKeys, Networked, NetworkedKeys, Programmed, ProgrammedKeys};
use lang::diagnostics;
use lang::hir::Declaration;
use world::av::external::ProgramKeys;
use world::av::onnx::Network;

/// A kind of controller: its keys, and how it is made.
struct ControllerKind {
    /// Its keys.
    signature: fn() -> Signature,
    /// Makes one; `None` after reporting what is wrong.
    lower: fn(&Declaration, &mut Lowering<'_>) -> Option<Controller>,
}

/// All kinds; a new one is a line here.
const KINDS: [ControllerKind; 3] = [
    ControllerKind { signature: ProgrammedKeys::signature, lower: external },
    ControllerKind { signature: NetworkedKeys::signature, lower: onnx },
    ControllerKind { signature: NaturalKeys::signature, lower: natural },
];

/// The form `pedestrian`.
pub fn form() -> Form {
    let doc = "What moves a pedestrian: a program or a network of your own, or a built-in one with other settings. `pedestrians` of an `evaluate` or an `estimate` block and a `method` of kind `controlled` name it.";
    Form::of_kinds("pedestrian", doc, KINDS.iter().map(|kind| (kind.signature)()).collect())
}

impl Lowering<'_> {
    /// The controller; `None` after reporting what is wrong.
    pub fn controller(&mut self, id: DeclarationId) -> Option<Controller> {
        let declaration = self.program.get(id);
        if self.catalog.has_pedestrian(&declaration.name) {
            let message = format!("`{}` is the name of a built-in `pedestrian`", declaration.name);
            let help = "give it another name, so that both can be evaluated";
            self.said.push(diagnostics::contradiction(declaration.block.head, message).help(help));
            return None;
        }
        let found = KINDS.iter().find(|kind| (kind.signature)().name == declaration.kind);
        (found.expect("checked: the kind is in the catalogue").lower)(declaration, self)
    }
}

/// A program, if the user allows programs. It is not started here.
fn external(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<Controller> {
    let ProgrammedKeys { program: ProgramKeys { timeout, start_timeout, .. } } = declaration.block.keys();
    let (program, opener) = lowering.allowed_program(declaration)?;
    let make = move || Box::new(Programmed::new(program.clone(), timeout, start_timeout, opener.clone())) as _;
    Some(Controller::new(&declaration.name, make))
}

/// A network from a file.
fn onnx(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<Controller> {
    let NetworkedKeys { model, output } = declaration.block.keys();
    let (network, properties) = lowering.network(declaration, &model, |bytes| {
        let properties = Arc::new(learn::onnx_properties(&bytes));
        let network = Network::read(bytes, output.as_deref()).map_err(|error| error.to_string())?;
        Networked::check(&network)
            .map(|()| (Arc::new(network), properties))
            .map_err(|unsuitable| unsuitable.to_string())
    })?;
    let make = move || Box::new(Networked::new(network.clone(), properties.clone())) as _;
    Some(Controller::new(&declaration.name, make))
}

/// A pedestrian that walks as recorded ones do, with settings.
fn natural(declaration: &Declaration, _: &mut Lowering<'_>) -> Option<Controller> {
    let walker = Natural::from_keys(declaration.block.keys());
    Some(Controller::new(&declaration.name, move || Box::new(walker.clone()) as _))
}
