//! Statements: editions, imports, parameters, declarations, and the contents of blocks.

use pest::iterators::Pair;

use super::rules::Rule;
use super::{Reader, inner_text, read_number};
use crate::ast::{Clause, Declaration, Entry, File, Import, Name, Param, Property};
use crate::diagnostics;

/// The key that `requirement name = value` gives.
const STATED: &str = "formula";

impl Reader {
    pub(super) fn item(&mut self, pair: Pair<Rule>, file: &mut File) {
        match pair.as_rule() {
            Rule::edition => self.edition(pair, file),
            Rule::import => file.imports.push(self.import(pair)),
            Rule::param => file.params.push(self.param(pair)),
            Rule::declaration => file.declarations.push(self.declaration(pair).into()),
            Rule::junk_item => {
                file.torn = true;
                self.unreadable(&pair, Rule::whole_item);
            }
            Rule::doc | Rule::EOI => {}
            other => unreachable!("file holds no {other:?}"),
        }
    }

    fn edition(&mut self, pair: Pair<Rule>, file: &mut File) {
        let mut inner = pair.into_inner().skip_while(|part| part.as_rule() == Rule::doc);
        let word = inner.next().expect("edition has a word");
        let number = inner.next().expect("edition has a number");
        let span = self.span(&word).to(self.span(&number));
        let before = file.edition.map(|(_, span)| span);
        if before.is_some() || !(file.imports.is_empty() && file.params.is_empty() && file.declarations.is_empty()) {
            self.diagnostics.push(diagnostics::misplaced_edition(span, before));
            if before.is_some() {
                return;
            }
        }
        file.edition = Some((read_number(number.as_str()), self.span(&number)));
    }

    fn import(&mut self, pair: Pair<Rule>) -> Import {
        let mut names = Vec::new();
        let mut path = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::imported => {
                    let inner = part.into_inner().filter(|part| part.as_rule() == Rule::name);
                    names.extend(inner.map(|name| self.name(name)));
                }
                Rule::text => path = Some((inner_text(&part), self.span(&part))),
                _ => {}
            }
        }
        let (path, span) = path.expect("an import has a path");
        Import { names, path, span, source: None }
    }

    fn param(&mut self, pair: Pair<Rule>) -> Param {
        let span = self.span(&pair);
        let mut docs = Vec::new();
        let mut names = Vec::new();
        let mut value = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::doc => docs.push(part.as_str()[3..].trim().to_string()),
                Rule::name => names.push(self.name(part)),
                Rule::value => value = Some(self.value(part)),
                _ => {}
            }
        }
        let mut names = names.into_iter();
        let mut name = || names.next().expect("a parameter has a name and a type");
        let (name, ty) = (name(), name());
        Param { docs, name, ty, value: value.expect("a parameter has a value"), setting: None, span }
    }

    /// A declaration, or a block inside of one.
    fn declaration(&mut self, pair: Pair<Rule>) -> Declaration {
        let span = self.span(&pair);
        let mut docs = Vec::new();
        let mut names: Vec<Name> = Vec::new();
        let mut kind = None;
        let mut entries = Vec::new();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::doc => docs.push(part.as_str()[3..].trim().to_string()),
                Rule::name | Rule::requirement_word => names.push(self.name(part)),
                Rule::value => {
                    let key = Name { text: STATED.into(), span: self.span(&part) };
                    entries.push(Entry::Property(Property { key, value: self.value(part) }));
                }
                Rule::kind => {
                    for part in part.into_inner() {
                        match part.as_rule() {
                            Rule::name => kind = Some(self.name(part)),
                            Rule::arguments => entries.extend(self.arguments(part)),
                            _ => {}
                        }
                    }
                }
                Rule::block => self.block(part, &mut entries),
                Rule::equals => {}
                other => unreachable!("declaration holds no {other:?}"),
            }
        }
        let mut names = names.into_iter();
        let form = names.next().expect("a declaration begins with a name");
        let name = names.next();
        let last = kind.as_ref().or(name.as_ref()).unwrap_or(&form);
        Declaration { docs, head: form.span.to(last.span), span, form, name, kind, entries, is_inline: false }
    }

    /// The arguments in the parentheses of a kind or of a function.
    pub(super) fn arguments(&mut self, list: Pair<Rule>) -> Vec<Entry> {
        let arguments = list.into_inner().filter(|part| part.as_rule() == Rule::argument);
        arguments.map(|part| self.argument(part)).collect()
    }

    fn argument(&mut self, pair: Pair<Rule>) -> Entry {
        let mut key = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => key = Some(self.name(part)),
                Rule::value => {
                    let value = self.value(part);
                    return match key {
                        Some(key) => Entry::Property(Property { key, value }),
                        None => Entry::Bare(value),
                    };
                }
                _ => {}
            }
        }
        unreachable!("an argument has a value")
    }

    fn block(&mut self, pair: Pair<Rule>, entries: &mut Vec<Entry>) {
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::property => entries.push(self.argument(part)),
                Rule::clause => entries.push(Entry::Clause(self.clause(part))),
                Rule::inner => entries.push(Entry::Child(self.declaration(part))),
                Rule::junk_entry => {
                    entries.push(Entry::Unread);
                    self.unreadable(&part, Rule::whole_entry);
                }
                Rule::doc | Rule::open_block => {}
                other => unreachable!("block holds no {other:?}"),
            }
        }
    }

    fn clause(&mut self, pair: Pair<Rule>) -> Clause {
        let (mut names, mut formula) = (Vec::new(), None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::event => names.extend(part.into_inner().filter(|part| part.as_rule() == Rule::name)),
                Rule::value => formula = Some(self.value(part)),
                _ => {}
            }
        }
        let mut names = names.into_iter().map(|name| self.name(name));
        let event = names.next().expect("a clause has an event");
        Clause { event, word: names.next(), formula: formula.expect("a clause has a formula") }
    }
}
