use std::fmt::{Display, Write};

/// A text of XML that grows element by element, indented by two spaces.
#[derive(Debug)]
pub(super) struct Xml {
    text: String,
    depth: usize,
}

/// Attributes of an element, in order.
pub(super) type Attributes<'a> = &'a [(&'a str, &'a dyn Display)];

/// Attributes of an element: `attributes! { id: 7, name: road.name, rule }`.
macro_rules! attributes {
    ($($key:ident $(: $value:expr)?),* $(,)?) => {
        &[$((stringify!($key), &$crate::xml::attributes!(@value $key $(: $value)?) as &dyn std::fmt::Display)),*]
    };
    (@value $key:ident) => { $key };
    (@value $key:ident: $value:expr) => { $value };
}
pub(super) use attributes;

impl Xml {
    /// A document with one element, whose content the function writes.
    pub fn document(name: &str, attributes: Attributes, content: impl FnOnce(&mut Self)) -> String {
        let mut xml = Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(), depth: 0 };
        xml.element(name, attributes, content);
        xml.text
    }

    /// Elements without a document around them.
    pub fn fragment(content: impl FnOnce(&mut Self)) -> String {
        let mut xml = Self { text: String::new(), depth: 0 };
        content(&mut xml);
        xml.text
    }

    /// An element whose content the function writes.
    pub fn element(&mut self, name: &str, attributes: Attributes, content: impl FnOnce(&mut Self)) {
        self.start(name, attributes);
        let before = self.text.len();
        self.text.push_str(">\n");
        self.depth += 1;
        content(self);
        self.depth -= 1;
        if self.text.len() == before + 2 {
            self.text.truncate(before);
            self.text.push_str("/>\n");
            return;
        }
        self.indent();
        self.put(format_args!("</{name}>\n"));
    }

    /// Elements without attributes, each in the one before; the function writes the content of the last.
    pub fn within(&mut self, names: &[&str], content: impl FnOnce(&mut Self)) {
        match names {
            [] => content(self),
            [name, inner @ ..] => self.element(name, &[], |xml| xml.within(inner, content)),
        }
    }

    /// A comment, without two hyphens in a row.
    pub fn comment(&mut self, text: &str) {
        self.indent();
        self.put(format_args!("<!-- {text} -->\n"));
    }

    /// An element without content.
    pub fn empty(&mut self, name: &str, attributes: Attributes) {
        self.start(name, attributes);
        self.text.push_str("/>\n");
    }

    /// An element that holds a text.
    pub fn text(&mut self, name: &str, text: &dyn Display) {
        self.start(name, &[]);
        self.text.push('>');
        self.escaped(text);
        self.put(format_args!("</{name}>\n"));
    }

    fn start(&mut self, name: &str, attributes: Attributes) {
        self.indent();
        self.put(format_args!("<{name}"));
        for (key, value) in attributes {
            self.put(format_args!(" {key}=\""));
            self.escaped(*value);
            self.text.push('"');
        }
    }

    fn indent(&mut self) {
        self.text.extend(std::iter::repeat_n("  ", self.depth));
    }

    fn put(&mut self, text: std::fmt::Arguments) {
        self.text.write_fmt(text).expect("a string takes everything");
    }

    /// Characters that XML cannot hold become spaces.
    fn escaped(&mut self, value: &dyn Display) {
        for character in value.to_string().chars() {
            match character {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '"' => self.text.push_str("&quot;"),
                control if control.is_control() || matches!(control, '\u{fffe}' | '\u{ffff}') => self.text.push(' '),
                other => self.text.push(other),
            }
        }
    }
}

/// A number with at most nine decimals (1 nm, 1 nrad) and no zeros at its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Short(pub f64);

impl Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.9}", self.0);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_can_be_read() {
        let name = "a < b & \"c\"\u{7} > d";
        let text = Xml::document("town", &[("name", &name)], |xml| {
            xml.empty("road", &[("s", &Short(-1e-12)), ("length", &Short(2.5))]);
            xml.within(&["empty"], |_| {});
        });
        let read = roxmltree::Document::parse(&text).unwrap();
        let root = read.root_element();
        assert_eq!(root.attribute("name"), Some("a < b & \"c\"  > d"));
        let children: Vec<_> = root.children().filter(roxmltree::Node::is_element).collect();
        assert_eq!((children[0].attribute("s"), children[0].attribute("length")), (Some("0"), Some("2.5")));
        assert_eq!(children.len(), 2);
        assert!(text.contains("  <empty/>\n"), "{text}");
    }
}
