//! Values from outside a declaration: `--set far=20 m`, `--set ppo_paper.learning_rate=1e-3`, and the rows of a `matrix`.
//!
//! A setting is applied to the tree before the checks. It is therefore checked like the text of a file.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::ast::{Declaration, Entry, Expression, ExpressionKind, Name, Property};
use super::parse::parse_value;
use super::{Loaded, diagnostics};
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::signature::Form;
use base::units::{Dimension, parse_unit};

/// The word of a block that multiplies a declaration.
const MATRIX: &str = "matrix";
/// Maximum number of combinations of all matrices.
const MAX_COMBINATIONS: usize = 1000;
/// Maximum number of repeated checks of parameters and declarations, in all: each combination checks all of them.
const MAX_CHECKS: usize = 300_000;

/// A value for a parameter, or for a key of a declaration.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The name of a parameter, or the words of the path to a key.
    pub path: Vec<Name>,
    pub value: Expression,
}

impl Setting {
    /// The setting as recorded.
    pub fn text(&self, sources: &Sources) -> String {
        format!("{} = {}", self.words(), sources.plain_text(self.value.span))
    }

    /// The words of its path.
    pub fn words(&self) -> String {
        let path: Vec<&str> = self.path.iter().map(|word| word.text.as_str()).collect();
        path.join(".")
    }
}

/// A declaration that is made once for each combination of settings.
#[derive(Debug, Clone)]
pub struct Matrix {
    /// The file of the declaration, and its place in it.
    pub declaration: (SourceId, usize),
    /// The combinations, the last key changing fastest.
    pub combinations: Vec<Vec<Setting>>,
}

/// Reads settings from a command line.
pub fn settings(texts: &[String], sources: &mut Sources) -> (Vec<Setting>, Vec<Diagnostic>) {
    let (mut settings, mut diagnostics) = (Vec::new(), Vec::new());
    for text in texts {
        let source = sources.add("--set", text.clone());
        match read(source, text) {
            Ok(setting) => settings.push(setting),
            Err(diagnostic) => diagnostics.push(*diagnostic),
        }
    }
    (settings, diagnostics)
}

fn read(source: SourceId, text: &str) -> Result<Setting, Box<Diagnostic>> {
    let whole = Span { source, start: 0, end: text.len() };
    let Some(sign) = text.find('=') else { return Err(diagnostics::bad_setting(whole, "it has no `=`").into()) };
    let mut path = Vec::new();
    let mut start = 0;
    for word in text[..sign].split('.') {
        let trimmed = word.trim();
        let begin = start + (word.len() - word.trim_start().len());
        let span = Span { source, start: begin, end: begin + trimmed.len() };
        if trimmed.is_empty() || !trimmed.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(diagnostics::bad_setting(whole, "names are letters, digits and `_`").into());
        }
        path.push(Name { text: trimmed.to_string(), span });
        start += word.len() + 1;
    }
    // The value keeps its place in the text.
    let blank = " ".repeat(sign + 1);
    let value = parse_value(source, &format!("{blank}{}", &text[sign + 1..]))?;
    Ok(Setting { path, value })
}

/// Applies settings and reports those without a target.
pub fn apply(settings: &[Setting], loaded: &mut Loaded) -> Vec<Diagnostic> {
    let mut params: BTreeMap<String, Vec<(usize, usize)>> = BTreeMap::new();
    for (file, place) in loaded.files.iter().zip(0..) {
        for (param, index) in file.params.iter().zip(0..) {
            params.entry(param.name.text.clone()).or_default().push((place, index));
        }
    }
    let mut said = Vec::new();
    let mut done: BTreeMap<String, Span> = BTreeMap::new();
    for setting in settings {
        let place = setting.path[0].span.to(setting.value.span);
        if let Some(first) = done.insert(setting.words(), place) {
            said.push(diagnostics::repeated_setting(place, &setting.words(), first));
        }
        let done = match setting.path.as_slice() {
            [] => unreachable!("a path has a word"),
            [name] => match params.get(&name.text) {
                Some(places) => {
                    for (place, index) in places {
                        let param = &mut loaded.files[*place].params[*index];
                        param.value = setting.value.clone();
                        param.setting = Some(name.span.to(setting.value.span));
                    }
                    Ok(())
                }
                None => {
                    let mut declared = loaded.files.iter().flat_map(|file| &file.declarations);
                    if declared.any(|each| each.name.as_ref().is_some_and(|known| known.text == name.text)) {
                        let reason = format!("`{}` is a declaration, not a parameter; name one of its keys", name.text);
                        said.push(diagnostics::bad_setting(name.span, &reason));
                        continue;
                    }
                    let known: Vec<&str> = params.keys().map(String::as_str).collect();
                    Err(diagnostics::unknown_setting(name.span, &name.text, &known).into())
                }
            },
            [first, rest @ ..] => set(first, rest, setting, loaded),
        };
        said.extend(done.err().map(|diagnostic| *diagnostic));
    }
    said
}

/// Sets a key of a declaration.
fn set(first: &Name, path: &[Name], setting: &Setting, loaded: &mut Loaded) -> Result<(), Box<Diagnostic>> {
    let all = || loaded.files.iter().flat_map(|file| &file.declarations);
    let named = |declaration: &Declaration, name: &Name| declaration.name.as_ref().is_some_and(|n| n.text == name.text);
    let forms: Vec<String> = all().filter(|each| named(each, first)).map(|each| each.form.text.clone()).collect();
    let (form, name, rest) = match forms.as_slice() {
        [form] => (form.clone(), first, path),
        [] if path.len() > 1 && all().any(|each| each.form.text == first.text && named(each, &path[0])) => {
            (first.text.clone(), &path[0], &path[1..])
        }
        [] => {
            let known: Vec<&str> = all().filter_map(|each| Some(each.name.as_ref()?.text.as_str())).collect();
            return Err(diagnostics::unknown_setting(first.span, &first.text, &known).into());
        }
        several => {
            let forms: Vec<&str> = several.iter().map(String::as_str).collect();
            return Err(diagnostics::ambiguous_setting(first.span, &first.text, &forms).into());
        }
    };
    let all = loaded.files.iter_mut().flat_map(|file| &mut file.declarations);
    for declaration in all.filter(|each| each.form.text == form && named(each, name)) {
        enter(Arc::make_mut(declaration), rest, &setting.value)?;
    }
    Ok(())
}

/// Sets a key of a declaration, or of its blocks of a form (all of them, or the one of a name), or of its block of a name.
fn enter(declaration: &mut Declaration, path: &[Name], value: &Expression) -> Result<(), Box<Diagnostic>> {
    let (word, rest) = path.split_first().expect("a path has a word left");
    if rest.is_empty() {
        let given = declaration.entries.iter_mut().find_map(|entry| match entry {
            Entry::Property(property) if property.key.text == word.text => Some(property),
            _ => None,
        });
        match given {
            Some(property) => property.value = value.clone(),
            None => {
                let property = Property { key: word.clone(), value: value.clone() };
                declaration.entries.push(Entry::Property(property));
            }
        }
        return Ok(());
    }
    let mut blocks: Vec<&mut Declaration> = Vec::new();
    let mut words: Vec<String> = Vec::new();
    for entry in &mut declaration.entries {
        if let Entry::Child(child) = entry {
            words.extend([&child.form].into_iter().chain(&child.name).map(|known| known.text.clone()));
            blocks.push(child);
        }
    }
    let named = |block: &Declaration, name: &Name| block.name.as_ref().is_some_and(|known| known.text == name.text);
    let (by_form, by_name) =
        (|block: &Declaration| block.form.text == word.text, |block: &Declaration| named(block, word));
    let rest = if blocks.iter().any(|block| by_form(block)) {
        blocks.retain(|block| by_form(block));
        match rest.split_first() {
            // Among blocks of one form, that of a name.
            Some((name, inner)) if !inner.is_empty() && blocks.iter().any(|block| named(block, name)) => {
                blocks.retain(|block| named(block, name));
                inner
            }
            _ => rest,
        }
    } else {
        blocks.retain(|block| by_name(block));
        rest
    };
    if blocks.is_empty() {
        words.sort_unstable();
        words.dedup();
        let known: Vec<&str> = words.iter().map(String::as_str).collect();
        return Err(diagnostics::unknown_setting(word.span, &word.text, &known).into());
    }
    blocks.into_iter().try_for_each(|block| enter(block, rest, value))
}

/// Removes the `matrix` blocks from the declarations whose form they may multiply. A parameter that was set from outside keeps
/// that value.
pub fn matrices(
    loaded: &mut Loaded,
    forms: &[Form],
    settings: &[Setting],
    sources: &Sources,
) -> (Vec<Matrix>, Vec<Diagnostic>) {
    let (mut matrices, mut diagnostics) = (Vec::new(), Vec::new());
    let size: usize = loaded.files.iter().map(|file| file.params.len() + file.declarations.len()).sum();
    let mut left = MAX_COMBINATIONS.min(MAX_CHECKS / size.max(1));
    for file in &mut loaded.files {
        for (index, declaration) in file.declarations.iter_mut().enumerate() {
            if !forms.iter().any(|form| form.multiplies && form.name == declaration.form.text) {
                continue;
            }
            let is_matrix = |entry: &Entry| matches!(entry, Entry::Child(child) if child.form.text == MATRIX);
            if !declaration.entries.iter().any(is_matrix) {
                continue;
            }
            let entries = &mut Arc::make_mut(declaration).entries;
            let taken: Vec<Entry> = entries.extract_if(.., |entry| is_matrix(entry)).collect();
            let (mut axes, mut seen) = (Vec::new(), BTreeMap::new());
            for block in &taken {
                let Entry::Child(block) = block else { continue };
                axes_of(block, &mut axes, &mut seen, sources, &mut diagnostics);
            }
            axes.retain(|axis| !settings.iter().any(|set| matches!(&*set.path, [name] if name.text == axis.key.text)));
            let found = axes.iter().map(|axis| members(axis).len()).fold(1_usize, usize::saturating_mul);
            if found > left {
                diagnostics.push(diagnostics::too_many_combinations(declaration.head, found, left));
                continue;
            }
            left -= found;
            matrices.push(Matrix { declaration: (file.source, index), combinations: product(&axes) });
        }
    }
    (matrices, diagnostics)
}

/// Collects the keys of a matrix.
fn axes_of<'a>(
    block: &'a Declaration,
    axes: &mut Vec<&'a Property>,
    seen: &mut BTreeMap<&'a str, Span>,
    sources: &Sources,
    diagnostics: &mut Vec<Diagnostic>,
) {
    for entry in &block.entries {
        match entry {
            Entry::Property(property) => match seen.get(property.key.text.as_str()) {
                Some(first) => {
                    diagnostics.push(diagnostics::duplicate_key(property.key.span, &property.key.text, *first));
                }
                None if members(property).is_empty() => diagnostics.push(diagnostics::empty_list(property.value.span)),
                None if matches!(property.value.kind, ExpressionKind::Range(..)) => {
                    diagnostics.push(diagnostics::axis_range(property.value.span));
                    seen.insert(&property.key.text, property.key.span);
                }
                None => {
                    let mut said: BTreeMap<String, Span> = BTreeMap::new();
                    for member in members(property) {
                        let value = in_si(member).unwrap_or_else(|| text_of(member, sources));
                        if let Some(first) = said.insert(value, member.span) {
                            diagnostics.push(diagnostics::repeated_member(
                                member.span,
                                sources.text(member.span),
                                first,
                            ));
                        }
                    }
                    seen.insert(&property.key.text, property.key.span);
                    axes.push(property);
                }
            },
            Entry::Bare(value) => {
                diagnostics.push(diagnostics::bare_argument(value.span, sources.text(value.span), &[]));
            }
            Entry::Unread => {}
            Entry::Clause(clause) => diagnostics.push(diagnostics::unexpected_clause(clause.event.span, MATRIX)),
            Entry::Child(child) => {
                diagnostics.push(diagnostics::unknown_block(child.form.span, MATRIX, &child.form.text, &[]));
            }
        }
    }
}

/// The text by which two values of an axis are equal: a kind with its keys is the same with other blanks.
fn text_of(value: &Expression, sources: &Sources) -> String {
    let text = sources.plain_text(value.span);
    match value.kind {
        ExpressionKind::Call { .. } => text.split_whitespace().collect(),
        _ => text.to_string(),
    }
}

/// A quantity in SI, in whatever unit it is written; `None` for other values.
fn in_si(value: &Expression) -> Option<String> {
    let ExpressionKind::Number { value, unit } = &value.kind else { return None };
    let unit = parse_unit(unit.as_ref().map_or("", |unit| unit.text.as_str())).ok();
    let (factor, dimension) = unit.map_or((1.0, Dimension::RATIO), |unit| (unit.factor, unit.dimension));
    Some(format!("{:e} {dimension}", value * factor))
}

fn members(axis: &Property) -> &[Expression] {
    match &axis.value.kind {
        ExpressionKind::List(members) => members,
        _ => std::slice::from_ref(&axis.value),
    }
}

fn product(axes: &[&Property]) -> Vec<Vec<Setting>> {
    let count: usize = axes.iter().map(|axis| members(axis).len()).product();
    let combination = |number: usize| {
        let mut rest = number;
        let mut settings: Vec<Setting> = Vec::new();
        for axis in axes.iter().rev() {
            let values = members(axis);
            let value = values[rest % values.len()].clone();
            rest /= values.len();
            settings.push(Setting { path: vec![axis.key.clone()], value });
        }
        settings.reverse();
        settings
    };
    (0..count).map(combination).collect()
}
