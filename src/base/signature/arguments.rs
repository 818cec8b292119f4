use super::{Held, Value};

/// The checked values of a declaration, one for every key of its signature.
///
/// Reading panics when the key or its type is not the signature's. The checker ensures both, so a panic is a
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

impl Arguments {
    /// Adds the value of a key.
    pub fn push(&mut self, key: &'static str, value: Value) {
        self.values.push((key, value));
    }

    /// Gives a key another value, if there is such a key.
    pub fn replace(&mut self, key: &str, value: Value) {
        if let Some((_, place)) = self.values.iter_mut().find(|(name, _)| *name == key) {
            *place = value;
        }
    }

    /// All keys and values in the signature's order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.values.iter().map(|(key, value)| (*key, value))
    }

    pub fn value(&self, key: &str) -> &Value {
        let found = self.values.iter().find(|(name, _)| *name == key);
        &found.unwrap_or_else(|| panic!("checked: the signature has a key `{key}`")).1
    }

    pub fn read<T: Held>(&self, key: &str) -> T {
        let value = self.value(key);
        T::held(value).unwrap_or_else(|| panic!("checked: `{key}` holds {value:?}"))
    }
}
