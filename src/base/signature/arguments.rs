use super::{Distribution, Formula, Held};

/// Names a declaration of a checked program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DeclarationId(pub usize);

/// A checked value in SI.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// An optional key that was left out.
    Absent,
    /// A quantity in SI.
    Number(f64),
    /// Low and high end in SI.
    Range(f64, f64),
    /// A distribution, in SI.
    Distribution(Distribution),
    /// A whole number.
    Integer(i64),
    /// True or false.
    Boolean(bool),
    /// One of a choice's words.
    Choice(&'static str),
    Text(String),
    /// A point (m).
    Point(f64, f64),
    /// A pose (m, m, rad).
    Pose(f64, f64, f64),
    /// Another declaration.
    Reference(DeclarationId),
    List(Vec<Value>),
    /// A condition.
    Formula(Formula),
}

/// The checked values of a declaration, one for every key of its signature.
///
/// The getters panic when the key or its type is not the signature's. The checker ensures both, so a panic is a
/// bug in the calling code, which the catalogue's test finds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Arguments {
    values: Vec<(&'static str, Value)>,
}

impl FromIterator<(&'static str, Value)> for Arguments {
    fn from_iter<I: IntoIterator<Item = (&'static str, Value)>>(values: I) -> Self {
        Self { values: values.into_iter().collect() }
    }
}

macro_rules! getter {
    ($(#[$doc:meta])* $name:ident, $pattern:pat => $value:expr, $ty:ty) => {
        $(#[$doc])*
        pub fn $name(&self, key: &str) -> $ty {
            match self.value(key) {
                $pattern => $value,
                other => panic!("checked: `{key}` holds {other:?}"),
            }
        }
    };
}

impl Arguments {
    /// Adds the value of a key.
    pub fn push(&mut self, key: &'static str, value: Value) {
        self.values.push((key, value));
    }

    /// All keys and values in the signature's order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.values.iter().map(|(key, value)| (*key, value))
    }

    pub fn value(&self, key: &str) -> &Value {
        let found = self.values.iter().find(|(name, _)| *name == key);
        &found.unwrap_or_else(|| panic!("checked: the signature has a key `{key}`")).1
    }

    /// The value of a key, as this type.
    pub fn read<T: Held>(&self, key: &str) -> T {
        let value = self.value(key);
        T::held(value).unwrap_or_else(|| panic!("checked: `{key}` holds {value:?}"))
    }

    /// Whether an optional key was given.
    pub fn has(&self, key: &str) -> bool {
        *self.value(key) != Value::Absent
    }

    getter!(/// A quantity in SI.
        number, Value::Number(value) => *value, f64);
    getter!(/// Low and high end in SI.
        range, Value::Range(low, high) => (*low, *high), (f64, f64));
    getter!(/// What to draw from, in SI.
        distribution, Value::Distribution(distribution) => distribution, &Distribution);
    getter!(/// A whole number.
        integer, Value::Integer(value) => *value, i64);
    getter!(/// True or false.
        boolean, Value::Boolean(value) => *value, bool);
    getter!(/// The word chosen.
        choice, Value::Choice(word) => word, &'static str);
    getter!(/// A text or a path.
        text, Value::Text(text) => text, &str);
    getter!(/// A point (x, y), in metres.
        point, Value::Point(x, y) => (*x, *y), (f64, f64));
    getter!(/// Another declaration.
        reference, Value::Reference(id) => *id, DeclarationId);
    getter!(/// The members of a list.
        list, Value::List(values) => values, &[Value]);

    /// The declarations a list names.
    pub fn references(&self, key: &str) -> Vec<DeclarationId> {
        let each = |value: &Value| match value {
            Value::Reference(id) => *id,
            other => panic!("checked: `{key}` holds {other:?}"),
        };
        self.list(key).iter().map(each).collect()
    }

    /// The conditions of an optional list.
    pub fn conditions(&self, key: &str) -> Vec<&Formula> {
        if !self.has(key) {
            return Vec::new();
        }
        let mut conditions = Vec::new();
        for value in self.list(key) {
            match value {
                Value::Formula(formula) => conditions.push(formula),
                other => panic!("checked: `{key}` holds {other:?}"),
            }
        }
        conditions
    }

    /// The words of a list.
    pub fn words(&self, key: &str) -> Vec<&'static str> {
        let each = |value: &Value| match value {
            Value::Choice(word) => *word,
            other => panic!("checked: `{key}` holds {other:?}"),
        };
        self.list(key).iter().map(each).collect()
    }

    pub fn condition(&self, key: &str) -> Option<&Formula> {
        match self.value(key) {
            Value::Formula(formula) => Some(formula),
            _ => None,
        }
    }
}
