//! Documents of text and possible line ends, and how they are set within a width.
//!
//! # Source
//! The command language of Wadler, "A prettier printer" (2003), with the *fill* of Prettier.

use std::borrow::Cow;

/// A piece of a page.
#[derive(Debug, Clone)]
pub enum Doc<'a> {
    /// Text without line ends, or a comment with them.
    Text(Cow<'a, str>),
    /// A blank between two words; nothing at the start of a line.
    Space,
    /// A line end if the group is broken, else this text.
    Line(&'static str),
    /// A line end.
    Hard,
    /// An empty line.
    Blank,
    /// Pieces one after the other.
    Row(Vec<Doc<'a>>),
    /// Set two columns deeper after every line end inside.
    Indent(Vec<Doc<'a>>),
    /// On one line if it fits, else broken at all its lines.
    Group(Vec<Doc<'a>>),
    /// Pieces with separators between them, as many on a line as fit.
    Fill(Vec<Doc<'a>>),
}

impl Doc<'_> {
    /// Whether it cannot stand on one line.
    pub fn breaks(&self) -> bool {
        match self {
            Doc::Text(text) => text.contains('\n'),
            Doc::Hard | Doc::Blank => true,
            Doc::Row(inner) | Doc::Indent(inner) | Doc::Group(inner) | Doc::Fill(inner) => {
                inner.iter().any(Doc::breaks)
            }
            Doc::Space | Doc::Line(_) => false,
        }
    }

    /// Columns on one line, counted up to a limit.
    fn width(&self, limit: usize) -> usize {
        match self {
            Doc::Text(text) => text.chars().count(),
            Doc::Space => 1,
            Doc::Line(flat) => flat.len(),
            Doc::Hard | Doc::Blank => limit + 1,
            Doc::Row(inner) | Doc::Indent(inner) | Doc::Group(inner) | Doc::Fill(inner) => {
                let mut sum = 0;
                for doc in inner {
                    sum += doc.width(limit.saturating_sub(sum));
                    if sum > limit {
                        break;
                    }
                }
                sum
            }
        }
    }
}

/// Sets a document within a width (columns).
pub fn print(doc: &Doc, width: usize) -> String {
    let mut page = Page { text: String::new(), column: 0, pending: None, space: false, width };
    page.put(doc, 0, false, 0);
    if !page.text.is_empty() {
        page.text.push('\n');
    }
    page.text
}

struct Page {
    text: String,
    column: usize,
    /// A line end that is still to be written, with the indentation after it.
    pending: Option<usize>,
    /// A blank that is still to be written.
    space: bool,
    width: usize,
}

impl Page {
    fn word(&mut self, text: &str) {
        if let Some(indent) = self.pending.take() {
            if !self.text.is_empty() {
                self.text.push('\n');
            }
            self.text.extend(std::iter::repeat_n(' ', indent));
            self.column = indent;
        } else if self.space && !self.text.is_empty() {
            self.text.push(' ');
            self.column += 1;
        }
        self.space = false;
        self.text.push_str(text);
        self.column = match text.rfind('\n') {
            Some(at) => text[at + 1..].chars().count(),
            None => self.column + text.chars().count(),
        };
    }

    fn column(&self) -> usize {
        self.pending.unwrap_or(self.column + usize::from(self.space))
    }

    /// Whether a document fits on this line together with the columns that follow it.
    fn fits(&self, doc: &Doc, behind: usize) -> bool {
        let room = self.width.saturating_sub(self.column() + behind);
        !doc.breaks() && doc.width(room) <= room
    }

    /// Prints a document; `behind` is the number of columns that must follow it on its line.
    fn put(&mut self, doc: &Doc, indent: usize, flat: bool, behind: usize) {
        match doc {
            Doc::Text(text) => self.word(text),
            Doc::Space => self.space = true,
            Doc::Line(text) if flat => self.word(text),
            Doc::Line(_) | Doc::Hard => self.pending = Some(indent),
            Doc::Blank => {
                if !self.text.is_empty() && !self.text.ends_with("\n") {
                    self.text.push('\n');
                }
                self.pending = Some(indent);
            }
            Doc::Row(inner) => self.row(inner, indent, flat, behind),
            Doc::Indent(inner) => self.row(inner, indent + 2, flat, behind),
            Doc::Group(inner) => {
                let flat = flat || self.fits(doc, behind);
                self.row(inner, indent, flat, behind);
            }
            Doc::Fill(inner) => self.fill(inner, indent, flat, behind),
        }
    }

    fn row(&mut self, docs: &[Doc], indent: usize, flat: bool, behind: usize) {
        for (index, doc) in docs.iter().enumerate() {
            self.put(doc, indent, flat, tail(&docs[index + 1..], behind));
        }
    }

    fn fill(&mut self, docs: &[Doc], indent: usize, flat: bool, behind: usize) {
        for (index, doc) in docs.iter().enumerate() {
            let is_separator = index % 2 == 1;
            let last = index + 2 >= docs.len();
            if is_separator {
                let next = &docs[index + 1];
                let room = self.width.saturating_sub(self.column() + if last { behind } else { 1 });
                let together = doc.width(room) + next.width(room);
                let fits = !doc.breaks() && !next.breaks() && together <= room;
                self.put(doc, indent, flat || fits, 0);
            } else {
                let alone = flat || self.fits(doc, if last { behind } else { 0 });
                self.put(doc, indent, alone, if last { behind } else { 0 });
            }
        }
    }
}

/// Columns of the following documents that cannot be separated from this one.
fn tail(docs: &[Doc], behind: usize) -> usize {
    let mut sum = 0;
    for doc in docs {
        match doc {
            Doc::Text(text) => sum += text.chars().count(),
            Doc::Space => sum += 1,
            _ => return sum,
        }
    }
    sum + behind
}
