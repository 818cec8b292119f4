//! Statements, blocks and brackets → a document.

use std::borrow::Cow;

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
    assert!(is_same(&read, &tokens(&laid_out, &again)), "a layout changes no token");
    Ok(laid_out)
}

/// Whether a layout has changed nothing: the tokens are the same, except commas and semicolons, and so are the comments, which may move past
/// a comma.
fn is_same(before: &[Token], after: &[Token]) -> bool {
    let comments = |tokens| of(tokens, |token| token.is_comment());
    let rest = |tokens| of(tokens, |token| !token.is_comment() && !matches!(token.text, "," | ";"));
    rest(before).eq(rest(after)) && comments(before).map(|(text, _)| text).eq(comments(after).map(|(text, _)| text))
}

/// The text and kind of some tokens.
fn of<'a>(tokens: &'a [Token<'a>], such: fn(&Token) -> bool) -> impl Iterator<Item = (Cow<'a, str>, TokenKind)> {
    tokens.iter().filter(move |token| such(token)).map(|token| (plain(token.text), token.kind))
}

/// A text with line ends of one kind.
fn plain(text: &str) -> Cow<'_, str> {
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n").into() } else { text.into() }
}

fn text<'a>(token: &Token<'a>) -> Doc<'a> {
    Doc::Text(plain(token.text))
}

fn file<'a>(items: &[Item<'a>]) -> Doc<'a> {
    Doc::Row(contents(items))
}

/// Items on lines of their own.
fn contents<'a>(items: &[Item<'a>]) -> Vec<Doc<'a>> {
    let mut docs: Vec<Doc<'a>> = Vec::new();
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
fn statement<'a>(nodes: &[Node<'a>]) -> Doc<'a> {
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

fn block<'a>(items: &[Item<'a>], one_line: bool) -> Doc<'a> {
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
fn row<'a>(nodes: &[Node<'a>]) -> Doc<'a> {
    let (mut chunks, mut chunk) = (Vec::new(), Vec::with_capacity(nodes.len()));
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
    // A long list has very many members of one token.
    if chunks.is_empty() {
        return Doc::Row(chunk);
    }
    push_chunk(&mut chunks, chunk);
    Doc::Group(vec![Doc::Fill(chunks)])
}

/// All chunks of a row except the first are indented further.
fn push_chunk<'a>(chunks: &mut Vec<Doc<'a>>, chunk: Vec<Doc<'a>>) {
    chunks.push(if chunks.is_empty() { Doc::Row(chunk) } else { Doc::Indent(chunk) });
}

/// A comment inside a statement, with the line ends that it had.
fn comment<'a>(token: &Token<'a>, spaced: bool, first: bool, last: bool) -> Doc<'a> {
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

fn bracket<'a>(open: &Token<'a>, members: &[Member<'a>], close: &'a str) -> Doc<'a> {
    let edge = if open.text == "{" { " " } else { "" };
    if members.is_empty() {
        return Doc::Text(format!("{}{close}", open.text).into());
    }
    let mut inner = Vec::new();
    for (index, member) in members.iter().enumerate() {
        let last = index + 1 == members.len();
        let mut docs = Vec::with_capacity(member.after.len() + 2);
        docs.push(row(&member.nodes));
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
    const OPERATORS: [&str; 11] = ["+", "-", "*", "/", "<", "<=", ">", ">=", "and", "or", "implies"];
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
