//! Keys as the fields of a struct, and words as the variants of an enum: declared once, checked, documented and read from there.

use super::{Arguments, Param, Plain, Signature};

/// What a kind takes: its signature, and the struct that its checked values are read into. [`keys!`](crate::keys) declares both.
pub trait Keys: Sized {
    /// The word of the kind; empty for keys that are only a part of others.
    const KIND: &'static str;

    /// The keys with their types, defaults and documentation.
    fn signature() -> Signature;

    /// The values.
    fn read(arguments: &Arguments) -> Self;
}

/// A field of a struct of keys: one key whose type says all, or the keys of another struct.
pub trait Field: Sized {
    /// The keys; a struct of keys has its own names, defaults and texts.
    fn declare(name: &'static str, default: Option<&'static str>, doc: &'static str) -> Vec<Param>;

    /// The value of this key, or of the struct's own keys.
    fn read(arguments: &Arguments, key: &str) -> Self;
}

impl<T: Plain> Field for T {
    fn declare(name: &'static str, default: Option<&'static str>, doc: &'static str) -> Vec<Param> {
        vec![Param::new::<T>(name, T::single(), default, doc)]
    }

    fn read(arguments: &Arguments, key: &str) -> Self {
        arguments.read(key)
    }
}

/// Declares what a kind takes as a struct. It gets a field for each key, and implements [`Keys`](crate::signature::Keys).
///
/// ```
/// base::keys! {
///     /// Follows the car ahead. This text is the kind's in the language reference.
///     pub struct FollowKeys = "follow" {
///         /// Time gap that it keeps. This text is the key's.
///         headway: f64 as positive(TIME) = "1.5 s",
///         /// A key without a default must be given; one of an `Option` may be left out.
///         margin: Option<f64> as within(LENGTH, 0.0, 5.0),
///         /// Whether it honks. The types of truths, texts, points and choices need no more.
///         honks: bool = "false",
///     }
/// }
/// ```
///
/// After `as` stands a variant or a constructor of [`Type`](crate::signature::Type) for a single value; a `Vec` is a list of such values. The names of
/// [`dimensions`](crate::units::dimensions) need no import. `..more: MoreKeys` puts the keys of another struct at its place. After the struct may follow
/// changes, as methods of [`Signature`](crate::signature::Signature): `.made_for(0.05)`.
#[macro_export]
macro_rules! keys {
    (
        $(#[doc = $about:literal])*
        $(#[derive($($more:ident),*)])?
        $visible:vis struct $Keys:ident $(= $kind:literal)? {
            $(
                $(#[doc = $doc:literal])*
                $(..)? $key:ident: $held:ty $(as $single:ident $(($($bound:expr),*))?)? $(= $default:literal)?
            ),* $(,)?
        }
        $(.$change:ident($($with:expr),* $(,)?))*
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, PartialEq $($(, $more)*)?)]
        $visible struct $Keys {
            $($(#[doc = $doc])* pub $key: $held,)*
        }

        impl $crate::signature::Keys for $Keys {
            const KIND: &'static str = concat!($($kind)?);

            fn signature() -> $crate::signature::Signature {
                #[allow(unused_imports)]
                use $crate::units::dimensions::*;
                let params: [Vec<$crate::signature::Param>; _] = [$({
                    let (default, doc) = (None$(.or(Some($default)))?, concat!($($doc),*).trim_ascii());
                    $crate::keys!(@declare $key, default, doc, $held $(, $single $(($($bound),*))?)?)
                }),*];
                $crate::signature::Signature::new(Self::KIND, concat!($($about),*).trim_ascii(), params.concat())
                    $(.$change($($with),*))*
            }

            fn read(arguments: &$crate::signature::Arguments) -> Self {
                Self { $($key: $crate::keys!(@read arguments, $key, $held $(, $single)?)),* }
            }
        }

        impl $crate::signature::Field for $Keys {
            fn declare(_: &'static str, _: Option<&'static str>, _: &'static str) -> Vec<$crate::signature::Param> {
                <Self as $crate::signature::Keys>::signature().params
            }

            fn read(arguments: &$crate::signature::Arguments, _: &str) -> Self {
                <Self as $crate::signature::Keys>::read(arguments)
            }
        }
    };
    (@declare $key:ident, $default:ident, $doc:ident, $held:ty) => {
        <$held as $crate::signature::Field>::declare(stringify!($key), $default, $doc)
    };
    (@declare $key:ident, $default:ident, $doc:ident, $held:ty, $single:ident $(($($bound:expr),*))?) => {
        vec![$crate::signature::Param::new::<$held>(
            stringify!($key),
            $crate::signature::Type::$single $(($($bound),*))?,
            $default,
            $doc,
        )]
    };
    (@read $arguments:ident, $key:ident, $held:ty) => {
        <$held as $crate::signature::Field>::read($arguments, stringify!($key))
    };
    (@read $arguments:ident, $key:ident, $held:ty, $single:ident) => {
        $arguments.read::<$held>(stringify!($key))
    };
}

/// Declares a choice between words as an enum, which implements [`Choice`](crate::signature::Choice).
///
/// ```
/// base::choice! {
///     /// Whether it yields.
///     #[derive(Debug, Clone, Copy, PartialEq)]
///     pub enum Crosswalks {
///         Ignore = "ignore",
///         /// Two words mean this.
///         Yield = "stop" | "yield",
///     }
/// }
/// ```
#[macro_export]
macro_rules! choice {
    (
        $(#[$about:meta])*
        $visible:vis enum $Choice:ident {
            $($(#[$doc:meta])* $Variant:ident = $($word:literal)|+),* $(,)?
        }
    ) => {
        $(#[$about])*
        $visible enum $Choice {
            $($(#[$doc])* $Variant),*
        }

        #[allow(dead_code)]
        impl $Choice {
            /// All of them, in order.
            pub const ALL: [Self; [$(stringify!($Variant)),*].len()] = [$(Self::$Variant),*];

            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($($word)|+ => Some(Self::$Variant),)*
                    _ => None,
                }
            }

            /// Its name in scenarios and tables; the last of several.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => [$($word),+][[$($word),+].len() - 1]),*
                }
            }
        }

        impl $crate::signature::Choice for $Choice {
            const WORDS: &'static [&'static str] = &[$($($word),+),*];

            fn of(word: &str) -> Option<Self> {
                Self::named(word)
            }
        }
    };
}
