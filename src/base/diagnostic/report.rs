use super::Span;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The file is not run.
    Error,
    /// The file runs, but probably not as intended.
    Warning,
}

/// A place in a source and its message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// A lower-case fragment; may be empty.
    pub text: String,
}

/// A text that would repair the file at its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fix {
    /// The place; empty for a text that is inserted.
    pub span: Span,
    pub text: String,
}

/// One message about the user's files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// A stable word code such as `unknown-key`.
    pub code: &'static str,
    /// What is wrong, in one line.
    pub message: String,
    /// Where it is wrong.
    pub primary: Label,
    /// Other places that matter, such as an earlier declaration.
    pub labels: Vec<Label>,
    /// What to do about it.
    pub help: Vec<String>,
    /// Alternative repairs; most are at the primary place.
    pub fixes: Vec<Fix>,
}

impl Fix {
    /// The repair in words.
    pub fn offer(&self) -> String {
        format!("write `{}`", self.text.trim())
    }
}

impl Diagnostic {
    /// Starts an error at a place.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            code,
            message: message.into(),
            primary: Label { span, text: String::new() },
            labels: Vec::new(),
            help: Vec::new(),
            fixes: Vec::new(),
        }
    }

    /// Starts a warning at a place.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, span, message) }
    }

    /// Sets the text at the primary place.
    pub fn here(mut self, text: impl Into<String>) -> Self {
        self.primary.text = text.into();
        self
    }

    /// Adds another place.
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds advice.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help.push(text.into());
        self
    }

    /// Offers a text in place of the primary span.
    pub fn fix(self, text: impl Into<String>) -> Self {
        let span = self.primary.span;
        self.fix_at(span, text)
    }

    /// Offers a text at another place.
    pub fn fix_at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.fixes.push(Fix { span, text: text.into() });
        self
    }

    /// The repairs in words; `None` without repairs.
    pub fn offer(&self) -> Option<String> {
        match self.fixes.as_slice() {
            [] => None,
            [fix] => Some(fix.offer()),
            fixes => {
                let quoted: Vec<String> = fixes.iter().map(|fix| format!("`{}`", fix.text.trim())).collect();
                Some(format!("did you mean {}?", quoted.join(" or ")))
            }
        }
    }
}
