//! Statements, blocks and brackets → a document.

use super::marks::marks;
use super::printer::{Doc, print};
use super::tokens::{Token, tokens};
use super::tree::{Item, Member, Node, Tree};
use crate::parse;
use crate::tokens::TokenKind;
use base::diagnostic::{Diagnostic, Severity, SourceId};

/// Columns per line.
const WIDTH: usize = 120;

/// Formats a text in its canonical layout: the same statements and comments in the same order, 120 columns wide, two columns
/// per indentation.
///
/// Blocks of pairs that the author wrote on one line stay on one line if they fit. Several blank lines become one.
///
/// # Errors
/// The errors of a text that cannot be read; it gets no layout.
pub fn format(source: SourceId, text: &str) -> Result<String, Vec<Diagnostic>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (_, mut said) = parse(source, text);
    said.retain(|each| each.severity == Severity::Error);
    if !said.is_empty() {
        return Err(said);
    }
    let marked = marks(text).expect("checked: the text parses");
    let read = tokens(text, &marked);
    let laid_out = print(&file(&Tree::file(&read)), WIDTH);
    // A tool that overwrites files checks its result.
    let again = marks(&laid_out).expect("checked: a layout parses");
    let (before, after) = (essence(&read), tokens(&laid_out, &again));
    assert!(before == essence(&after), "a layout changes no token");
    Ok(laid_out)
}

/// The parts that a layout must not change: all tokens except commas and semicolons, and separately comments, which may move past a comma.
fn essence(tokens: &[Token]) -> (Vec<(String, TokenKind)>, Vec<String>) {
    let plain = |token: &Token| token.text.replace("\r\n", "\n").replace('\r', "\n");
    let (comments, rest): (Vec<&Token>, Vec<&Token>) = tokens.iter().partition(|token| token.is_comment());
    let separates = |token: &Token| matches!(token.text, "," | ";");
    let rest = rest.into_iter().filter(|token| !separates(token));
    (rest.map(|token| (plain(token), token.kind)).collect(), comments.into_iter().map(plain).collect())
}

fn text(token: &Token) -> Doc {
    Doc::Text(token.text.replace("\r\n", "\n").replace('\r', "\n"))
}

fn file(items: &[Item]) -> Doc {
    Doc::Row(contents(items))
}

/// Items on lines of their own.
fn contents(items: &[Item]) -> Vec<Doc> {
    let mut docs: Vec<Doc> = Vec::new();
    let mut after_doc = false;
    for (index, item) in items.iter().enumerate() {
        let (blank, trails) = match item {
            Item::Aside(token) => (token.lines_before > 1, token.is_comment() && token.trails()),
            Item::Statement { blank, .. } => (*blank, false),
        };
        if !trails && index > 0 {
            docs.push(if blank && !after_doc { Doc::Blank } else { Doc::Hard });
        }
        match item {
            // In a row of its own it has no effect on whether the text before it fits.
            Item::Aside(token) if trails => docs.push(Doc::Row(vec![Doc::Space, text(token)])),
            Item::Aside(token) => docs.push(text(token)),
            Item::Statement { nodes, .. } => docs.push(statement(nodes)),
        }
        after_doc = matches!(item, Item::Aside(token) if token.kind == TokenKind::Doc);
    }
    docs
}

/// A statement: rows of tokens, and blocks between them.
fn statement(nodes: &[Node]) -> Doc {
    let mut docs = Vec::new();
    let mut rest = nodes;
    while let Some(at) = rest.iter().position(|node| matches!(node, Node::Block { .. })) {
        if at > 0 {
            docs.push(row(&rest[..at]));
            docs.push(Doc::Space);
        }
        if let Node::Block { items, one_line } = &rest[at] {
            docs.push(block(items, *one_line));
        }
        rest = &rest[at + 1..];
        if !rest.is_empty() {
            docs.push(Doc::Space);
        }
    }
    if !rest.is_empty() {
        docs.push(row(rest));
    }
    Doc::Row(docs)
}

fn block(items: &[Item], one_line: bool) -> Doc {
    if items.is_empty() {
        return Doc::Text("{}".into());
    }
    let pairs = items.iter().all(|item| matches!(item, Item::Statement { pair: true, .. }));
    if one_line && pairs {
        let mut inner = vec![Doc::Line(" ")];
        for (index, item) in items.iter().enumerate() {
            if index > 0 {
                inner.push(Doc::Line("  "));
            }
            if let Item::Statement { nodes, .. } = item {
                inner.push(statement(nodes));
            }
        }
        return Doc::Group(vec![Doc::Text("{".into()), Doc::Indent(inner), Doc::Line(" "), Doc::Text("}".into())]);
    }
    let mut inner = contents(items);
    // A comment on the line of the brace stays on that line.
    if !matches!(items.first(), Some(Item::Aside(token)) if token.is_comment() && token.trails()) {
        inner.insert(0, Doc::Hard);
    }
    Doc::Row(vec![Doc::Text("{".into()), Doc::Indent(inner), Doc::Hard, Doc::Text("}".into())])
}

/// Tokens and brackets in a row, which may be broken before an operator.
fn row(nodes: &[Node]) -> Doc {
    let mut chunks: Vec<Doc> = Vec::new();
    let mut chunk: Vec<Doc> = Vec::new();
    for (index, node) in nodes.iter().enumerate() {
        let before = index.checked_sub(1).map(|at| &nodes[at]);
        if let Some(before) = before {
            if is_operator(node) && !matches!(before, Node::Token(token) if token.is_comment()) {
                push_chunk(&mut chunks, std::mem::take(&mut chunk));
                chunks.push(Doc::Indent(vec![Doc::Line(" ")]));
            } else if spaced(before, node) && !matches!(node, Node::Token(token) if token.is_comment()) {
                chunk.push(Doc::Space);
            }
        }
        match node {
            Node::Token(token) if token.is_comment() => {
                let spaced = before.is_some_and(|before| spaced(before, node));
                chunk.push(comment(token, spaced, index == 0, index + 1 == nodes.len()));
            }
            Node::Token(token) => chunk.push(text(token)),
            Node::Bracket { open, members, close } => chunk.push(bracket(open, members, close)),
            Node::Block { .. } => unreachable!("blocks part the rows of a statement"),
        }
    }
    push_chunk(&mut chunks, chunk);
    Doc::Group(vec![Doc::Fill(chunks)])
}

/// All chunks of a row except the first are indented further.
fn push_chunk(chunks: &mut Vec<Doc>, chunk: Vec<Doc>) {
    chunks.push(if chunks.is_empty() { Doc::Row(chunk) } else { Doc::Indent(chunk) });
}

/// A comment inside a statement, with the line ends that it had.
fn comment(token: &Token, spaced: bool, first: bool, last: bool) -> Doc {
    let mut docs = Vec::new();
    if !token.trails() && !first {
        docs.push(Doc::Hard);
    } else if spaced {
        docs.push(Doc::Space);
    }
    docs.push(text(token));
    if token.ends_line && !last || token.kind == TokenKind::LineComment {
        docs.push(Doc::Hard);
    }
    Doc::Row(docs)
}

fn bracket(open: &Token, members: &[Member], close: &str) -> Doc {
    let edge = if open.text == "{" { " " } else { "" };
    if members.is_empty() {
        return Doc::Text(format!("{}{close}", open.text));
    }
    let mut inner = Vec::new();
    for (index, member) in members.iter().enumerate() {
        let last = index + 1 == members.len();
        let mut docs = vec![row(&member.nodes)];
        if !last {
            docs.push(Doc::Text(",".into()));
        }
        let mut ends_line = false;
        for token in &member.after {
            // In a row of its own, as in `comment`, it has no effect on whether the text before it fits.
            let space = if token.trails() && !ends_line { Doc::Space } else { Doc::Hard };
            docs.push(Doc::Row(vec![space, text(token)]));
            ends_line = token.kind == TokenKind::LineComment || token.ends_line;
        }
        if last && member.after.last().is_some_and(|token| token.kind == TokenKind::LineComment) {
            docs.push(Doc::Hard);
        }
        inner.push(Doc::Row(docs));
        if !last {
            inner.push(if ends_line { Doc::Hard } else { Doc::Line(" ") });
        }
    }
    let inner = if open.text == "[" { Doc::Fill(inner) } else { Doc::Row(inner) };
    Doc::Group(vec![
        Doc::Text(open.text.into()),
        Doc::Indent(vec![Doc::Line(edge), inner]),
        Doc::Line(edge),
        Doc::Text(close.into()),
    ])
}

fn is_operator(node: &Node) -> bool {
    const OPERATORS: [&str; 10] = ["+", "-", "*", "/", "<", "<=", ">", ">=", "and", "or"];
    let Node::Token(token) = node else { return false };
    matches!(token.kind, TokenKind::Sign | TokenKind::Keyword) && !token.prefix && OPERATORS.contains(&token.text)
}

/// Whether a blank separates two neighbours.
fn spaced(before: &Node, node: &Node) -> bool {
    let is = |node: &Node, such: fn(&Token) -> bool| matches!(node, Node::Token(token) if such(token));
    if is(node, |token| matches!(token.text, ":" | "," | ";")) || is(before, |token| token.prefix) {
        return false;
    }
    // The parenthesis of a call, a kind or an event; not one after a keyword.
    let opens = matches!(node, Node::Bracket { open, .. } if open.text == "(");
    !(opens && is(before, |token| token.kind == TokenKind::Name))
}
