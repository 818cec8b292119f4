//! The signatures of forms and kinds, as plain data.
//!
//! The grammar knows only shapes: `form name = kind(key: value) { key: value }`. [`Signature`]s declare which forms, kinds
//! and keys exist, with their types, dimensions, ranges and defaults. The checker reads them, the documentation is printed
//! from them, and [`Arguments`] carry the checked values to the code that owns the kind.

mod distribution;
mod formula;
mod requirement;
mod value;
mod value_type;
mod held;
mod arguments;
mod shape;
mod keys;

pub use arguments::Arguments;
pub use distribution::Distribution;
pub use formula::{ActorSignal, BinaryOperator, Bounds, Formula, Function, VariableId};
pub use held::{Choice, Held, Plain};
pub use keys::{Field, Keys};
pub use requirement::{Comparison, Requirement, Temporal, Within};
pub use shape::{Event, Form, Param, Signature, Variable, Vocabulary};
pub use value::{DeclarationId, Value};
pub use value_type::{MAX_MAGNITUDE, MIN_POSITIVE, Type, bounds, short};
