/// Declares messages of protobuf as structs. Of each field its number follows, with type and label on the wire as `prost` has them.
///
/// ```text
/// base::messages! {
///     /// A place.
///     Place {
///         name: String = 1 (string),
///         heights: Vec<f64> = 4 (double, repeated),
///     }
/// }
/// ```
#[macro_export]
macro_rules! messages {
    ($($(#[$about:meta])* $Message:ident { $($field:ident: $held:ty = $number:tt ($($wire:tt)*),)* })*) => {
        $(
            $(#[$about])*
            #[derive(Clone, PartialEq, ::prost::Message)]
            pub struct $Message {
                $(#[prost($($wire)*, tag = $number)] pub $field: $held,)*
            }
        )*
    };
}
