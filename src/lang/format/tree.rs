//! Tokens → statements, blocks and brackets.

use super::tokens::Token;
use crate::tokens::TokenKind;

/// An item of a file or a block.
#[derive(Debug)]
pub enum Item<'a> {
    /// A comment or a `///` line.
    Aside(Token<'a>),
    Statement {
        /// Its parts.
        nodes: Vec<Node<'a>>,
        /// Whether a blank line precedes it.
        blank: bool,
        /// Whether it is a pair, which may share a line with others.
        pair: bool,
    },
}

/// A part of a statement.
#[derive(Debug)]
pub enum Node<'a> {
    /// A token, or a comment.
    Token(Token<'a>),
    /// A pair of brackets with members between commas.
    Bracket {
        open: Token<'a>,
        /// The members between.
        members: Vec<Member<'a>>,
        /// The closing one's text.
        close: &'a str,
    },
    /// Braces around statements.
    Block {
        /// The statements.
        items: Vec<Item<'a>>,
        /// Whether the author wrote it on one line.
        one_line: bool,
    },
}

/// A member of a bracket.
#[derive(Debug, Default)]
pub struct Member<'a> {
    /// Its parts.
    pub nodes: Vec<Node<'a>>,
    /// Comments that come after its comma.
    pub after: Vec<Token<'a>>,
}

/// A reader of tokens.
pub struct Tree<'a, 'b> {
    tokens: &'b [Token<'a>],
    at: usize,
}

impl<'a, 'b> Tree<'a, 'b> {
    pub fn file(tokens: &'b [Token<'a>]) -> Vec<Item<'a>> {
        Self { tokens, at: 0 }.items()
    }

    fn peek(&self) -> Option<Token<'a>> {
        self.tokens.get(self.at).copied()
    }

    /// Items up to a closing brace or the end.
    fn items(&mut self) -> Vec<Item<'a>> {
        let mut items = Vec::new();
        let mut pair = false;
        while let Some(token) = self.peek() {
            if token.text == "}" && token.kind == TokenKind::Close {
                break;
            }
            pair = token.statement.unwrap_or(pair);
            if is_aside(token) {
                items.push(Item::Aside(token));
                self.at += 1;
                continue;
            }
            let nodes = self.statement();
            items.push(Item::Statement { nodes, blank: token.lines_before > 1, pair });
        }
        items
    }

    /// One statement; comments after it are left for the items.
    fn statement(&mut self) -> Vec<Node<'a>> {
        let mut nodes = Vec::new();
        let mut first = true;
        while let Some(token) = self.peek() {
            let next = token.statement.is_some() || token.kind == TokenKind::Doc;
            if !first && next || token.text == "}" && token.kind == TokenKind::Close {
                break;
            }
            first = false;
            nodes.push(self.node());
        }
        while matches!(nodes.last(), Some(Node::Token(token)) if token.is_comment()) {
            nodes.pop();
            self.at -= 1;
        }
        // A comma or semicolon after a property has no meaning.
        if matches!(nodes.last(), Some(Node::Token(token)) if matches!(token.text, "," | ";")) {
            nodes.pop();
        }
        nodes
    }

    fn node(&mut self) -> Node<'a> {
        let token = self.tokens[self.at];
        self.at += 1;
        if token.kind != TokenKind::Open {
            return Node::Token(token);
        }
        match token.text {
            "{" if token.opens_block => {
                let from = self.at;
                let items = self.items();
                let one_line = self.tokens[from..=self.at].iter().all(Token::trails);
                self.at += 1;
                Node::Block { items, one_line }
            }
            _ => self.bracket(token),
        }
    }

    fn bracket(&mut self, open: Token<'a>) -> Node<'a> {
        let mut members = vec![Member::default()];
        let mut close = "";
        while let Some(token) = self.peek() {
            let last = members.last_mut().expect("there is one from the beginning");
            match token.text {
                _ if token.kind == TokenKind::Close => {
                    close = token.text;
                    self.at += 1;
                    break;
                }
                "," => {
                    self.at += 1;
                    let mut next = Member::default();
                    // Comments before the comma move after it; those on lines of their own belong to what follows.
                    let mut comments = Vec::new();
                    while matches!(last.nodes.last(), Some(Node::Token(token)) if token.is_comment()) {
                        comments.extend(last.nodes.pop());
                    }
                    for node in comments.into_iter().rev() {
                        match node {
                            Node::Token(token) if token.trails() && next.nodes.is_empty() && open_line(last) => {
                                last.after.push(token);
                            }
                            apart => next.nodes.push(apart),
                        }
                    }
                    while let Some(comment) = self.peek().filter(|next| next.is_comment() && next.trails()) {
                        match next.nodes.is_empty() && open_line(last) {
                            true => last.after.push(comment),
                            false => next.nodes.push(Node::Token(comment)),
                        }
                        self.at += 1;
                    }
                    members.push(next);
                }
                _ => {
                    // Of the very many members of a long list, each has one node.
                    if last.nodes.is_empty() {
                        last.nodes.reserve_exact(1);
                    }
                    last.nodes.push(self.node());
                }
            }
        }
        // Comments alone after the last comma are not a member.
        let is_comment = |node: &Node| matches!(node, Node::Token(token) if token.is_comment());
        if members.len() > 1 && members.last().is_some_and(|last| last.nodes.iter().all(is_comment)) {
            let comments = members.pop().map(|member| member.nodes).unwrap_or_default();
            let last = members.last_mut().expect("there was more than one");
            last.after.extend(comments.into_iter().filter_map(|node| match node {
                Node::Token(token) => Some(token),
                _ => None,
            }));
        }
        members.retain(|member| !member.nodes.is_empty() || !member.after.is_empty());
        Node::Bracket { open, members, close }
    }
}

/// Whether more can follow on the line of a member and its comments.
fn open_line(member: &Member) -> bool {
    member.after.last().is_none_or(|token| token.kind != TokenKind::LineComment)
}

/// Whether a token is between statements.
fn is_aside(token: Token) -> bool {
    token.is_comment() || token.kind == TokenKind::Doc
}
