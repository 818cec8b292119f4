//! The signatures of forms and kinds, as plain data.
//!
//! The grammar knows only shapes: `form name = kind(key: value) { key: value }`. [`Signature`]s declare which forms, kinds
//! and keys exist, with their types, dimensions, ranges and defaults. The checker reads them, the documentation is printed
//! from them, and [`Arguments`] carry the checked values to the code that owns the kind.

mod arguments;
mod distribution;
mod formula;
mod keys;
mod param;
mod requirement;
mod shape;

pub use arguments::{Arguments, DeclarationId, Value};
pub use distribution::Distribution;
pub use formula::{ActorSignal, BinaryOperator, Bounds, Formula, Function, VariableId};
pub use keys::{Choice, Field, Held, Keys, Plain};
pub use param::{MAX_MAGNITUDE, MIN_POSITIVE, Param, Type, bounds, short};
pub use requirement::{Comparison, Requirement, Temporal, Within};
pub use shape::{Event, Form, Signature, Variable, Vocabulary};
