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
    /// Keys of which the first must not be above the second.
    pub rising: Vec<[&'static str; 2]>,
    /// The length of a tick that it is made for (s), if it is made for one.
    pub tick: Option<f64>,
    /// If it stands in for something that it is not: what is real, what is assumed, what its numbers show. Empty for the real thing.
    pub surrogate: &'static str,
}

impl Signature {
    /// A kind with keys and nothing inside.
    pub fn new(name: &'static str, doc: &'static str, params: Vec<Param>) -> Self {
        Self { name, doc, params, children: Vec::new(), clauses: false, rising: Vec::new(), tick: None, surrogate: "" }
    }

    /// The same, and no value of these keys is above that of the next one.
    ///
    /// # Panics
    /// One of them is no key.
    pub fn rising(mut self, keys: &[&'static str]) -> Self {
        assert!(keys.iter().all(|key| self.params.iter().any(|param| param.name == *key)), "no keys: {keys:?}");
        self.rising.extend(keys.windows(2).map(|pair| [pair[0], pair[1]]));
        self
    }

    /// The same, made for ticks of this length (s).
    pub fn made_for(self, tick: f64) -> Self {
        Self { tick: Some(tick), ..self }
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
    /// What its value lies between, in SI, whatever happens.
    pub bounds: (f64, f64),
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
