use std::sync::Arc;

use base::diagnostic::Diagnostic;
use base::signature::{Arguments, DeclarationId, Form, Keys, Signature, Value};
use episode::walker::Controller;
use lang::diagnostics;
use lang::hir::Declaration;
use learn::PpoConfig;
use search::{
    Archive, ArchiveSearch, Controlled, ControlledKeys, Exhaustive, Falsifier, Learning, LearningKeys, OpenLoop,
    TreeSearch,
};

/// What the keys of a falsifier may name.
pub struct Named {
    /// The settings for training pedestrians.
    pub training: Option<PpoConfig>,
    /// The controller, for the kind that has one.
    pub controller: Option<Controller>,
}

/// A kind of falsifier: its keys, and how it is made.
#[derive(Clone)]
pub struct FalsifierKind {
    /// Its keys.
    pub signature: Signature,
    /// Makes one from checked arguments and what they name.
    make: Make,
}

type Make = Arc<dyn Fn(&Arguments, &Named) -> Arc<dyn Falsifier> + Send + Sync>;

impl FalsifierKind {
    /// A kind with these keys.
    pub fn new<K: Keys, F: Falsifier + 'static>(make: impl Fn(K) -> F + Send + Sync + 'static) -> Self {
        Self::naming(move |keys, _| make(keys))
    }

    /// A kind with these keys, which name what it is made of.
    fn naming<K: Keys, F: Falsifier + 'static>(make: impl Fn(K, &Named) -> F + Send + Sync + 'static) -> Self {
        let make = move |arguments: &_, named: &_| Arc::new(make(K::read(arguments), named)) as _;
        Self { signature: K::signature(), make: Arc::new(make) }
    }
}

/// All kinds of falsifiers but those that only walk; a new one is a line here.
pub fn kinds() -> Vec<FalsifierKind> {
    vec![
        FalsifierKind::new(OpenLoop::cross_entropy),
        FalsifierKind::new(OpenLoop::cma_es),
        FalsifierKind::new(|keys: TreeSearch| keys),
        FalsifierKind::naming(|keys: Archive, named| ArchiveSearch { keys, from: named.controller.clone() }),
        FalsifierKind::new(|keys: Exhaustive| keys),
        FalsifierKind::naming(|_: LearningKeys, named| {
            Learning(named.training.clone().expect("checked: it has a training"))
        }),
        FalsifierKind::naming(|_: ControlledKeys, named| {
            Controlled(named.controller.clone().expect("checked: it names a pedestrian"))
        }),
    ]
}

/// The form `method`.
pub fn form() -> Form {
    let doc = "A method that looks for collisions with a budget of simulator ticks; a `search` block of a campaign compares several.";
    Form::of_kinds("method", doc, Vec::new())
}

/// Whether a falsifier trains pedestrians.
pub fn learns(kinds: &[FalsifierKind], declaration: &Declaration) -> bool {
    let kind = kinds.iter().find(|kind| kind.signature.name == declaration.kind);
    kind.is_some_and(|kind| kind.signature.params.iter().any(|param| param.name == "training"))
}

/// The falsifier; one that [learns] needs a training.
pub fn lower(
    kinds: &[FalsifierKind],
    declaration: &Declaration,
    named: &Named,
    said: &mut Vec<Diagnostic>,
) -> Arc<dyn Falsifier> {
    let found = kinds.iter().find(|candidate| candidate.signature.name == declaration.kind);
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

/// The declaration that an optional key names; `None` if this kind has no such key.
pub fn named(arguments: &Arguments, key: &str) -> Option<DeclarationId> {
    match optional(arguments, key) {
        Some(Value::Reference(id)) => Some(*id),
        _ => None,
    }
}

fn optional<'a>(arguments: &'a Arguments, key: &str) -> Option<&'a Value> {
    arguments.iter().find(|(name, _)| *name == key).map(|(_, value)| value)
}
