//! What a form or a kind of the language declares about itself, as plain data.
//!
//! The grammar knows only shapes: `form name = kind(key: value) { key: value }`. Which forms, kinds and keys exist, of
//! what type and dimension, in which range and with which default, is declared by [`Signature`]s. The checker reads them,
//! the documentation is printed from them, and [`Arguments`] carry the checked values to the code that owns the kind.

mod arguments;
mod distribution;
mod formula;
mod param;
mod shape;

pub use arguments::{Arguments, DeclarationId, Value};
pub use distribution::Distribution;
pub use formula::{BinaryOperator, Bounds, Formula, Function, VariableId};
pub use param::{LEAST, MOST, Param, Type, bounds, short};
pub use shape::{Event, Form, Signature, Variable, Vocabulary};
