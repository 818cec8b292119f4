//! Statements of no known shape: what is said of them.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pair;

use super::Reader;
use super::rules::{Rule, ScenarioParser};
use crate::diagnostic::{Diagnostic, Span};
use crate::lang::ast::Expression;
use crate::lang::{codes, repair};

/// Most statements of no known shape that are read once more to tell what is wrong with them; a file with more of them is no
/// scenario.
const MOST_REREAD: usize = 1000;

impl Reader {
    /// Whether a statement of no known shape stands right behind a value, on its line.
    pub(super) fn goes_on(&self, value: &Expression, junk: &Pair<Rule>) -> bool {
        let between = junk.get_input().get(value.span.end..junk.as_span().start());
        between.is_some_and(|text| text.trim_matches([' ', '\t', ',']).is_empty())
    }

    /// Reads a statement of no known shape once more, on its own, to find out where it goes wrong.
    pub(super) fn junk(&mut self, pair: &Pair<Rule>, rule: Rule) {
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
    pub(super) fn syntax_error(&self, error: &pest::error::Error<Rule>, added: usize, start: usize) -> Diagnostic {
        let (from, to) = match error.location {
            InputLocation::Pos(at) => (at, at),
            InputLocation::Span((from, to)) => (from, to),
        };
        let (from, to) = (from.saturating_sub(added), to.saturating_sub(added));
        let span = Span { source: self.source, start: start + from, end: start + to };
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
