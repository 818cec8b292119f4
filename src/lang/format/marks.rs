//! The information that the layout needs from the parser: where statements and blocks start.

use std::collections::{BTreeMap, BTreeSet};

use pest::Parser;
use pest::iterators::Pair;

use crate::parse::rules::{Rule, ScenarioParser};

/// The parser's information about places in a text.
#[derive(Debug, Default)]
pub struct Marks {
    /// First bytes of statements, and whether it is a property or a clause, which may share a line with others.
    pub statements: BTreeMap<usize, bool>,
    /// Opening braces of blocks.
    pub blocks: BTreeSet<usize>,
}

/// Reads a text that is known to parse; `None` if it does not.
pub fn marks(text: &str) -> Option<Marks> {
    let mut marks = Marks::default();
    let file = ScenarioParser::parse(Rule::file, text).ok()?.next()?;
    marks.take(file).then_some(marks)
}

impl Marks {
    /// Records a pair and everything inside; false when it contains a part that could not be read.
    fn take(&mut self, pair: Pair<Rule>) -> bool {
        let holds_statements = match pair.as_rule() {
            Rule::junk_item | Rule::junk_entry => return false,
            Rule::file | Rule::block => true,
            _ => false,
        };
        if pair.as_rule() == Rule::block {
            self.blocks.insert(pair.as_span().start());
        }
        for inner in pair.into_inner() {
            if holds_statements && !matches!(inner.as_rule(), Rule::EOI | Rule::open_block) {
                let shares_line = matches!(inner.as_rule(), Rule::property | Rule::clause);
                self.statements.insert(inner.as_span().start(), shares_line);
            }
            if !self.take(inner) {
                return false;
            }
        }
        true
    }
}
