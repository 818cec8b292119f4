//! What the language offers as Markdown, each thing rendered in one place: the language reference, `falsify explain` and editors show it.

use std::collections::BTreeSet;
use std::fmt::{Display, Write};

use super::Catalog;
use base::signature::{Event, Form, Param, Signature, Type, Variable};

impl Catalog {
    /// The part of the language reference that lists forms, kinds, keys, events and variables, as Markdown. Of a key it has the default and the first
    /// sentence, once in a form; `falsify explain` has units, bounds and the rest.
    pub fn reference(&self) -> String {
        let mut page = String::new();
        for each in &self.forms {
            let mut said = BTreeSet::new();
            let mut once = |param: &Param| {
                let line = format!("- {}: {}.\n", listed_key(param), first_sentence(param.doc));
                said.insert(line.clone()).then_some(line)
            };
            let _ = writeln!(page, "## `{}`\n\n{}\n", each.name, each.doc);
            page.extend(each.plain.iter().map(|plain| with_keys(&head(each, None), plain, &mut once)));
            for kind in &each.kinds {
                let _ = write!(page, "### `{}`\n\n{}", kind.name, with_keys(&head(each, Some(kind)), kind, &mut once));
            }
        }
        page.push_str("## Events\n\n`on event => formula` inside a `reward`.\n\n");
        let events: Vec<&Event> = self.vocabulary.events.iter().filter(|each| each.answered).collect();
        for each in &events {
            let all = &events[0].variables;
            let missing: Vec<_> = all.iter().filter(|name| !each.variables.contains(name)).collect();
            let is_part = !missing.is_empty() && each.variables.iter().all(|name| all.contains(name));
            let rest = || format!("those of `{}` but {}", events[0].name, quoted(&missing));
            page.push_str(&event_with(each, &if is_part { rest() } else { quoted(&each.variables) }));
        }
        page.push_str("\n## Variables\n\n");
        page.extend(self.vocabulary.variables.iter().map(variable));
        page.push_str("\n## Signals of roles\n\nIn a requirement: `child.gap`, towards the car under test; `gap(child, van)`, towards another role.\n\n");
        page.extend(self.vocabulary.signals.iter().map(variable));
        page
    }
}

/// A declaration of a form, perhaps of one of its kinds.
pub(super) fn head(form: &Form, kind: Option<&Signature>) -> String {
    match kind {
        Some(kind) => format!("{} name = {}(…)", form.name, kind.name),
        None => format!("{} name {{ … }}", form.name),
    }
}

/// A form with its keys, and its kinds without theirs.
pub(super) fn form(form: &Form) -> String {
    let mut page = format!("**{}** {}\n\n", form.name, form.doc);
    page.extend(form.plain.iter().map(|plain| signature(&head(form, None), plain)));
    page.extend(form.kinds.iter().map(|kind| format!("- `{}`: {}\n", head(form, Some(kind)), kind.doc)));
    if !form.kinds.is_empty() {
        let _ = writeln!(page, "\n`falsify explain {} KIND` lists the keys of a kind.", form.name);
    }
    page
}

/// A kind, or a block, with its keys and its blocks.
pub(super) fn signature(head: &str, of: &Signature) -> String {
    with_keys(head, of, &mut |param| Some(key(param)))
}

/// A kind, or a block, with its blocks and the lines of its keys; a key without a line is named.
fn with_keys(head: &str, of: &Signature, line: &mut dyn FnMut(&Param) -> Option<String>) -> String {
    let colon = if of.doc.is_empty() { "" } else { ": " };
    let mut page = format!("`{head}`{colon}{}\n\n", of.doc);
    if !of.surrogate.is_empty() {
        let _ = writeln!(page, "**A surrogate.** {}\n", of.surrogate);
    }
    let mut above = Vec::new();
    for param in &of.params {
        match line(param) {
            Some(line) => page.push_str(&line),
            None => above.push(format!("`{}`", param.name)),
        }
    }
    page.extend((!above.is_empty()).then(|| format!("- As above: {}.\n", above.join(", "))));
    page.extend(of.clauses.then_some("- `on event => formula`: see `falsify explain events`.\n"));
    page.extend(of.rising.iter().map(|[low, high]| format!("- `{low}` is at most `{high}`.\n")));
    page.extend(of.tick.map(|tick| format!("- Made for ticks of {tick} s.\n")));
    if !page.ends_with("\n\n") {
        page.push('\n');
    }
    page.extend(of.children.iter().map(|child| block_with_keys(child, line)));
    page
}

/// A block with its keys.
pub fn block(child: &Signature) -> String {
    block_with_keys(child, &mut |param| Some(key(param)))
}

fn block_with_keys(child: &Signature, line: &mut dyn FnMut(&Param) -> Option<String>) -> String {
    let occurs = if child.once { "at most once" } else { "any number of times" };
    with_keys(&format!("{} {{ … }}", child.name), child, line).replacen("`:", &format!("`, {occurs}:"), 1)
}

/// A key with its type, units, default and meaning, as a line of a list.
pub fn key(param: &Param) -> String {
    format!("- {}. {}\n", short_key(param), param.doc)
}

/// A key with its type, units and default.
pub fn short_key(param: &Param) -> String {
    let default = match param.default {
        None => "required".into(),
        Some("") => "optional".into(),
        Some(text) => format!("default `{text}`"),
    };
    format!("`{}`: {}; {default}", param.name, param.ty.describe_bounded())
}

/// A key with its words or its default; without one, what is to be written.
fn listed_key(param: &Param) -> String {
    let name = param.name;
    match (&param.ty, param.default) {
        (Type::Choice(words) | Type::Step(words), Some(default)) if !default.is_empty() => {
            let others = words.iter().filter(|word| **word != default).map(|word| format!(" or `{word}`"));
            format!("`{name}` = `{default}`{}", others.collect::<String>())
        }
        (ty, None) => format!("`{name}` (required, {})", ty.describe()),
        (ty, Some("")) => format!("`{name}` ({})", ty.describe()),
        (_, Some(default)) => format!("`{name}` = `{default}`"),
    }
}

pub(super) fn event(event: &Event) -> String {
    event_with(event, &quoted(&event.variables))
}

fn quoted(words: &[impl Display]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

fn event_with(event: &Event, variables: &str) -> String {
    let head = if event.answered { "on " } else { "" };
    let only = if event.answered { "" } else { " Only for conditions." };
    let words = if event.words.is_empty() { String::new() } else { format!(" Words: {}.", quoted(event.words)) };
    format!("- `{head}{}`: {}{only}{words} Variables: {variables}.\n", event.name, event.doc)
}

pub(super) fn variable(variable: &Variable) -> String {
    format!("- `{}` ({}): {}\n", variable.name, variable.within(), variable.doc)
}

pub(super) fn function((name, doc): (&str, &str)) -> String {
    format!("- `{name}(…)`: {doc}\n")
}

/// The first sentence of a text, without its point.
pub(super) fn first_sentence(text: &str) -> &str {
    text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.')
}
