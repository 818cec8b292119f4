//! Error nodes: reports on statements that the grammar does not match.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pair;

use super::Reader;
use super::rules::{Rule, ScenarioParser};
use crate::diagnostics;
use crate::tokens::{TokenKind, words};
use base::diagnostic::{Diagnostic, Span};

/// Maximum number of diagnostics up to which error nodes are parsed again for the place of the error; a file with more is not a scenario.
const MAX_REREAD: usize = 1000;

/// The shapes of statements outside of declarations.
const ITEMS: &str =
    "statements are `form name = kind(key: value)`, `form name { … }`, `param name: type = value`, `import \"path\"`";
/// The shapes of entries inside of declarations.
const ENTRIES: &str = "inside braces are `key: value`, `block { … }` and, in a reward, `on event => formula`";

impl Reader {
    /// Reports an error node: the place where the parser fails at this rule.
    pub(super) fn unreadable(&mut self, node: &Pair<Rule>, rule: Rule) {
        let text = node.as_str().trim_end();
        let said = match ScenarioParser::parse(rule, text) {
            Err(error) if self.diagnostics.len() < MAX_REREAD => {
                let said = self.syntax_error(&error, text, node.as_span().start());
                // What is expected in the head of a statement only.
                let heads = ["`{`", "`from`", "`key: value`", "a declaration"];
                let is_head = heads.iter().any(|head| said.primary.text.contains(head));
                let shapes = if rule == Rule::whole_item { ITEMS } else { ENTRIES };
                if is_head { said.help(shapes) } else { said }
            }
            _ => diagnostics::syntax(self.span(node), "not understood".into()),
        };
        self.diagnostics.push(said);
    }

    /// The error of pest for a text that starts at this byte of the source.
    pub(super) fn syntax_error(&self, error: &pest::error::Error<Rule>, text: &str, start: usize) -> Diagnostic {
        let at = match error.location {
            InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
        };
        let mut expected: Vec<&str> = match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                positives.iter().filter_map(|rule| describe(*rule)).collect()
            }
            ErrorVariant::CustomError { .. } => Vec::new(),
        };
        const VALUES: [&str; 5] = ["a name", "a number", "a text in quotes", "`(`", "`[`"];
        if VALUES.iter().all(|each| expected.contains(each)) {
            expected.retain(|each| !VALUES.contains(each));
            expected.push("a value");
        }
        expected.sort_unstable();
        expected.dedup();
        let found = words(&text[at..]).next();
        let (from, to) = found.map_or((at, at), |token| (at + token.start, at + token.end));
        let found = match found.map(|token| token.kind) {
            None => "nothing".to_string(),
            Some(TokenKind::OpenText) => "a text that is not closed on its line".into(),
            Some(_) => format!("`{}`", diagnostics::cut(&text[from..to])),
        };
        let said = match expected.split_last() {
            None => format!("unexpected: {found}"),
            Some((only, [])) => format!("expected {only}, found {found}"),
            Some((last, others)) => format!("expected {} or {last}, found {found}", others.join(", ")),
        };
        diagnostics::syntax(Span { source: self.source, start: start + from, end: start + to }, said)
    }
}

/// The user's name of a rule; `None` for rules that mean nothing to a user. Exhaustive, so that a new rule gets a name.
fn describe(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::name | Rule::signal => "a name",
        Rule::number | Rule::quantity => "a number",
        Rule::unit => "a unit",
        Rule::text => "a text in quotes",
        Rule::block | Rule::open_block => "`{`",
        Rule::kind | Rule::equals => "`=`",
        Rule::arguments | Rule::group | Rule::open => "`(`",
        Rule::list | Rule::open_list => "`[`",
        Rule::close => "`)`",
        Rule::close_list => "`]`",
        Rule::comma => "`,`",
        Rule::colon => "`:`",
        Rule::arrow => "`=>`",
        Rule::range => "`..`",
        Rule::edition | Rule::edition_word => "`edition`",
        Rule::import | Rule::import_word => "`import`",
        Rule::imported => "names",
        Rule::from_word => "`from`",
        Rule::param | Rule::param_word => "`param`",
        Rule::declaration => "a declaration",
        Rule::property => "`key: value`",
        Rule::inner => "a block",
        Rule::clause | Rule::on_word => "`on`",
        Rule::event => "an event",
        Rule::value | Rule::expression | Rule::term | Rule::operand | Rule::primary => "a value",
        Rule::call => "a call",
        Rule::argument => "an argument",
        Rule::infix | Rule::sum | Rule::product | Rule::comparison | Rule::and | Rule::or | Rule::implies => {
            "an operator"
        }
        Rule::conversion => "`in`",
        Rule::EOI | Rule::whole_item | Rule::whole_entry | Rule::whole_value => "the end of the statement",
        Rule::b
        | Rule::stated
        | Rule::before_block
        | Rule::requirement_word
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
        | Rule::prefix
        | Rule::minus
        | Rule::not => return None,
    })
}
