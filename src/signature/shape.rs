use super::Param;
use crate::units::Dimension;

/// A kind, or a block: a name, its keys, and the blocks that may stand inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Signature {
    /// The word that selects it.
    pub name: &'static str,
    /// One or two sentences for the reference.
    pub doc: &'static str,
    /// Its keys.
    pub params: Vec<Param>,
    /// Blocks that may stand inside, any number of each.
    pub children: Vec<Signature>,
    /// Whether `on event => formula` clauses may stand inside.
    pub clauses: bool,
    /// If it stands in for something that it is not: what is real, what is assumed, what its numbers show. Empty for the real thing.
    pub surrogate: &'static str,
}

impl Signature {
    /// A kind with keys and nothing inside.
    pub fn new(name: &'static str, doc: &'static str, params: Vec<Param>) -> Self {
        Self { name, doc, params, children: Vec::new(), clauses: false, surrogate: "" }
    }

    /// The same, and it says of what it is a surrogate; reports repeat that.
    pub fn surrogate(self, surrogate: &'static str) -> Self {
        Self { surrogate, ..self }
    }
}

/// A form: the word a declaration begins with.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// The word.
    pub name: &'static str,
    /// One or two sentences for the reference.
    pub doc: &'static str,
    /// The keys of `form name { … }`; `None` when a kind must be named.
    pub plain: Option<Signature>,
    /// Whether a `matrix` block may multiply its declarations.
    pub multiplies: bool,
    /// The kinds of `form name = kind(…)`.
    pub kinds: Vec<Signature>,
}

/// A quantity that a formula may name.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name in formulas.
    pub name: &'static str,
    /// What it measures; its value is in SI.
    pub dimension: Dimension,
    /// One sentence for the reference.
    pub doc: &'static str,
}

/// Something that a reward can answer to.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its name, such as `hit`.
    pub name: &'static str,
    /// The words it takes in parentheses, such as `front`; empty when it takes none.
    pub words: &'static [&'static str],
    /// The names of the variables that have a value when it happens.
    pub variables: &'static [&'static str],
    /// Whether `on` clauses can answer to it; conditions can speak of all events.
    pub answered: bool,
    /// One sentence for the reference.
    pub doc: &'static str,
}

/// What formulas can speak about.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vocabulary {
    /// All variables; a formula holds indices into this list.
    pub variables: Vec<Variable>,
    /// All events.
    pub events: Vec<Event>,
}
