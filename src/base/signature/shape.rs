use super::{Held, Type, VariableId, bounds};
use crate::units::Dimension;

/// A key of a form or kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// The key.
    pub name: &'static str,
    pub ty: Type,
    /// The value when the key is not given, as written in a file. `None` if the key is required, and `Some("")`
    /// when it is optional and then absent.
    pub default: Option<&'static str>,
    /// One sentence for the reference.
    pub doc: &'static str,
}

impl Param {
    /// A key whose values are held in Rust as `T`, of which a single one is of this type. The default is written as in a file.
    pub fn new<T: Held>(name: &'static str, single: Type, default: Option<&'static str>, doc: &'static str) -> Self {
        Self { name, ty: T::type_of(single), default: default.or(T::OPTIONAL.then_some("")), doc }
    }
}

/// A kind, or a block: a name, its keys, and the blocks that may stand inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Signature {
    /// The word that selects it.
    pub name: &'static str,
    /// One or two sentences for the reference.
    pub doc: &'static str,
    /// Its keys.
    pub params: Vec<Param>,
    /// Blocks that may stand inside.
    pub children: Vec<Signature>,
    /// Whether it may stand only once in its owner, if it is a block.
    pub once: bool,
    /// Whether `on event => formula` clauses may stand inside.
    pub clauses: bool,
    /// Pairs of keys; the value of the first must not be above that of the second.
    pub rising: Vec<[&'static str; 2]>,
    /// The length of the tick that it is made for (s), if any.
    pub tick: Option<f64>,
    /// What this kind approximates and assumes, and what its numbers show; empty for the real thing.
    pub surrogate: &'static str,
}

impl Signature {
    /// A kind with keys and nothing inside.
    pub fn new(name: &'static str, doc: &'static str, params: Vec<Param>) -> Self {
        let (children, rising) = (Vec::new(), Vec::new());
        Self { name, doc, params, children, once: false, clauses: false, rising, tick: None, surrogate: "" }
    }

    /// The same, with the condition that no value of these keys is above that of the next one.
    ///
    /// # Panics
    /// One of them is not a key.
    pub fn rising(mut self, keys: &[&'static str]) -> Self {
        assert!(keys.iter().all(|key| self.params.iter().any(|param| param.name == *key)), "no keys: {keys:?}");
        self.rising.extend(keys.windows(2).map(|pair| [pair[0], pair[1]]));
        self
    }

    /// The same with another explanation of a key.
    ///
    /// # Panics
    /// It is not a key.
    pub fn explained(self, key: &str, doc: &'static str) -> Self {
        let default = self.params.iter().find(|param| param.name == key).and_then(|param| param.default);
        self.usually(key, default, doc)
    }

    /// The same with another default of a key, and another explanation.
    ///
    /// # Panics
    /// It is not a key.
    pub fn usually(mut self, key: &str, default: Option<&'static str>, doc: &'static str) -> Self {
        let param = self.params.iter_mut().find(|param| param.name == key);
        let param = param.unwrap_or_else(|| panic!("`{key}` is not a key of `{}`", self.name));
        (param.default, param.doc) = (default, doc);
        self
    }

    /// The same with these blocks.
    pub fn holding(self, children: Vec<Signature>) -> Self {
        Self { children, ..self }
    }

    /// The same as a block that may stand only once in its owner.
    pub fn once(self) -> Self {
        Self { once: true, ..self }
    }

    /// The same, made for ticks of this length (s).
    pub fn made_for(self, tick: f64) -> Self {
        Self { tick: Some(tick), ..self }
    }

    /// The same, with a description of what it approximates; reports repeat it.
    pub fn surrogate(self, surrogate: &'static str) -> Self {
        Self { surrogate, ..self }
    }
}

/// A form: the first word of a declaration.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// The word.
    pub name: &'static str,
    /// One or two sentences for the reference.
    pub doc: &'static str,
    /// The keys of `form name { … }`; `None` if a kind must be named.
    pub plain: Option<Signature>,
    /// Whether a `matrix` block may multiply its declarations.
    pub multiplies: bool,
    /// The kinds of `form name = kind(…)`.
    pub kinds: Vec<Signature>,
}

impl Form {
    /// A form without kinds. Its name, its keys and its documentation are those of this signature.
    pub fn plain(signature: Signature) -> Self {
        let Signature { name, doc, .. } = signature;
        let plain = Some(Signature { doc: "", ..signature });
        Self { name, doc, plain, multiplies: false, kinds: Vec::new() }
    }

    /// A form with these kinds, one of which must be named.
    pub fn of_kinds(name: &'static str, doc: &'static str, kinds: Vec<Signature>) -> Self {
        Self { name, doc, plain: None, multiplies: false, kinds }
    }
}

/// A quantity that a formula may name.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name in formulas.
    pub name: &'static str,
    /// Its dimension; the value is in SI.
    pub dimension: Dimension,
    /// The bounds of its value in all situations, in SI.
    pub bounds: (f64, f64),
    /// The difference of it (SI) that counts as 1 where a requirement compares quantities of different dimensions.
    pub scale: f64,
    /// Whether it is a condition, such as `in_sight`: 1 if it is true and 0 if not.
    pub is_condition: bool,
    /// One sentence for the reference.
    pub doc: &'static str,
}

impl Variable {
    /// What it is, for people: its dimension, or that it is a condition.
    pub fn measures(&self) -> String {
        if self.is_condition { "condition".into() } else { self.dimension.to_string() }
    }

    /// The same with its bounds.
    pub fn within(&self) -> String {
        match self.is_condition {
            true => self.measures(),
            false => format!("{}, {}", self.dimension, bounds(self.bounds.0, self.bounds.1, self.dimension)),
        }
    }
}

/// An event that a reward can answer to.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its name, such as `hit`.
    pub name: &'static str,
    /// The words it takes in parentheses, such as `front`; empty when it takes none.
    pub words: &'static [&'static str],
    /// The form of which it takes a declaration in parentheses instead, such as `requirement`.
    pub declared: Option<&'static str>,
    /// The names of the variables that have a value when it happens.
    pub variables: Vec<&'static str>,
    /// Whether `on` clauses can answer to it; conditions can use all events.
    pub answered: bool,
    /// One sentence for the reference.
    pub doc: &'static str,
}

impl Vocabulary {
    /// The variable or the signal of this number; `None` for the robustness of a requirement.
    pub fn variable(&self, id: VariableId) -> Option<&Variable> {
        match id.of_actor() {
            Some(found) => self.signals.get(found.signal),
            None => self.variables.get(id.0),
        }
    }
}

/// The names that formulas can use.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Vocabulary {
    /// All variables; a formula holds indices into this list.
    pub variables: Vec<Variable>,
    /// The signals of an actor of a cast, as in `child.gap`.
    pub signals: Vec<Variable>,
    pub events: Vec<Event>,
}
