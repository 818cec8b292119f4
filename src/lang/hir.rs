//! The checked program: every name resolved, every value in SI, every default filled in, every node with its place.

use std::sync::Arc;

use base::diagnostic::{SourceId, Span};
use base::signature::{Arguments, DeclarationId, Formula, Keys};

/// All declarations of all files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// The declarations; a [`DeclarationId`] is an index into them. Variants of a program share equal ones.
    pub declarations: Vec<Arc<Declaration>>,
    /// The files the user named.
    pub roots: Vec<SourceId>,
    /// The parameters of all files.
    pub params: Vec<Param>,
}

/// Names a parameter: its file, and its index among the parameters there.
pub type ParamId = (SourceId, usize);

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    pub id: ParamId,
    pub name: String,
    /// The word for its type.
    pub ty: String,
    /// Its documentation, one string a line.
    pub docs: Vec<String>,
    /// Its value as written.
    pub value: String,
    pub used: bool,
    /// The place of its name.
    pub span: Span,
}

impl Program {
    pub fn get(&self, id: DeclarationId) -> &Declaration {
        &self.declarations[id.0]
    }

    /// The declaration at an index of a file.
    pub fn place(&self, source: SourceId, index: usize) -> DeclarationId {
        // They are in the order of the files.
        let first = self.declarations.partition_point(|declaration| declaration.source < source);
        self.declarations[first + index].id
    }

    /// The declarations of a form in the files the user named, in order.
    pub fn of_form<'a>(&'a self, form: &'a str) -> impl Iterator<Item = &'a Declaration> {
        let in_roots = |source| self.roots.contains(&source);
        self.declarations.iter().map(Arc::as_ref).filter(move |d| d.form == form && in_roots(d.source))
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    pub id: DeclarationId,
    /// The file that contains it.
    pub source: SourceId,
    pub form: &'static str,
    /// Its kind; the form's own name when it has none.
    pub kind: &'static str,
    pub name: String,
    /// Its documentation, one string a line.
    pub docs: Vec<String>,
    /// Whether it is written in place of a name.
    pub is_inline: bool,
    /// The parameters that it depends on: those it names, and those that they name.
    pub params: Vec<ParamId>,
    /// Its contents.
    pub block: Block,
}

/// The contents of a declaration.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// The word that names the signature.
    pub word: &'static str,
    /// The name of a nested block.
    pub name: Option<String>,
    /// A value for every key.
    pub arguments: Arguments,
    /// The places of the given keys' values.
    pub places: Vec<(&'static str, Span)>,
    /// The places of the members of given lists.
    pub members: Vec<(&'static str, Vec<Span>)>,
    /// Nested blocks, in order.
    pub children: Vec<Block>,
    /// `on` clauses, in order.
    pub clauses: Vec<Clause>,
    /// Where the block starts.
    pub head: Span,
}

impl Block {
    /// The values of its keys.
    pub fn keys<K: Keys>(&self) -> K {
        K::read(&self.arguments)
    }

    /// The blocks of a kind inside, each with the values of its keys.
    pub fn inside<K: Keys>(&self) -> impl Iterator<Item = (&Self, K)> {
        self.nested(K::KIND).map(|child| (child, child.keys()))
    }

    /// The place of a key's value, or the block's head for a default.
    pub fn place(&self, key: &str) -> Span {
        self.places.iter().find(|(name, _)| *name == key).map_or(self.head, |(_, span)| *span)
    }

    /// The places of the members of a key's list; empty for a default.
    pub fn members(&self, key: &str) -> &[Span] {
        self.members.iter().find(|(name, _)| *name == key).map_or(&[], |(_, spans)| spans)
    }

    pub fn nested<'a>(&'a self, word: &'a str) -> impl Iterator<Item = &'a Block> {
        self.children.iter().filter(move |child| child.word == word)
    }
}

/// `on event(word) => formula`
#[derive(Debug, Clone, PartialEq)]
pub struct Clause {
    pub event: &'static str,
    /// The word in parentheses.
    pub word: Option<&'static str>,
    /// The declaration in parentheses.
    pub subject: Option<DeclarationId>,
    /// Its variables after those of the vocabulary are the robustness of requirements, by their declarations.
    pub formula: Formula,
    /// The event's place.
    pub span: Span,
}
