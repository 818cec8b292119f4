use std::fmt::Write;

use super::Catalog;
use base::signature::{Param, Signature};

impl Catalog {
    /// The part of the language reference that lists forms, kinds, keys, events and variables, as Markdown.
    pub fn reference(&self) -> String {
        let mut page = String::new();
        for form in &self.forms {
            let _ = writeln!(page, "## `{}`\n\n{}\n", form.name, form.doc);
            if let Some(plain) = &form.plain {
                let _ = writeln!(page, "`{} name {{ … }}`\n", form.name);
                contents(&mut page, plain);
            }
            for kind in &form.kinds {
                let _ =
                    writeln!(page, "### `{}`\n\n`{} name = {}(…)`: {}\n", kind.name, form.name, kind.name, kind.doc);
                if !kind.surrogate.is_empty() {
                    let _ = writeln!(page, "**A surrogate.** {}\n", kind.surrogate);
                }
                contents(&mut page, kind);
            }
        }
        page.push_str("## Events\n\n`on event => formula` inside a `reward`.\n\n| event | words | variables | when |\n|---|---|---|---|\n");
        for event in self.vocabulary.events.iter().filter(|event| event.answered) {
            let words = quoted(event.words);
            let _ = writeln!(page, "| `{}` | {words} | {} | {} |", event.name, quoted(&event.variables), event.doc);
        }
        page.push_str("\n## Variables\n\n| variable | measures | meaning |\n|---|---|---|\n");
        for variable in &self.vocabulary.variables {
            let _ = writeln!(page, "| `{}` | {} | {} |", variable.name, variable.measures(), variable.doc);
        }
        page
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

fn contents(page: &mut String, signature: &Signature) {
    if !signature.params.is_empty() {
        page.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
        for param in &signature.params {
            let _ = writeln!(
                page,
                "| `{}` | {} | {} | {} |",
                param.name,
                param.ty.describe_bounded(),
                default(param),
                param.doc
            );
        }
        page.push('\n');
    }
    for [low, high] in &signature.rising {
        let _ = writeln!(page, "`{low}` is at most `{high}`.\n");
    }
    if let Some(tick) = signature.tick {
        let _ = writeln!(page, "Made for ticks of {tick} s.\n");
    }
    for child in &signature.children {
        let _ = writeln!(page, "Block `{}`, {}: {}\n", child.name, child.occurrence(), child.doc);
        contents(page, child);
    }
}

fn default(param: &Param) -> String {
    match param.default {
        None => "must be given".into(),
        Some("") => "–".into(),
        Some(text) => format!("`{text}`"),
    }
}
