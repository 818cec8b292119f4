use std::sync::Arc;

use base::diagnostic::Diagnostic;
use base::signature::{Arguments, DeclarationId, Form, Signature, Value};
use lang::diagnostics;
use lang::hir::Declaration;
use learn::PpoConfig;
use world::falsifier::{
    Archive, Controlled, Controller, Exhaustive, Falsifier, Homing, Intercept, Learning, Natural, OpenLoop, Random,
    Scripted, TreeSearch, Walking,
};

/// What the keys of a falsifier may name.
pub struct Named {
    /// The settings for training pedestrians, and the number of environments.
    pub training: Option<(PpoConfig, usize)>,
    /// The controller, for the kind that has one.
    pub controller: Option<Controller>,
}

/// A kind of falsifier: its keys, and how it is made.
pub struct FalsifierKind {
    /// Its keys.
    pub signature: fn() -> Signature,
    /// Makes one from checked arguments and what they name.
    pub make: fn(&Arguments, &Named) -> Arc<dyn Falsifier>,
}

/// All kinds of falsifiers; a new one is a line here.
pub fn kinds() -> Vec<FalsifierKind> {
    vec![
        FalsifierKind {
            signature: Walking::<Random>::signature,
            make: |_, _| Arc::new(Walking::new(Random::default())),
        },
        FalsifierKind { signature: Walking::<Homing>::signature, make: |_, _| Arc::new(Walking::new(Homing)) },
        FalsifierKind { signature: Walking::<Intercept>::signature, make: |_, _| Arc::new(Walking::new(Intercept)) },
        FalsifierKind {
            signature: Walking::<Natural>::signature,
            make: |arguments, _| Arc::new(Walking::natural(arguments)),
        },
        FalsifierKind { signature: Walking::<Scripted>::signature, make: |_, _| Arc::new(Walking::new(Scripted)) },
        FalsifierKind {
            signature: OpenLoop::cross_entropy_signature,
            make: |arguments, _| Arc::new(OpenLoop::cross_entropy(arguments)),
        },
        FalsifierKind {
            signature: OpenLoop::cma_es_signature,
            make: |arguments, _| Arc::new(OpenLoop::cma_es(arguments)),
        },
        FalsifierKind { signature: TreeSearch::signature, make: |arguments, _| Arc::new(TreeSearch::new(arguments)) },
        FalsifierKind { signature: Archive::signature, make: |arguments, _| Arc::new(Archive::new(arguments)) },
        FalsifierKind { signature: Exhaustive::signature, make: |arguments, _| Arc::new(Exhaustive::new(arguments)) },
        FalsifierKind {
            signature: Learning::signature,
            make: |_, named| {
                let (config, environments) = named.training.clone().expect("checked: it has a training");
                Arc::new(Learning::new(config, environments))
            },
        },
        FalsifierKind {
            signature: Controlled::signature,
            make: |_, named| {
                Arc::new(Controlled::new(named.controller.clone().expect("checked: it names a controller")))
            },
        },
    ]
}

/// The form `falsifier`.
pub fn form(kinds: &[FalsifierKind]) -> Form {
    Form {
        name: "falsifier",
        doc: "A method that looks for collisions with a budget of simulator ticks; a `search` block of a campaign compares several.",
        plain: None,
        multiplies: false,
        kinds: kinds.iter().map(|kind| (kind.signature)()).collect(),
    }
}

/// Whether a falsifier trains pedestrians.
pub fn learns(kinds: &[FalsifierKind], declaration: &Declaration) -> bool {
    let signature = kinds.iter().map(|kind| (kind.signature)()).find(|signature| signature.name == declaration.kind);
    signature.is_some_and(|signature| signature.params.iter().any(|param| param.name == "training"))
}

/// The falsifier; one that [learns] needs a training.
pub fn lower(
    kinds: &[FalsifierKind],
    declaration: &Declaration,
    named: &Named,
    said: &mut Vec<Diagnostic>,
) -> Arc<dyn Falsifier> {
    let found = kinds.iter().find(|candidate| (candidate.signature)().name == declaration.kind);
    let arguments = &declaration.block.arguments;
    let number = |key: &str| match optional(arguments, key) {
        Some(Value::Integer(number)) => Some(*number),
        _ => None,
    };
    if let (Some(elite), Some(population)) = (number("elite"), number("population"))
        && elite > population
    {
        let message = format!("an elite of {elite} is more than the population of {population}");
        said.push(diagnostics::contradiction(declaration.block.place("elite"), message));
    }
    (found.expect("checked: the kind is in the catalogue").make)(arguments, named)
}

/// The declaration that an optional key names; none when this kind has no such key.
pub fn named(arguments: &Arguments, key: &str) -> Option<DeclarationId> {
    match optional(arguments, key) {
        Some(Value::Reference(id)) => Some(*id),
        _ => None,
    }
}

fn optional<'a>(arguments: &'a Arguments, key: &str) -> Option<&'a Value> {
    arguments.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
}
