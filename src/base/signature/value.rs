use std::sync::Arc;

use super::{Distribution, Formula, Requirement};

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
    /// A requirement in temporal logic.
    Requirement(Arc<Requirement>),
}
