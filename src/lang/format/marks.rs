//! What the layout needs from the parser.

use std::collections::BTreeMap;

use pest::Parser;
use pest::iterators::Pair;

use crate::lang::parse::rules::{Rule, ScenarioParser};

/// What a piece of text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leaf {
    /// A name; an opening parenthesis after it belongs to it.
    Name,
    /// A number, a unit or a text.
    Literal,
    /// A sign before a value.
    Prefix,
    /// A `///` line.
    Doc,
}

/// What the parser knows about places in a text.
#[derive(Debug, Default)]
pub struct Marks {
    /// Pieces that are one token: first byte → one past the last, and what they are.
    pub leaves: BTreeMap<usize, (usize, Leaf)>,
    /// First bytes of statements, and whether it is a pair such as may share a line with others.
    pub statements: BTreeMap<usize, bool>,
    /// Opening braces of blocks.
    pub blocks: BTreeMap<usize, ()>,
}

/// Reads a text that is known to parse; `None` when it does not.
pub fn marks(text: &str) -> Option<Marks> {
    let mut marks = Marks::default();
    let file = ScenarioParser::parse(Rule::file, text).ok()?.next()?;
    marks.take(file).then_some(marks)
}

impl Marks {
    /// Notes a pair and all inside; false when it holds what could not be read.
    fn take(&mut self, pair: Pair<Rule>) -> bool {
        let span = pair.as_span();
        let leaf = match pair.as_rule() {
            Rule::junk_item | Rule::junk_entry => return false,
            Rule::name => Some(Leaf::Name),
            Rule::number | Rule::unit | Rule::text => Some(Leaf::Literal),
            Rule::prefix if pair.as_str() == "-" => Some(Leaf::Prefix),
            Rule::doc => Some(Leaf::Doc),
            _ => None,
        };
        if let Some(leaf) = leaf {
            self.leaves.insert(span.start(), (span.end(), leaf));
            return true;
        }
        let holds_statements = matches!(pair.as_rule(), Rule::file | Rule::block);
        if pair.as_rule() == Rule::block {
            self.blocks.insert(span.start(), ());
        }
        for inner in pair.into_inner() {
            if holds_statements && inner.as_rule() != Rule::EOI {
                let is_pair = matches!(inner.as_rule(), Rule::property | Rule::clause);
                self.statements.insert(inner.as_span().start(), is_pair);
            }
            if !self.take(inner) {
                return false;
            }
        }
        true
    }
}
