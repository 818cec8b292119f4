//! The meaning of every diagnostic code, with examples: the sections of `mistakes.md`.

/// A section of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mistake {
    pub code: &'static str,
    /// What it means.
    pub text: &'static str,
    /// A file that raises it. A `…` abbreviates a very long repetition of the text before it.
    pub bad: &'static str,
    /// The file repaired.
    pub good: &'static str,
}

/// All codes, in the order of the page.
pub fn mistakes() -> Vec<Mistake> {
    include_str!("mistakes.md").split("\n## ").skip(1).map(section).collect()
}

fn section(text: &'static str) -> Mistake {
    let (code, rest) = text.split_once("\n\n").expect("a section has a heading");
    let (text, examples) = rest.split_once("\n\nWrong:\n\n").expect("a section has a bad example");
    let (bad, good) = examples.split_once("\n\nRight:\n\n").expect("a section has a good example");
    Mistake { code, text, bad: fenced(bad), good: fenced(good) }
}

/// The text between the lines of a fence.
fn fenced(text: &'static str) -> &'static str {
    let inner = text.trim().trim_end_matches("```");
    inner.split_once('\n').map_or("", |(_, inner)| inner)
}
