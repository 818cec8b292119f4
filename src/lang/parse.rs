//! Text → AST. Only this file and `format::marks` know pest.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::{Pair, Pairs};
use std::iter::Peekable;
use std::ops::Range;
use std::sync::Arc;

use super::ast::{
    Clause, Declaration, Entry, Expression, ExpressionKind, File, Import, Known, Name, Operator, Param, Property,
};
use super::{brackets, codes, repair};
use crate::diagnostic::{Diagnostic, SourceId, Span};
use crate::signature::short;
use crate::units::parse_unit;

#[allow(missing_docs, reason = "the derive writes the enum; the grammar documents the rules")]
pub(super) mod rules {
    /// The parser made from the grammar files.
    #[derive(pest_derive::Parser)]
    #[grammar = "../grammar/lexical.pest"]
    #[grammar = "../grammar/scenario.pest"]
    pub(in crate::lang) struct ScenarioParser;
}
use rules::{Rule, ScenarioParser};

/// The longest file that is read (bytes).
const MAX_BYTES: usize = 4 << 20;

/// Most terms and operators of one expression; later phases walk it recursively.
const MAX_TERMS: usize = 500;

/// Most statements of no known shape that are read once more to tell what is wrong with them; a file with more of them is no
/// scenario.
const MOST_REREAD: usize = 1000;

/// How many bytes are given to the parser at once, if statements allow: it remembers all that it has found in them until it ends.
const LEAST_PART: usize = 1 << 10;

/// Reads a file's text into a tree, with everything that could be read and one diagnostic for each statement that
/// could not.
pub fn parse(source: SourceId, text: &str) -> (File, Vec<Diagnostic>) {
    let whole = 0..text.len();
    if text.len() > MAX_BYTES {
        let span = Span { source, start: 0, end: 0 };
        return (File { torn: true, ..empty(source) }, vec![codes::too_large(span, text.len(), MAX_BYTES)]);
    }
    match brackets::scan(source, text) {
        Ok(starts) => {
            let read = read_parts(source, text, parts(&starts, text.len(), LEAST_PART));
            // A statement may go on where another seemed to begin.
            if read.1.is_empty() { read } else { read_parts(source, text, [whole]) }
        }
        Err(diagnostic) => {
            let balanced = brackets::balance(source, text, *diagnostic);
            let (mut file, diagnostics) = match balanced.text {
                Some(text) => read_parts(source, &text, [whole]),
                None => (File { torn: true, ..empty(source) }, Vec::new()),
            };
            file.unread.splice(0..0, balanced.left_out.iter().flat_map(|part| names_of(&text[part.clone()])));
            (file, [balanced.diagnostics, diagnostics].concat())
        }
    }
}

/// The text between places where statements may begin, in parts of at least so many bytes.
fn parts(starts: &[usize], end: usize, least: usize) -> Vec<Range<usize>> {
    let (mut parts, mut begin) = (Vec::new(), 0);
    for start in starts {
        if *start >= begin + least {
            parts.push(begin..*start);
            begin = *start;
        }
    }
    parts.push(begin..end);
    parts
}

/// Reads parts of a text, each of whole statements.
fn read_parts(source: SourceId, text: &str, parts: impl IntoIterator<Item = Range<usize>>) -> (File, Vec<Diagnostic>) {
    let mut reader = Reader { source, offset: 0, headless: false, diagnostics: Vec::new() };
    let mut file = empty(source);
    for part in parts {
        reader.offset = part.start;
        match ScenarioParser::parse(Rule::file, &text[part]) {
            Ok(mut pairs) => {
                for pair in pairs.next().expect("a parse gives its rule").into_inner() {
                    reader.item(pair, &mut file);
                }
            }
            Err(error) => {
                file.torn = true;
                reader.diagnostics.push(reader.syntax_error(&error, 0, 0));
            }
        }
    }
    (file, reader.diagnostics)
}

fn empty(source: SourceId) -> File {
    let (imports, params, declarations) = (Vec::new(), Vec::new(), Vec::new());
    File { source, edition: None, imports, params, unread: Vec::new(), torn: false, declarations }
}

/// The words of what may be left over from a declaration: parentheses that could not be read.
fn unread_arguments(junk: &Pair<Rule>) -> Option<Entry> {
    junk.as_str().starts_with('(').then(|| Entry::Unread(words_of(junk.as_str())))
}

/// The words of a text, some of them if there are many.
fn words_of(text: &str) -> Vec<String> {
    const MOST: usize = 64;
    let part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let words =
        text.split(|c: char| !part(c)).filter(|word| word.starts_with(|first: char| first.is_ascii_lowercase()));
    words.take(MOST).map(str::to_string).collect()
}

/// The words among which the name is that a statement declares: those before its first `=`, `{` or `(`.
fn names_of(statement: &str) -> impl Iterator<Item = String> {
    /// Form, name, type, and one that does not belong there.
    const MOST: usize = 4;
    let lines = statement.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let first = lines.into_iter().find(|line| !line.is_empty()).unwrap_or_default();
    let head = first.split(['=', '{', '(']).next().unwrap_or_default();
    let words = head.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let words: Vec<String> = words.take(MOST).map(str::to_string).collect();
    words.into_iter()
}

/// Reads statements of a text that hold no mistake: those of the standard library.
pub(super) fn parse_part(source: SourceId, text: &str, part: Range<usize>) -> File {
    let (file, diagnostics) = read_parts(source, text, [part]);
    assert!(diagnostics.is_empty(), "the library can be read: {diagnostics:?}");
    file
}

/// Reads a value that stands alone, such as a default in a signature.
pub(super) fn parse_value(source: SourceId, text: &str) -> Result<Expression, Box<Diagnostic>> {
    match plain_quantity(source, text) {
        Some(kind) => Ok(Expression { kind, span: Span { source, start: 0, end: text.len() } }),
        None => parse_any_value(source, text),
    }
}

fn parse_any_value(source: SourceId, text: &str) -> Result<Expression, Box<Diagnostic>> {
    let mut reader = Reader { source, offset: 0, headless: false, diagnostics: Vec::new() };
    brackets::scan(source, text)?;
    match ScenarioParser::parse(Rule::whole_value, text) {
        Ok(mut pairs) => {
            let value = pairs.next().and_then(|whole| whole.into_inner().next()).expect("whole_value holds a value");
            Ok(reader.value(value))
        }
        Err(error) => Err(Box::new(reader.syntax_error(&error, 0, 0))),
    }
}

/// What most defaults are, for which the grammar is a long way: a number, perhaps with a unit after one blank.
fn plain_quantity(source: SourceId, text: &str) -> Option<ExpressionKind> {
    let (number, unit) = text.split_once(' ').map_or((text, None), |(number, unit)| (number, Some(unit)));
    let (whole, part) = number.split_once('.').unwrap_or((number, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let known = |unit: &str| unit.bytes().all(|byte| byte.is_ascii_alphabetic()) && parse_unit(unit).is_ok();
    if !digits(whole) || !digits(part) || !unit.is_none_or(known) {
        return None;
    }
    let place = Span { source, start: number.len() + 1, end: text.len() };
    let unit = unit.map(|unit| Name { text: unit.to_string(), span: place });
    Some(ExpressionKind::Number { value: read_number(number), unit })
}

struct Reader {
    source: SourceId,
    /// Where the text that is being parsed begins in the source.
    offset: usize,
    /// Whether the last statement is the head of a declaration without braces: indented lines are what it was to hold.
    headless: bool,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        // Blanks that were read in the hope of more belong to nobody.
        let end = span.start() + span.as_str().trim_end().len();
        Span { source: self.source, start: self.offset + span.start(), end: self.offset + end }
    }

    fn name(&self, pair: Pair<Rule>) -> Name {
        Name { text: pair.as_str().to_string(), span: self.span(&pair) }
    }

    fn item(&mut self, pair: Pair<Rule>, file: &mut File) {
        let before = &pair.get_input()[..pair.as_span().start()];
        let indented = before.ends_with([' ', '\t']) && before.trim_end_matches([' ', '\t']).ends_with('\n');
        if self.headless && indented && matches!(pair.as_rule(), Rule::junk_item | Rule::declaration) {
            file.unread.extend(names_of(pair.as_str()));
            return;
        }
        self.headless &= pair.as_rule() == Rule::doc;
        match pair.as_rule() {
            Rule::edition => {
                let mut inner = pair.into_inner().skip_while(|part| part.as_rule() == Rule::doc);
                let word = inner.next().expect("edition has a word");
                let number = inner.next().expect("edition has a number");
                let span = self.span(&word).to(self.span(&number));
                let before = file.edition.map(|(_, span)| span);
                if before.is_some()
                    || !(file.imports.is_empty() && file.params.is_empty() && file.declarations.is_empty())
                {
                    self.diagnostics.push(codes::misplaced_edition(span, before));
                    if before.is_some() {
                        return;
                    }
                }
                file.edition = Some((read_number(number.as_str()), self.span(&number)));
            }
            Rule::import => {
                let mut names = Vec::new();
                for part in pair.into_inner() {
                    match part.as_rule() {
                        Rule::imported => names.extend(part.into_inner().map(|name| self.name(name))),
                        Rule::text => {
                            let (path, span) = (inner_text(&part), self.span(&part));
                            file.imports.push(Import { names: std::mem::take(&mut names), path, span, source: None });
                        }
                        _ => {}
                    }
                }
            }
            Rule::param => {
                let param = self.param(pair);
                file.params.push(param);
            }
            Rule::declaration => {
                let declaration = self.declaration(pair);
                file.declarations.push(declaration.into());
            }
            Rule::junk_item => {
                if let Some(param) = file.params.last_mut().filter(|param| self.goes_on(&param.value, &pair)) {
                    param.value.kind = ExpressionKind::Known(Known::Wrong);
                }
                if let Some(declaration) = file.declarations.last_mut().and_then(Arc::get_mut) {
                    declaration.entries.extend(unread_arguments(&pair));
                }
                file.unread.extend(names_of(pair.as_str()));
                // What it would have brought is not known.
                file.torn |= repair::imports(pair.as_str());
                let start = pair.as_span().start();
                let behind = &pair.get_input()[pair.as_span().end()..];
                match repair::headless(pair.as_str(), behind).filter(|_| !indented) {
                    Some(colon) => {
                        self.headless = true;
                        self.diagnostics
                            .push(codes::missing_braces(self.place(start + colon.start, start + colon.end)));
                    }
                    None => self.junk(&pair, Rule::whole_item),
                }
            }
            Rule::doc | Rule::EOI => {}
            other => unreachable!("file holds no {other:?}"),
        }
    }

    fn param(&mut self, pair: Pair<Rule>) -> Param {
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
        Param { docs, name: name(), ty: name(), value: value.expect("a parameter has a value"), setting: None }
    }

    fn declaration(&mut self, pair: Pair<Rule>) -> Declaration {
        let span = self.span(&pair);
        let mut docs = Vec::new();
        let mut names = Vec::new();
        let mut kind = None;
        let mut entries = Vec::new();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::doc => docs.push(part.as_str()[3..].trim().to_string()),
                Rule::name => names.push(self.name(part)),
                Rule::kind => {
                    let mut inner = part.into_inner();
                    kind = inner.next().map(|word| self.name(word));
                    for argument in inner.flat_map(Pair::into_inner) {
                        let entry = self.argument(argument);
                        entries.push(entry);
                    }
                }
                Rule::block => self.block(part, &mut entries),
                other => unreachable!("declaration holds no {other:?}"),
            }
        }
        let mut names = names.into_iter();
        let form = names.next().expect("a declaration begins with a name");
        let name = names.next();
        let last = kind.as_ref().or(name.as_ref()).unwrap_or(&form);
        Declaration { docs, head: form.span.to(last.span), span, form, name, kind, entries }
    }

    fn argument(&mut self, pair: Pair<Rule>) -> Entry {
        let mut inner = pair.into_inner();
        let first = inner.next().expect("an argument has a value");
        match inner.next() {
            Some(value) => Entry::Property(Property { key: self.name(first), value: self.value(value) }),
            None => Entry::Bare(self.value(first)),
        }
    }

    fn block(&mut self, pair: Pair<Rule>, entries: &mut Vec<Entry>) {
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::property => {
                    let mut inner = part.into_inner().filter(|p| p.as_rule() != Rule::doc);
                    let key = self.name(inner.next().expect("a property has a key"));
                    let value = self.value(inner.next().expect("a property has a value"));
                    entries.push(Entry::Property(Property { key, value }));
                }
                Rule::clause => {
                    let mut inner = part.into_inner().filter(|p| !matches!(p.as_rule(), Rule::doc | Rule::on_word));
                    let mut event = inner.next().expect("a clause has an event").into_inner();
                    let name = self.name(event.next().expect("an event has a name"));
                    let word = event.next().map(|word| self.name(word));
                    let formula = self.value(inner.next().expect("a clause has a formula"));
                    entries.push(Entry::Clause(Clause { event: name, word, formula }));
                }
                Rule::declaration => {
                    let child = self.declaration(part);
                    entries.push(Entry::Child(child));
                }
                Rule::junk_entry => {
                    // What it goes on from is no more than a part of what was meant.
                    if let Some(Entry::Property(Property { value, .. }) | Entry::Clause(Clause { formula: value, .. })) =
                        entries.last_mut()
                        && self.goes_on(value, &part)
                    {
                        value.kind = ExpressionKind::Known(Known::Wrong);
                    }
                    if let Some(Entry::Child(child)) = entries.last_mut() {
                        child.entries.extend(unread_arguments(&part));
                    }
                    entries.push(Entry::Unread(words_of(part.as_str())));
                    self.junk(&part, Rule::whole_entry);
                }
                Rule::doc => {}
                other => unreachable!("block holds no {other:?}"),
            }
        }
    }

    fn value(&mut self, pair: Pair<Rule>) -> Expression {
        let span = self.span(&pair);
        let pairs = pair.into_inner();
        let counts = |pair: &Pair<Rule>| {
            let beside = [Rule::prefix, Rule::unit, Rule::arguments, Rule::conversion];
            !beside.contains(&pair.as_rule())
        };
        if pairs.len() > MAX_TERMS && pairs.clone().filter(counts).count() > MAX_TERMS {
            self.diagnostics.push(codes::too_long(span, MAX_TERMS));
            return Expression { kind: ExpressionKind::Number { value: 0.0, unit: None }, span };
        }
        let mut pairs = pairs.peekable();
        let low = self.expression(&mut pairs);
        if pairs.peek().is_none() {
            return low;
        }
        // A term without an operator before it begins the other end of a range.
        let high = self.expression(&mut pairs);
        let span = low.span.to(high.span);
        Expression { kind: ExpressionKind::Range(low.into(), high.into()), span }
    }

    fn expression(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let first = self.term(pairs);
        self.operations(first, pairs, 0)
    }

    /// What follows a term, as far as its operators bind at least so tightly.
    fn operations(&mut self, first: Expression, pairs: &mut Peekable<Pairs<Rule>>, least: u8) -> Expression {
        let mut left = first;
        let binds = |pair: &Pair<Rule>| operator(pair).filter(|(_, tightness)| *tightness >= least);
        while let Some((operator, tightness)) = pairs.peek().and_then(binds) {
            let sign = pairs.next().expect("it was peeked at");
            let joined = sign.as_str() == "+"
                && pairs
                    .peek()
                    .is_some_and(|next| next.as_str() == "-" && next.as_span().start() == sign.as_span().end());
            let right = self.term(pairs);
            if joined {
                self.diagnostics.push(codes::tolerance(left.span.to(right.span), around(&left, &right)));
            }
            let right = self.operations(right, pairs, tightness + 1);
            let span = left.span.to(right.span);
            let kind = ExpressionKind::Binary { operator, left: left.into(), right: right.into() };
            left = Expression { kind, span };
        }
        left
    }

    /// Signs, what they stand before, and the unit that it is counted in.
    fn term(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let mut prefixes = Vec::new();
        while let Some(prefix) = pairs.next_if(|pair| pair.as_rule() == Rule::prefix) {
            prefixes.push((prefix.as_str() == "-", self.span(&prefix)));
        }
        let mut expression = self.primary(pairs);
        if let Some(conversion) = pairs.next_if(|pair| pair.as_rule() == Rule::conversion) {
            let unit = self.name(conversion.into_inner().next().expect("a conversion has a unit"));
            let span = expression.span.to(unit.span);
            expression = Expression { kind: ExpressionKind::Conversion(expression.into(), unit), span };
        }
        if prefixes.len() > MAX_TERMS {
            self.diagnostics.push(codes::too_long(prefixes[0].1, MAX_TERMS));
            return expression;
        }
        for (negative, span) in prefixes.into_iter().rev() {
            if !negative {
                // `not` is about a whole comparison.
                expression = self.operations(expression, pairs, COMPARISON);
            }
            let span = span.to(expression.span);
            let kind = match (negative, expression.kind) {
                (true, ExpressionKind::Number { value, unit }) => ExpressionKind::Number { value: -value, unit },
                (true, kind) => ExpressionKind::Negate(Expression { kind, span: expression.span }.into()),
                (false, kind) => ExpressionKind::Not(Expression { kind, span: expression.span }.into()),
            };
            expression = Expression { kind, span };
        }
        expression
    }

    /// A number with its unit, a word or a call, a text, a group, a list.
    fn primary(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let pair = pairs.next().expect("a term has a value");
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::number => {
                let value = read_number(pair.as_str());
                let unit = pairs.next_if(|pair| pair.as_rule() == Rule::unit).map(|unit| self.name(unit));
                let span = unit.as_ref().map_or(span, |unit| span.to(unit.span));
                return Expression { kind: ExpressionKind::Number { value, unit }, span };
            }
            Rule::text => ExpressionKind::Text(inner_text(&pair)),
            Rule::name => {
                let function = self.name(pair);
                let Some(list) = pairs.next_if(|pair| pair.as_rule() == Rule::arguments) else {
                    return Expression { kind: ExpressionKind::Name(function.text), span };
                };
                let span = span.to(self.span(&list));
                let (mut arguments, mut keys) = (Vec::new(), Vec::new());
                let text = list.get_input();
                for argument in list.into_inner() {
                    match self.argument(argument) {
                        Entry::Bare(value) => arguments.push(value),
                        Entry::Property(property) => {
                            keys.push(property.key);
                            arguments.push(property.value);
                        }
                        Entry::Clause(_) | Entry::Child(_) | Entry::Unread(_) => {
                            unreachable!("an argument is a value")
                        }
                    }
                }
                if keys.is_empty() {
                    self.ask_about_commas(text, &arguments);
                }
                if !keys.is_empty() {
                    let written =
                        |value: &Expression| &text[value.span.start - self.offset..value.span.end - self.offset];
                    let values: Vec<&str> = arguments.iter().map(written).collect();
                    let call = format!("{}({})", function.text, values.join(", "));
                    self.diagnostics.push(codes::named_argument(&keys, span, &call));
                }
                return Expression { kind: ExpressionKind::Call { function, arguments }, span };
            }
            Rule::group => ExpressionKind::Group(pair.into_inner().map(|value| self.value(value)).collect()),
            Rule::list => ExpressionKind::List(pair.into_inner().map(|value| self.value(value)).collect()),
            other => unreachable!("no primary is a {other:?}"),
        };
        Expression { kind, span }
    }

    /// Asks whether two numbers of a call were to be one: who leaves blanks behind commas, but not behind this one, may have
    /// meant a fraction.
    fn ask_about_commas(&mut self, text: &str, arguments: &[Expression]) {
        let joined = |pair: &&[Expression]| pair[0].span.end + 1 == pair[1].span.start;
        let pairs: Vec<&[Expression]> = arguments.windows(2).filter(joined).collect();
        if pairs.len() + 1 >= arguments.len() {
            return;
        }
        for pair in pairs {
            let (from, comma) = (pair[0].span.start - self.offset, pair[0].span.end - self.offset);
            let whole = text[from..comma].bytes().all(|byte| byte.is_ascii_digit());
            let digits = text[comma + 1..].bytes().take_while(u8::is_ascii_digit).count();
            let end = comma + 1 + digits;
            if whole && digits > 0 && !text[end..].starts_with('.') {
                self.diagnostics.push(codes::comma_in_number(self.place(from, end), &text[from..end]));
            }
        }
    }

    /// Whether a statement of no known shape stands right behind a value, on its line.
    fn goes_on(&self, value: &Expression, junk: &Pair<Rule>) -> bool {
        let between = value.span.end.checked_sub(self.offset).map(|end| end..junk.as_span().start());
        between
            .and_then(|between| junk.get_input().get(between))
            .is_some_and(|text| text.trim_matches([' ', '\t', ',']).is_empty())
    }

    /// Reads a statement of no known shape once more, on its own, to find out where it goes wrong.
    fn junk(&mut self, pair: &Pair<Rule>, rule: Rule) {
        if self.diagnostics.len() >= MOST_REREAD {
            return self.diagnostics.push(codes::syntax(self.span(pair), String::new()));
        }
        let start = pair.as_span().start();
        let text = pair.as_str().trim_end();
        let source = pair.get_input();
        let line = source[..start].rfind(['\n', '\r']).map_or(0, |end| end + 1);
        // What stands on the line of another statement may be left over from it.
        let goes_on = !source[line..start].trim().is_empty();
        if let Some((place, instead, ty)) = repair::untyped_param(text).filter(|_| rule == Rule::whole_item) {
            let span = self.place(start + place.start, start + place.end);
            return self.diagnostics.push(codes::untyped_param(span, &instead, ty));
        }
        if let Some(sign) = repair::open_end(&source[..start], text) {
            return self.diagnostics.push(codes::open_end(self.place(sign.start, sign.end)));
        }
        if let Some(said) = self.left_over(&source[line..start], text, start, rule) {
            return self.diagnostics.push(said);
        }
        // So may parentheses, of a declaration that can do without, and what cannot begin a statement.
        let before = match rule {
            _ if text.starts_with('(') => "form name = kind",
            Rule::whole_entry if goes_on => "key: 0 ",
            Rule::whole_item if goes_on => "param name: type = 0 ",
            _ => "",
        };
        if let Some(key) = repair::dotted_key(text).filter(|_| rule == Rule::whole_entry) {
            return self.diagnostics.push(codes::dotted_key(self.place(start, start + key.len()), key));
        }
        if let Some((place, said, meant)) = repair::split_words(text, rule == Rule::whole_entry) {
            let span = self.place(start + place.start, start + place.end);
            return self.diagnostics.push(codes::slip(span, said, meant.as_deref()));
        }
        let reads = |text: &str| ScenarioParser::parse(rule, text).is_ok();
        let slips = repair::slips(text, rule == Rule::whole_entry);
        // A value that follows a word right away may lack the colon between.
        let also = (rule == Rule::whole_entry).then(|| repair::missing_colon(text)).flatten();
        for slips in [Some(slips), also].into_iter().flatten().filter(|slips| !slips.is_empty()) {
            let repaired = repair::without(text, &slips);
            let all = reads(&repaired) || !before.is_empty() && reads(&format!("{before}{repaired}"));
            for slip in slips.iter().filter(|slip| all || slip.foreign) {
                let span = self.place(start + slip.place.start, start + slip.place.end);
                self.diagnostics.push(codes::slip(span, slip.said, slip.meant.then_some(slip.instead.as_str())));
            }
            if all || slips.iter().any(|slip| slip.foreign) {
                return;
            }
        }
        if let Some(sign) = repair::ends_open(text) {
            return self.diagnostics.push(codes::open_end(self.place(start + sign.start, start + sign.end)));
        }
        let before = if text.starts_with('(') { before } else { "" };
        let whole = format!("{before}{text}");
        let diagnostic = match ScenarioParser::parse(rule, &whole) {
            Err(error) => match self.with_commas(&whole, before.len(), start, rule) {
                Some(diagnostic) => diagnostic,
                None => {
                    let said = self.syntax_error(&error, before.len(), start);
                    match text.starts_with("import") || text.starts_with("from") {
                        true => said.help("write `import \"path\"`, or `import a, b from \"path\"`"),
                        false => said,
                    }
                }
            },
            Ok(_) => codes::syntax(self.span(pair), "this cannot stand here".into()),
        };
        self.diagnostics.push(diagnostic);
    }

    /// What is wrong with a value that ends where `text` begins, which goes on from it.
    fn left_over(&self, before: &str, text: &str, start: usize, rule: Rule) -> Option<Diagnostic> {
        let around = |(back, on): (usize, usize)| {
            let written = format!("{}{}", &before[before.len() - back..], &text[..on]);
            (self.place(start - back, start + on), written)
        };
        if let Some((span, number)) = repair::decimal_comma(before, text).map(around) {
            return Some(codes::decimal_comma(span, &number));
        }
        let listed = repair::unbracketed(before, text).filter(|_| rule == Rule::whole_entry);
        if let Some((span, values)) = listed.map(around) {
            let quantity = |text: &str| {
                text.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit()) && text.contains(' ')
            };
            return Some(match values.split_once(',').map(|(low, high)| (low.trim(), high.trim())) {
                Some((low, high))
                    if !high.contains(',') && quantity(low) && quantity(high) && !before.contains("matrix") =>
                {
                    codes::unbracketed_pair(span, (low, high))
                }
                _ => codes::unbracketed_list(span, &values),
            });
        }
        let slip = repair::left_over(before, text, rule == Rule::whole_entry)?;
        let place = self.place(start - before.len() + slip.place.start, start - before.len() + slip.place.end);
        Some(codes::slip(place, slip.said, slip.meant.then_some(slip.instead.as_str())))
    }

    /// A part of the text that is being parsed, as a place of the source.
    fn place(&self, start: usize, end: usize) -> Span {
        Span { source: self.source, start: self.offset + start, end: self.offset + end }
    }

    /// What is wrong with a statement that commas would make readable.
    fn with_commas(&self, text: &str, added: usize, start: usize, rule: Rule) -> Option<Diagnostic> {
        let commas = repair::missing_commas(text);
        let first = *commas.first()?;
        // The first word in the parentheses of a kind is a key.
        let head = text[..first].trim_end_matches(|c: char| c == '_' || c.is_ascii_alphanumeric());
        let open = head.trim_end().strip_suffix(['(', ',']);
        let of_kind =
            open.is_some_and(|open| open.split('(').count() < 3 && open.contains('=')) && !text.contains("=>");
        let named = text[head.len()..first].starts_with(|c: char| c.is_ascii_lowercase());
        let keyed = format!("{}:{}", &text[..first], &text[first..]);
        if commas.len() == 1 && of_kind && named && ScenarioParser::parse(rule, &keyed).is_ok() {
            let key = start + head.len() - added;
            let meant = format!("{}:", &text[head.len()..first]);
            let said = "a key is followed by `:`";
            return Some(codes::slip(self.place(key, start + first - added), said, Some(&meant)));
        }
        let (mut repaired, mut last) = (String::new(), 0);
        for comma in &commas {
            repaired.extend([&text[last..*comma], ","]);
            last = *comma;
        }
        repaired.push_str(&text[last..]);
        let place = start + first - added;
        ScenarioParser::parse(rule, &repaired).is_ok().then(|| codes::missing_comma(self.place(place, place)))
    }

    /// What pest says about a text that begins at a place of the source, after so many bytes that were put before it.
    fn syntax_error(&self, error: &pest::error::Error<Rule>, added: usize, start: usize) -> Diagnostic {
        let (from, to) = match error.location {
            InputLocation::Pos(at) => (at, at),
            InputLocation::Span((from, to)) => (from, to),
        };
        let (from, to) = (from.saturating_sub(added), to.saturating_sub(added));
        let span = Span { source: self.source, start: self.offset + start + from, end: self.offset + start + to };
        let expected = match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let mut words: Vec<&str> = positives.iter().filter_map(|rule| describe(*rule)).collect();
                words.sort_unstable();
                words.dedup();
                words.join(", ")
            }
            ErrorVariant::CustomError { message } => message.clone(),
        };
        let text = if expected.is_empty() { "not understood from here".into() } else { format!("expected {expected}") };
        codes::syntax(span, text)
    }
}

/// The range between a quantity less another and more by it, when both are plain and counted in one unit.
fn around(middle: &Expression, less: &Expression) -> Option<String> {
    let number = |expression: &Expression| match &expression.kind {
        ExpressionKind::Number { value, unit } => Some((*value, unit.as_ref().map(|unit| unit.text.clone()))),
        _ => None,
    };
    let ((middle, unit), (less, other)) = (number(middle)?, number(less)?);
    let with_unit = |value: f64| format!("{} {}", short(value), unit.as_deref().unwrap_or_default()).trim().to_string();
    (unit == other).then(|| format!("{} .. {}", with_unit(middle + less), with_unit(middle - less)))
}

fn read_number(text: &str) -> f64 {
    let number = if text.contains('_') { text.replace('_', "").parse() } else { text.parse() };
    number.expect("the grammar admits only numbers")
}

fn inner_text(pair: &Pair<Rule>) -> String {
    pair.clone().into_inner().next().map_or_else(String::new, |inner| inner.as_str().to_string())
}

/// How tightly comparisons bind: less than what they compare, more than `and` and `or`.
const COMPARISON: u8 = 2;

/// An operator, and how tightly it binds; none for another pair.
fn operator(pair: &Pair<Rule>) -> Option<(Operator, u8)> {
    if pair.as_rule() != Rule::infix {
        return None;
    }
    Some(match pair.as_str() {
        "or" => (Operator::Or, 0),
        "and" => (Operator::And, 1),
        "<" => (Operator::Less, COMPARISON),
        "<=" => (Operator::LessEqual, COMPARISON),
        ">" => (Operator::Greater, COMPARISON),
        ">=" => (Operator::GreaterEqual, COMPARISON),
        "+" => (Operator::Add, 3),
        "-" => (Operator::Subtract, 3),
        "*" => (Operator::Multiply, 4),
        "/" => (Operator::Divide, 4),
        other => unreachable!("`{other}` is no operator"),
    })
}

/// What a user calls a rule; `None` for rules that say nothing to a user. Exhaustive, so that a new rule gets a name.
fn describe(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::name => "a name",
        Rule::number | Rule::quantity => "a number",
        Rule::unit => "a unit",
        Rule::text => "a text in quotes",
        Rule::block => "`{`",
        Rule::kind => "`=`",
        Rule::arguments | Rule::group => "`(`",
        Rule::list => "`[`",
        Rule::edition | Rule::edition_word => "`edition`",
        Rule::import | Rule::import_word => "`import`",
        Rule::imported => "names",
        Rule::from_word => "`from`",
        Rule::param | Rule::param_word => "`param name: type = value`",
        Rule::declaration => "a declaration",
        Rule::property => "`key: value`",
        Rule::clause | Rule::on_word => "`on event => formula`",
        Rule::event => "an event",
        Rule::value | Rule::expression | Rule::term | Rule::primary => "a value",
        Rule::call => "a call",
        Rule::argument => "an argument",
        Rule::infix => "an operator",
        Rule::conversion => "`in`",
        Rule::EOI | Rule::whole_item | Rule::whole_entry | Rule::whole_value => "the end of the statement",
        Rule::b
        | Rule::COMMENT
        | Rule::doc
        | Rule::docs
        | Rule::name_char
        | Rule::keyword
        | Rule::digits
        | Rule::free
        | Rule::unit_part
        | Rule::power
        | Rule::blank
        | Rule::text_inner
        | Rule::file
        | Rule::junk_item
        | Rule::junk_entry
        | Rule::balanced
        | Rule::within
        | Rule::piece
        | Rule::dark
        | Rule::plain
        | Rule::line
        | Rule::remark
        | Rule::prefix => return None,
    })
}

#[cfg(test)]
mod tests;
