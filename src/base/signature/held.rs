use std::sync::Arc;

use super::{DeclarationId, Distribution, Formula, Requirement, Type, Value};

/// A type in Rust for the values of a key.
pub trait Held: Sized {
    /// Whether the key may be left out without a default.
    const OPTIONAL: bool = false;

    /// The type of the key, if that of one value is this.
    fn type_of(single: Type) -> Type {
        single
    }

    /// The value; `None` if it is of another type.
    fn held(value: &Value) -> Option<Self>;
}

/// A type in Rust that says all about the type of a key.
pub trait Plain: Held {
    fn single() -> Type;
}

/// An enum whose variants are words; [`choice!`](crate::choice) declares it.
pub trait Choice: Copy + 'static {
    /// The words of all variants, in their order.
    const WORDS: &'static [&'static str];

    /// The variant of a word.
    fn of(word: &str) -> Option<Self>;
}

impl<C: Choice> Held for C {
    fn held(value: &Value) -> Option<Self> {
        if let Value::Choice(word) = value { Self::of(word) } else { None }
    }
}

impl<C: Choice> Plain for C {
    fn single() -> Type {
        Type::Choice(C::WORDS)
    }
}

impl<T: Held> Held for Option<T> {
    const OPTIONAL: bool = true;

    fn type_of(single: Type) -> Type {
        T::type_of(single)
    }

    fn held(value: &Value) -> Option<Self> {
        if *value == Value::Absent { Some(None) } else { T::held(value).map(Some) }
    }
}

impl<T: Held> Held for Vec<T> {
    fn type_of(single: Type) -> Type {
        Type::List(Box::new(T::type_of(single)))
    }

    fn held(value: &Value) -> Option<Self> {
        if let Value::List(members) = value { members.iter().map(T::held).collect() } else { None }
    }
}

impl<T: Plain> Plain for Option<T> {
    fn single() -> Type {
        T::single()
    }
}

impl<T: Plain> Plain for Vec<T> {
    fn single() -> Type {
        T::single()
    }
}

/// A value of any type.
impl Held for Value {
    fn held(value: &Value) -> Option<Self> {
        Some(value.clone())
    }
}

macro_rules! held {
    ($($pattern:pat => $held:expr, $as:ty $(, $single:expr)?;)*) => {
        $(
            impl Held for $as {
                fn held(value: &Value) -> Option<Self> {
                    if let $pattern = value { $held } else { None }
                }
            }
            $(
                impl Plain for $as {
                    fn single() -> Type {
                        $single
                    }
                }
            )?
        )*
    };
}

held! {
    Value::Number(number) => Some(*number), f64;
    Value::Integer(number) => Some(*number), i64;
    Value::Integer(number) => u32::try_from(*number).ok(), u32;
    Value::Integer(number) => u64::try_from(*number).ok(), u64;
    Value::Integer(number) => usize::try_from(*number).ok(), usize;
    Value::Range(low, high) => Some((*low, *high)), (f64, f64);
    Value::Distribution(distribution) => Some(distribution.clone()), Distribution;
    Value::Formula(formula) => Some(formula.clone()), Formula;
    Value::Requirement(requirement) => Some(requirement.clone()), Arc<Requirement>;
    Value::Reference(id) => Some(*id), DeclarationId;
    Value::Boolean(truth) => Some(*truth), bool, Type::Boolean;
    Value::Text(text) => Some(text.clone()), String, Type::Text;
    Value::Point(x, y) => Some([*x, *y]), [f64; 2], Type::Point;
    Value::Pose(x, y, yaw) => Some([*x, *y, *yaw]), [f64; 3], Type::Pose;
}
