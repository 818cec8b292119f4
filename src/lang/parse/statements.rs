//! Statements: editions, imports, parameters, declarations, and the contents of blocks.

use pest::iterators::Pair;

use super::mistakes::is_unclosed;
use super::rules::Rule;
use super::{Reader, inner_text, names_of, read_number, words_of};
use crate::ast::{Clause, Declaration, Entry, Expression, ExpressionKind, File, Import, Known, Name, Param, Property};
use crate::diagnostics;
use crate::params::{is_type, type_of};
use base::diagnostic::Span;

/// The form whose values are lists of alternatives.
const MATRIX: &str = "matrix";
/// The key that `requirement name = value` gives.
const STATED: &str = "formula";

impl Reader {
    pub(super) fn item(&mut self, pair: Pair<Rule>, file: &mut File) {
        let before = &pair.get_input()[..pair.as_span().start()];
        let indented = before.ends_with([' ', '\t']) && before.trim_end_matches([' ', '\t']).ends_with('\n');
        if self.headless && indented && !matches!(pair.as_rule(), Rule::doc | Rule::EOI) {
            file.unread.extend(names_of(pair.as_str()));
            return;
        }
        self.headless &= pair.as_rule() == Rule::doc;
        match pair.as_rule() {
            Rule::edition | Rule::wrong_edition => self.edition(pair, file),
            Rule::import | Rule::wrong_import => self.import(pair, file),
            Rule::param => {
                let param = self.param(pair);
                file.params.push(param);
            }
            Rule::wrong_param => {
                file.unread.extend(names_of(pair.as_str()));
                self.wrong_param(&pair);
            }
            Rule::declaration | Rule::wrong_declaration => {
                let declaration = self.declaration(pair);
                file.declarations.push(declaration.into());
            }
            Rule::hash => self.mistake(&pair),
            Rule::junk_item => self.junk_item(&pair, indented, file),
            Rule::doc | Rule::EOI => {}
            other => unreachable!("file holds no {other:?}"),
        }
    }

    fn edition(&mut self, pair: Pair<Rule>, file: &mut File) {
        let (wrong, text) = (pair.as_rule() == Rule::wrong_edition, pair.as_str());
        let whole = self.span(&pair);
        let mut inner = pair.into_inner().skip_while(|part| part.as_rule() == Rule::doc);
        let word = inner.next().expect("edition has a word");
        let number = inner.next().expect("edition has a number");
        let span = self.span(&word).to(self.span(&number));
        if wrong {
            let meant = format!("edition {}", number.as_str());
            // Comments follow, which are no part of the mistake.
            let quoted = text[span.end - whole.start..].starts_with('"');
            self.report(Span { end: span.end + usize::from(quoted), ..span }, "write `edition 1`", Some(&meant));
            file.edition.get_or_insert((read_number(number.as_str()), self.span(&number)));
            return;
        }
        let before = file.edition.map(|(_, span)| span);
        if before.is_some() || !(file.imports.is_empty() && file.params.is_empty() && file.declarations.is_empty()) {
            self.diagnostics.push(diagnostics::misplaced_edition(span, before));
            if before.is_some() {
                return;
            }
        }
        file.edition = Some((read_number(number.as_str()), self.span(&number)));
    }

    fn import(&mut self, pair: Pair<Rule>, file: &mut File) {
        let mut names = Vec::new();
        for part in pair.into_inner() {
            let path = match part.as_rule() {
                Rule::imported => {
                    names.extend(part.into_inner().map(|name| self.name(name)));
                    continue;
                }
                Rule::import_like if part.as_str() != "import" => {
                    self.mistake(&part);
                    continue;
                }
                Rule::text => inner_text(&part),
                Rule::bare_path => {
                    self.mistake(&part);
                    // The path may not be complete yet; then there is no file to look for, and its names are not known.
                    if is_unclosed(part.as_str()) && !part.as_str().ends_with(".scn") {
                        file.torn = true;
                        return;
                    }
                    part.as_str().trim_matches(['"', '\'', '“', '”']).to_string()
                }
                _ => continue,
            };
            let span = self.span(&part);
            file.imports.push(Import { names: std::mem::take(&mut names), path, span, source: None });
        }
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
                Rule::value => value = Some(self.whole_value(part)),
                _ => {}
            }
        }
        let mut names = names.into_iter();
        let mut name = || names.next().expect("a parameter has a name and a type");
        let (name, ty) = (name(), name());
        Param { docs, name, ty, value: value.expect("a parameter has a value"), setting: None, span }
    }

    /// Reports a parameter whose head is not `param name: type =`.
    fn wrong_param(&mut self, pair: &Pair<Rule>) {
        let mut inner = pair.clone().into_inner().skip_while(|part| part.as_rule() == Rule::doc);
        let head = inner.next().expect("a parameter has a head");
        let value = inner.next().expect("a parameter has a value");
        let (text, from) = (head.as_str().trim_end(), head.as_span().start());
        let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
        let words: Vec<&str> = text.split(|c: char| !is_part(c)).filter(|word| !word.is_empty()).collect();
        let sign = pair.get_input()[from + text.len()..value.as_span().start()].trim();
        let place = self.place(from, from + text.len());
        let own = ["param", "Param", "PARAM", "parameter", "let", "var", "const"].contains(&words[0]);
        let type_of_value = type_of(value.as_str().trim());
        self.mistakes += 1;
        let said = match (own, &words[usize::from(own)..], text.matches(':').count()) {
            // `param name: type: value`
            (true, [_, _], 1) if sign.starts_with(':') && text.starts_with("param ") => {
                let colon = from + text.len() + pair.get_input()[from + text.len()..].find(':').unwrap_or(0);
                diagnostics::mistake(self.place(colon, colon + 1), "the value of a parameter follows `=`", Some(" ="))
            }
            (_, [name, ty], 1 | 2) if is_type(ty) => {
                diagnostics::mistake(place, "write `param name: type = value`", Some(&format!("param {name}: {ty}")))
            }
            // `param type name = value`, `type name = value`
            (_, [ty, name], 0) if is_type(ty) => diagnostics::untyped_param(place, &format!("param {name}"), Some(ty)),
            (true, [name], 0) => diagnostics::untyped_param(place, &format!("param {name}"), type_of_value),
            (false, [name], 0) if type_of_value.is_some() => {
                diagnostics::untyped_param(place, &format!("param {name}"), type_of_value)
            }
            (false, [form, name], 0) => {
                // A comment after the value is no part of it.
                let written = value.as_str();
                let path = written.strip_prefix('"').and_then(|rest| rest.split('"').next()).unwrap_or_default();
                let end = if path.is_empty() { 0 } else { path.len() + 2 };
                let start = value.as_span().start();
                let whole = if end > 0 { place.to(self.place(start, start + end)) } else { place };
                diagnostics::value_for_kind(whole, (form, name), path)
            }
            _ => diagnostics::syntax(place, "write `param name: type = value`".into()),
        };
        self.diagnostics.push(said);
    }

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
                    entries.push(Entry::Property(Property { key, value: self.whole_value(part) }));
                }
                Rule::odd_name => {
                    self.mistake(&part);
                    let text = part.as_str().trim_matches('"').replace(|c: char| !c.is_ascii_alphanumeric(), "_");
                    names.push(Name { text, span: self.span(&part) });
                }
                Rule::stray_colon | Rule::stray_equals => self.mistake(&part),
                Rule::kind | Rule::colon_kind => {
                    if part.as_rule() == Rule::colon_kind {
                        self.mistake(&part);
                    }
                    let mut inner = part.into_inner();
                    kind = inner.next().map(|word| self.name(word));
                    for list in inner {
                        entries.extend(self.arguments(list, true));
                    }
                }
                Rule::block => {
                    let matrix = names.first().is_some_and(|form| form.text == MATRIX);
                    self.block(part, matrix, &mut entries);
                }
                other => unreachable!("declaration holds no {other:?}"),
            }
        }
        let mut names = names.into_iter();
        let form = names.next().expect("a declaration begins with a name");
        let name = names.next();
        let last = kind.as_ref().or(name.as_ref()).unwrap_or(&form);
        Declaration { docs, head: form.span.to(last.span), span, form, name, kind, entries, is_inline: false }
    }

    /// The arguments in the parentheses of a kind (`keyed`) or of a function.
    pub(super) fn arguments(&mut self, list: Pair<Rule>, keyed: bool) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut gap = None;
        for part in list.into_inner() {
            if part.as_rule() == Rule::gap {
                gap = Some(part);
                continue;
            }
            let entry = self.argument(part);
            let Some(gap) = gap.take() else {
                entries.push(entry);
                continue;
            };
            match (entries.pop(), entry) {
                // `idm(reaction 2 s)`
                (
                    Some(Entry::Bare(Expression { kind: ExpressionKind::Name(text), span })),
                    Entry::Bare(value @ Expression { kind: ExpressionKind::Number { .. }, .. }),
                ) if keyed && gap.as_str().is_empty() => {
                    self.report(span, "a key is followed by `:`", Some(&format!("{text}:")));
                    entries.push(Entry::Property(Property { key: Name { text, span }, value }));
                }
                (last, entry) => {
                    let end = match &last {
                        Some(Entry::Property(Property { value, .. }) | Entry::Bare(value)) => value.span.end,
                        _ => gap.as_span().start(),
                    };
                    self.missing_comma(&gap, end);
                    entries.extend(last);
                    entries.push(entry);
                }
            }
        }
        entries
    }

    fn argument(&mut self, pair: Pair<Rule>) -> Entry {
        let mut inner = pair.into_inner();
        let first = inner.next().expect("an argument has a value");
        let Some(next) = inner.next() else { return Entry::Bare(self.whole_value(first)) };
        let key = self.name(first);
        let value = match inner.next() {
            Some(value) => {
                self.mistake(&next);
                value
            }
            None => next,
        };
        Entry::Property(Property { key, value: self.whole_value(value) })
    }

    fn block(&mut self, pair: Pair<Rule>, matrix: bool, entries: &mut Vec<Entry>) {
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::property | Rule::wrong_property => entries.push(self.property(part, matrix)),
                Rule::clause | Rule::wrong_clause => {
                    let entry = self.clause(part);
                    entries.push(entry);
                }
                Rule::declaration | Rule::wrong_declaration => {
                    let child = self.declaration(part);
                    entries.push(Entry::Child(child));
                }
                Rule::junk_entry => {
                    // The value before it is only a part of the intended one.
                    if let Some(Entry::Property(Property { value, .. }) | Entry::Clause(Clause { formula: value, .. })) =
                        entries.last_mut()
                        && self.goes_on(value, &part)
                    {
                        value.kind = ExpressionKind::Known(Known::Wrong);
                    }
                    if let Some(Entry::Child(child)) = entries.last_mut() {
                        child.entries.extend(super::unread_arguments(&part));
                    }
                    entries.push(Entry::Unread(words_of(part.as_str())));
                    self.error_node(&part, Rule::whole_entry);
                }
                Rule::hash => self.mistake(&part),
                Rule::doc => {}
                other => unreachable!("block holds no {other:?}"),
            }
        }
    }

    fn property(&mut self, pair: Pair<Rule>, matrix: bool) -> Entry {
        let source = pair.get_input();
        let mut key = None;
        let mut value = None;
        let mut rest = Vec::new();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => key = Some(self.name(part)),
                Rule::odd_key => {
                    let part = part.into_inner().next().expect("a key has words");
                    self.mistake(&part);
                    key = Some(Name { text: part.as_str().replace(['-', ' '], "_"), span: self.span(&part) });
                }
                Rule::no_colon => {
                    let key = key.as_ref().expect("a key comes first");
                    self.report(key.span, "a key is followed by `:`", Some(&format!("{}:", key.text)));
                }
                Rule::colon_sign => self.mistake(&part),
                Rule::value => value = Some(self.whole_value(part)),
                Rule::unlisted => rest.extend(part.into_inner().map(|value| self.value(value))),
                _ => {}
            }
        }
        let key = key.expect("a property has a key");
        let mut value = value.expect("a property has a value");
        if !rest.is_empty() {
            self.unlisted(&value, &rest, source, matrix);
            value.kind = ExpressionKind::Known(Known::Wrong);
        }
        Entry::Property(Property { key, value })
    }

    fn clause(&mut self, pair: Pair<Rule>) -> Entry {
        let words = words_of(pair.as_str());
        let mut event: Option<Name> = None;
        let mut word = None;
        let mut formula = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::event => (event, word) = self.event(part),
                Rule::arrow_sign => self.mistake(&part),
                Rule::odd_event => {
                    let mut inner = part.into_inner();
                    event = inner.next().map(|name| self.name(name));
                    if let Some(odd) = inner.next() {
                        self.mistake(&odd);
                        let text = odd.as_str().trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '_');
                        word = Some(Name { text: text.to_string(), span: self.span(&odd) });
                    }
                }
                Rule::braced => {
                    self.mistake(&part);
                    (event, word) = self.event(part.into_inner().next().expect("braces follow an event"));
                }
                Rule::several => {
                    self.mistake(&part);
                    return Entry::Unread(words);
                }
                Rule::unmarked => {
                    let mut inner = part.into_inner();
                    let first = inner.next().expect("a clause has an event");
                    if first.as_rule() == Rule::on_like {
                        self.mistake(&first);
                        (event, word) = self.event(inner.next().expect("a clause has an event"));
                    } else {
                        let (name, of) = self.event(first);
                        let mut name = name.expect("an event has a name");
                        let bare = name.text.trim_start_matches("on").trim_start_matches('_').to_string();
                        name.text = if bare.is_empty() { name.text } else { bare };
                        self.report(name.span, "a clause starts with `on`", Some(&format!("on {}", name.text)));
                        (event, word) = (Some(name), of);
                    }
                }
                Rule::value => formula = Some(self.whole_value(part)),
                _ => {}
            }
        }
        let event = event.expect("a clause has an event");
        Entry::Clause(Clause { event, word, formula: formula.expect("a clause has a formula") })
    }

    fn event(&mut self, pair: Pair<Rule>) -> (Option<Name>, Option<Name>) {
        let mut inner = pair.into_inner();
        let name = inner.next().map(|name| self.name(name));
        (name, inner.next().map(|word| self.name(word)))
    }
}
