use std::borrow::Cow;
use std::marker::PhantomData;

use polars::prelude::{
    BooleanChunked, Column as Values, DataFrame, DataType, Float64Chunked, NamedFrom, PlSmallStr, PolarsResult, Scalar,
    Series, StringChunked, UInt32Chunked, UInt64Chunked,
};

/// What the values of a column are. Gates and tables ask this, and not the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Any other value.
    #[default]
    Plain,
    /// A share of episodes or starts from 0 to 1.
    Share,
    /// A difference of two such shares, from -1 to 1.
    ShareDifference,
    /// A share of runs from 0 to 1.
    RunShare,
    /// Expected severe injuries of one episode from 0 to 1.
    Risk,
    /// The sample standard deviation of a figure over runs.
    Deviation,
    /// A number of pairs in which a figure differs, on which its [`Role::AdjustedP`] depends.
    Differing,
    /// The ends of an interval of a figure.
    LowerBound,
    UpperBound,
    /// The probability of a difference by chance, mostly after a correction for several tests.
    AdjustedP,
}

/// The kind of a column's values: text, counts, numbers or truth values.
pub trait Kind: 'static {
    /// The values of such a column in memory.
    type Array;

    /// The type in a table.
    const TYPE: DataType;

    /// The values of a column.
    ///
    /// # Errors
    /// The column holds something else.
    fn array(column: &Values) -> PolarsResult<&Self::Array>;

    /// The value in a row; `None` if it is missing.
    fn value(array: &Self::Array, row: usize) -> Option<Self>
    where
        Self: Sized;
}

/// A value of a row in a column of a kind, present or possibly missing.
pub trait Cell<K>: Sized {
    /// The column.
    fn series(name: PlSmallStr, values: Vec<Self>) -> Series;
}

macro_rules! kind {
    ($kind:ty, $array:ty, $type:expr, $method:ident $(, $cell:ty)*) => {
        impl Kind for $kind {
            type Array = $array;
            const TYPE: DataType = $type;

            fn array(column: &Values) -> PolarsResult<&$array> {
                column.$method()
            }

            fn value(array: &$array, row: usize) -> Option<Self> {
                array.get(row).map(|value| value.to_owned())
            }
        }
        $(impl Cell<$kind> for $cell {
            fn series(name: PlSmallStr, values: Vec<Self>) -> Series {
                Series::new(name, values)
            }
        })*
    };
}

kind!(String, StringChunked, DataType::String, str, String, Option<String>, &'static str, Option<&'static str>);
kind!(u32, UInt32Chunked, DataType::UInt32, u32, u32, Option<u32>);
kind!(u64, UInt64Chunked, DataType::UInt64, u64, u64, Option<u64>);
kind!(f64, Float64Chunked, DataType::Float64, f64);
kind!(bool, BooleanChunked, DataType::Boolean, bool, bool, Option<bool>);

impl Cell<f64> for f64 {
    fn series(name: PlSmallStr, values: Vec<Self>) -> Series {
        // An empty sum is -0.
        Series::new(name, values.into_iter().map(|value| value + 0.0).collect::<Vec<f64>>())
    }
}

impl Cell<f64> for Option<f64> {
    fn series(name: PlSmallStr, values: Vec<Self>) -> Series {
        Series::new(name, values.into_iter().map(|value| Some(value? + 0.0)).collect::<Vec<Self>>())
    }
}

/// A number whose sign counts, also that of 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signed(pub Option<f64>);

impl Cell<f64> for Signed {
    fn series(name: PlSmallStr, values: Vec<Self>) -> Series {
        Series::new(name, values.into_iter().map(|Signed(value)| value).collect::<Vec<_>>())
    }
}

/// A column of a table: its name, its unit and its meaning. The only place where its name is spelt.
#[derive(Debug)]
pub struct Column<K> {
    /// The name, with the unit at its end.
    pub name: &'static str,
    /// The unit, as people write it; empty without one.
    pub unit: &'static str,
    /// What it means, for `reports/README.md`.
    pub doc: &'static str,
    pub role: Role,
    kind: PhantomData<fn() -> K>,
}

impl<K: Kind> Column<K> {
    /// A column of this name, unit and meaning.
    pub const fn new(name: &'static str, unit: &'static str, doc: &'static str) -> Self {
        Self { name, unit, doc, role: Role::Plain, kind: PhantomData }
    }

    /// With values of another role.
    pub const fn with_role(self, role: Role) -> Self {
        Self { role, ..self }
    }

    /// Its values in a table.
    ///
    /// # Errors
    /// The table has no such column, or it holds something else.
    pub fn read<'a>(&self, table: &'a DataFrame) -> PolarsResult<&'a K::Array> {
        K::array(table.column(self.name)?)
    }

    /// Its value in a row of a table; `None` if it is missing.
    ///
    /// # Errors
    /// As [`Column::read`].
    pub fn value(&self, table: &DataFrame, row: usize) -> PolarsResult<Option<K>> {
        Ok(K::value(self.read(table)?, row))
    }

    pub fn reference(&self) -> ColumnReference {
        let (name, unit, doc) = (self.name.into(), self.unit.into(), self.doc.into());
        ColumnReference { name, unit, doc, holds: K::TYPE, role: self.role, figure: self.name.into() }
    }

    /// The column of a table whose rows give these values.
    pub fn of<'t, R, V: Cell<K>>(&self, value: impl Fn(&R) -> V + 't) -> Entry<'t, R> {
        Entry::new::<K, V>(self.name.into(), self.unit.into(), self.doc.into(), value).of_figure(self.name, self.role)
    }
}

/// Declares columns and families; the comment of each is its meaning: `pub SPEED: Column<f64> = "speed_mps" ["m/s"];`.
macro_rules! columns {
    ($($(#[doc = $doc:literal])+ $visible:vis $NAME:ident: $Kind:ident<$held:ty> = $name:literal $([$unit:literal])? $(as $role:ident)?;)*) => {
        $(
            $(#[doc = $doc])+
            $visible const $NAME: $crate::record::$Kind<$held> =
                $crate::record::$Kind::new($name, concat!($($unit)?), concat!($($doc),+).trim_ascii())
                    $(.with_role($crate::record::Role::$role))?;
        )*
    };
}
pub(crate) use columns;

/// Columns of a table whose rows are `row`: known ones, and those of this table alone, whose comment is their meaning.
///
/// ```text
/// entries! { row: &Driven;
///     TOWN = row.town.clone();
///     /// another meaning than elsewhere
///     EGO_SPEED = row.first_speed;
///     /// speed at the end
///     last_speed_mps: f64 ["m/s"] = row.speed;
///     /// a name that others know
///     named(TRIED): u64 = row.tried;
/// }
/// ```
macro_rules! entries {
    (
        $row:ident: $Row:ty;
        $($(#[doc = $doc:literal])* $name:ident $(($named:expr))? $(: $held:ty)? $([$unit:literal])? $(as $role:ident)? = $value:expr;)*
    ) => {
        [$($crate::record::entries!(@ [$($doc)*] $name [$($named)?] [$($held)?] [$($unit)?] [$($role)?] move |$row: $Row| $value)),*]
    };
    (@ [] $name:ident [] [] [] [] $value:expr) => { $name.of($value) };
    (@ [$($doc:literal)+] $name:ident [] [] [] [] $value:expr) => { $name.of($value).meaning(concat!($($doc),+).trim_ascii()) };
    (@ [$($doc:literal)+] $name:ident [] $($rest:tt)+) => {
        $crate::record::entries!(@ [$($doc)+] $name [stringify!($name)] $($rest)+)
    };
    (@ [$($doc:literal)+] $name:ident [$named:expr] [$held:ty] [$($unit:literal)?] [$($role:ident)?] $value:expr) => {
        $crate::record::Column::<$held>::new($named, concat!($($unit)?), concat!($($doc),+).trim_ascii())
            $(.with_role($crate::record::Role::$role))?
            .of($value)
    };
}
pub(crate) use entries;

/// Columns of the same meaning for several things: `cc_avoids`, `rss_avoids` and so on. The name of the thing comes first.
#[derive(Debug)]
pub struct Family<K> {
    suffix: &'static str,
    unit: &'static str,
    doc: &'static str,
    role: Role,
    kind: PhantomData<fn() -> K>,
}

impl<K: Kind> Family<K> {
    /// The family of columns whose names end with this suffix.
    pub const fn new(suffix: &'static str, unit: &'static str, doc: &'static str) -> Self {
        Self { suffix, unit, doc, role: Role::Plain, kind: PhantomData }
    }

    /// With values of another role.
    pub const fn with_role(self, role: Role) -> Self {
        Self { role, ..self }
    }

    /// What it means.
    pub const fn doc(&self) -> &'static str {
        self.doc
    }

    pub fn name(&self, member: &str) -> String {
        format!("{member}{}", self.suffix)
    }

    /// The values of a member in a table.
    ///
    /// # Errors
    /// The table has no such column, or it holds something else.
    pub fn read<'a>(&self, member: &str, table: &'a DataFrame) -> PolarsResult<&'a K::Array> {
        K::array(table.column(&self.name(member))?)
    }

    /// A member of a table whose rows give these values.
    pub fn of<'t, R, V: Cell<K>>(&self, member: &str, value: impl Fn(&R) -> V + 't) -> Entry<'t, R> {
        let entry = Entry::new::<K, V>(self.name(member).into(), self.unit.into(), self.doc.into(), value);
        entry.of_figure(member.to_owned(), self.role)
    }

    pub fn reference(&self, member: &str) -> ColumnReference {
        let (name, unit, doc) = (self.name(member).into(), self.unit.into(), self.doc.into());
        ColumnReference { name, unit, doc, holds: K::TYPE, role: self.role, figure: member.to_owned().into() }
    }
}

/// The two columns of an interval of a figure, `…_low` and `…_high`, of a table whose rows give these ends.
pub fn interval<'t, R>(
    name: &str,
    figure: &str,
    doc: &'static str,
    ends: impl Fn(&R) -> Option<(f64, f64)> + Copy + 't,
) -> [Entry<'t, R>; 2] {
    let name = |end: &str| format!("{name}_{end}").into();
    let low = Entry::new::<f64, _>(name("low"), "".into(), doc.into(), move |row| Some(ends(row)?.0));
    let high = Entry::new::<f64, _>(name("high"), "".into(), doc.into(), move |row| Some(ends(row)?.1));
    [low.of_figure(figure.to_owned(), Role::LowerBound), high.of_figure(figure.to_owned(), Role::UpperBound)]
}

/// Makes a column of this name from rows.
type WriteRows<'t, R> = dyn Fn(PlSmallStr, &[R]) -> Series + 't;

/// A column of a table whose rows are of type `R`, and the function that reads it from a row.
pub struct Entry<'t, R> {
    reference: ColumnReference,
    write: Box<WriteRows<'t, R>>,
}

/// The documentation of a column, for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnReference {
    pub name: Cow<'static, str>,
    /// The unit; empty without one.
    pub unit: Cow<'static, str>,
    /// What it means.
    pub doc: Cow<'static, str>,
    /// The kind of its values.
    pub holds: DataType,
    pub role: Role,
    /// What it is a value, an end of an interval or a probability of; its own name unless several columns are of one figure.
    pub figure: Cow<'static, str>,
}

impl<'t, R> Entry<'t, R> {
    /// A column of kind `K` whose name is computed, since it belongs to a family, for example one column for each reference driver.
    pub fn new<K: Kind, V: Cell<K>>(
        name: Cow<'static, str>,
        unit: Cow<'static, str>,
        doc: Cow<'static, str>,
        value: impl Fn(&R) -> V + 't,
    ) -> Self {
        let write = move |name: PlSmallStr, rows: &[R]| V::series(name, rows.iter().map(&value).collect());
        let reference = ColumnReference { figure: name.clone(), name, unit, doc, holds: K::TYPE, role: Role::Plain };
        Self { reference, write: Box::new(write) }
    }

    /// The same as a value of this role of a figure.
    pub fn of_figure(mut self, figure: impl Into<Cow<'static, str>>, role: Role) -> Self {
        (self.reference.figure, self.reference.role) = (figure.into(), role);
        self
    }

    /// The same with another meaning.
    pub fn meaning(mut self, doc: impl Into<Cow<'static, str>>) -> Self {
        self.reference.doc = doc.into();
        self
    }

    pub fn reference(&self) -> &ColumnReference {
        &self.reference
    }

    /// The values of some rows.
    pub fn values(&self, rows: &[R]) -> Values {
        (self.write)(self.reference.name.as_ref().into(), rows).into()
    }

    /// The value of one row, `count` times.
    pub(super) fn repeated(&self, row: &R, count: usize) -> Values {
        let one = (self.write)(self.reference.name.as_ref().into(), std::slice::from_ref(row));
        let value = one.get(0).expect("there is one row").into_static();
        Values::new_scalar(self.reference.name.as_ref().into(), Scalar::new(one.dtype().clone(), value), count)
    }
}

/// The columns of a table in their order.
pub struct Table<'t, R> {
    /// The stem of its files.
    pub name: &'static str,
    /// What a row is, and further documentation of the table.
    pub doc: &'static str,
    pub(super) entries: Vec<Entry<'t, R>>,
}

/// The documentation of a table, for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableReference {
    /// The stem of its files.
    pub name: &'static str,
    /// What a row is.
    pub doc: &'static str,
    /// Its columns in their order.
    pub columns: Vec<ColumnReference>,
}

impl<'t, R> Table<'t, R> {
    /// A table without columns.
    pub fn new(name: &'static str, doc: &'static str) -> Self {
        Self { name, doc, entries: Vec::new() }
    }

    /// Adds a column.
    #[must_use]
    pub fn column(mut self, entry: Entry<'t, R>) -> Self {
        self.entries.push(entry);
        self
    }

    /// Adds several columns.
    #[must_use]
    pub fn columns(mut self, entries: impl IntoIterator<Item = Entry<'t, R>>) -> Self {
        self.entries.extend(entries);
        self
    }

    /// The columns of some rows.
    pub fn values(&self, rows: &[R]) -> Vec<Values> {
        self.entries.iter().map(|entry| entry.values(rows)).collect()
    }

    /// The table of some rows, in their order.
    pub fn frame(&self, rows: &[R]) -> DataFrame {
        DataFrame::new(rows.len(), self.values(rows)).expect("the columns of a table have different names")
    }

    pub fn reference(&self) -> TableReference {
        let columns = self.entries.iter().map(|entry| entry.reference().clone()).collect();
        TableReference { name: self.name, doc: self.doc, columns }
    }
}
