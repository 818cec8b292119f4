//! The untyped tree: the statements as written, with a span on every node. No name is resolved at this stage.

use std::sync::Arc;

use base::diagnostic::{SourceId, Span};
use base::signature::{DeclarationId, Distribution};
use base::units::Dimension;

/// A word with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    /// The word.
    pub text: String,
    /// Its place.
    pub span: Span,
}

#[derive(Debug, Clone, PartialEq)]
pub struct File {
    pub source: SourceId,
    /// The number after `edition`, with its place.
    pub edition: Option<(f64, Span)>,
    /// The files it imports.
    pub imports: Vec<Import>,
    /// Its parameters, in order.
    pub params: Vec<Param>,
    /// Whether the file contains statements that could not be read; the names that they declare are unknown.
    pub torn: bool,
    /// Its declarations, in order; variants of a file share equal ones.
    pub declarations: Vec<Arc<Declaration>>,
}

/// `import "path"`, `import a, b from "path"`
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The names to take over; all when none is named.
    pub names: Vec<Name>,
    /// The path as written.
    pub path: String,
    /// The place of the path.
    pub span: Span,
    /// The file it refers to, once loaded.
    pub source: Option<SourceId>,
}

/// `param name: type = value`
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// The text of its `///` lines.
    pub docs: Vec<String>,
    pub name: Name,
    /// The word for its type.
    pub ty: Name,
    pub value: Expression,
    /// Where it is set to that value, if not in its declaration.
    pub setting: Option<Span>,
    /// All of it, with its documentation.
    pub span: Span,
}

/// `form name = kind(…) { … }`
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// The text of its `///` lines.
    pub docs: Vec<String>,
    /// The first word.
    pub form: Name,
    /// The second word.
    pub name: Option<Name>,
    /// The word after `=`.
    pub kind: Option<Name>,
    /// Everything in parentheses and braces.
    pub entries: Vec<Entry>,
    /// Whether it is written in place of a name; then its name is derived and names nothing in the files.
    pub is_inline: bool,
    /// From the form to the name or kind, for messages.
    pub head: Span,
    /// All of it, with its documentation.
    pub span: Span,
}

/// Something inside a declaration.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// `key: value`
    Property(Property),
    /// `on event(word) => formula`
    Clause(Clause),
    /// A nested declaration.
    Child(Declaration),
    /// A value without a key, in parentheses.
    Bare(Expression),
    /// Something that could not be read.
    Unread,
}

/// `key: value`
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    pub key: Name,
    pub value: Expression,
}

/// `on event(word) => formula`
#[derive(Debug, Clone, PartialEq)]
pub struct Clause {
    pub event: Name,
    /// The word in parentheses.
    pub word: Option<Name>,
    pub formula: Expression,
}

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    pub kind: ExpressionKind,
    /// Its place.
    pub span: Span,
}

#[derive(Debug, Clone, PartialEq)]
pub enum ExpressionKind {
    /// `7`, `7 m`
    Number {
        /// The number as written.
        value: f64,
        /// The unit as written.
        unit: Option<Name>,
    },
    /// `"text"`
    Text(String),
    /// A bare word.
    Name(String),
    /// `function(a, b)`
    Call {
        function: Name,
        arguments: Vec<Expression>,
        /// The key of each argument, if it has one: a kind in place of a name has keys.
        keys: Vec<Option<Name>>,
    },
    /// A kind in place of a name, which has become a declaration; the parser never makes this node.
    Inline {
        /// The form of the declaration.
        form: &'static str,
        /// Its place among the declarations of the file.
        place: usize,
    },
    /// `-a`
    Negate(Box<Expression>),
    /// `not a`
    Not(Box<Expression>),
    /// `a + b`
    Binary {
        /// The operator's sign.
        operator: Operator,
        /// Left side.
        left: Box<Expression>,
        /// Right side.
        right: Box<Expression>,
    },
    /// `a .. b`
    Range(Box<Expression>, Box<Expression>),
    /// `a in unit`
    Conversion(Box<Expression>, Name),
    /// `(a, b)`; one member is a parenthesis.
    Group(Vec<Expression>),
    /// `[a, b]`
    List(Vec<Expression>),
    /// The value of a parameter; the parser never makes this node.
    Known(Known),
}

/// The checked value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Known {
    /// A quantity in SI.
    Quantity(f64, Dimension),
    /// A distribution of a quantity of this dimension, in SI.
    Distribution(Distribution, Dimension),
    /// A declaration of this form.
    Declaration(&'static str, DeclarationId),
    /// The parameter itself is wrong, which has been reported.
    Wrong,
}

/// The sign between two expressions.
pub use base::signature::BinaryOperator as Operator;
