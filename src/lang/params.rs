//! Parameters: `param far: length = 30 m`, used by name wherever a value is allowed.
//!
//! A parameter is checked against its type once, where it is declared; its uses get a known value.

use std::collections::{BTreeMap, BTreeSet};

use super::ast::{Clause, Declaration, Entry, Expression, ExpressionKind, Known, Param, Property};
use super::hir::ParamId;
use super::names::Names;
use super::value::{Context, distributions, value};
use super::{Loaded, diagnostics, hir};
use base::diagnostic::{Diagnostic, Label, SourceId, Sources, Span};
use base::signature::{Form, Signature, Type, Value, Vocabulary};
use base::units::Dimension;

/// Words for types that are dimensions.
pub const DIMENSIONS: &[(&str, Dimension)] = &[
    ("number", Dimension::RATIO),
    ("length", Dimension::LENGTH),
    ("time", Dimension::TIME),
    ("speed", Dimension::SPEED),
    ("acceleration", Dimension::ACCELERATION),
    ("jerk", Dimension::JERK),
    ("angle", Dimension::ANGLE),
    ("frequency", Dimension::FREQUENCY),
    ("turn_rate", Dimension::TURN_RATE),
    ("mass", Dimension::MASS),
];

/// The other words for types; the name of a form is one as well.
pub const OTHER_TYPES: &[&str] = &["integer", "boolean", "text", "word"];

/// The values of parameters.
pub(super) struct Params<'a> {
    loaded: &'a Loaded,
    names: &'a [Names<'a>],
    forms: &'a [Form],
    vocabulary: &'a Vocabulary,
    sources: &'a Sources,
    known: BTreeMap<ParamId, Option<ExpressionKind>>,
    used: BTreeSet<ParamId>,
    /// The uses of parameters, by the place of the first byte, with their declarations.
    uses: BTreeMap<(SourceId, usize), (Span, ParamId)>,
}

impl<'a> Params<'a> {
    /// Checks all parameters of all files.
    pub fn resolve(
        loaded: &'a Loaded,
        names: &'a [Names<'a>],
        forms: &'a [Form],
        vocabulary: &'a Vocabulary,
        sources: &'a Sources,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Self {
        let (known, used, uses) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::new());
        let mut params = Self { loaded, names, forms, vocabulary, sources, known, used, uses };
        for file in &loaded.files {
            for index in 0..file.params.len() {
                if !params.known.contains_key(&(file.source, index)) {
                    params.find((file.source, index), diagnostics);
                }
            }
        }
        params
    }

    /// The parameters that a declaration names, with their values; `place` is the index of its file.
    pub fn mentioned(&self, declaration: &Declaration, place: usize) -> Vec<(ParamId, Option<ExpressionKind>)> {
        let names = &self.names[place];
        let mut found = Vec::new();
        if names.params().next().is_some() {
            declaration.entries.iter().for_each(|entry| mentioned_in(entry, names, &mut found));
        }
        found.into_iter().map(|id| (id, self.known.get(&id).cloned().flatten())).collect()
    }

    /// These parameters and those that define them, each once.
    pub fn behind(&self, mentioned: &[(ParamId, Option<ExpressionKind>)]) -> Vec<ParamId> {
        let mut open: Vec<ParamId> = mentioned.iter().rev().map(|(id, _)| *id).collect();
        let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
        while let Some(id) = open.pop() {
            if seen.insert(id) {
                found.push(id);
                self::mentioned(&self.param(id).value, &self.names[self.read_in(id)], &mut open);
            }
        }
        found
    }

    /// Whether parameters still have the same values; if so they count as used.
    pub fn are_still(&mut self, mentioned: &[(ParamId, Option<ExpressionKind>)]) -> bool {
        let same = mentioned.iter().all(|(id, before)| self.known.get(id).is_some_and(|now| now == before));
        if same {
            self.used.extend(mentioned.iter().map(|(id, _)| *id));
        }
        same
    }

    /// The declaration with known values in place of its parameters.
    pub fn replace(&mut self, declaration: &Declaration, place: usize) -> Declaration {
        let mut copy = declaration.clone();
        self.entries(&mut copy.entries, place);
        copy
    }

    /// Adds the origin of a value to messages about places where a parameter is used.
    pub fn explain(&self, diagnostics: &mut [Diagnostic]) {
        for diagnostic in diagnostics {
            let Span { source, start, end } = diagnostic.primary.span;
            let first = self.uses.range((source, start)..=(source, end)).next();
            if let Some((_, (_, id))) = first.filter(|(_, (span, _))| span.end <= end) {
                let param = self.param(*id);
                let (span, text) = match param.setting {
                    Some(setting) => (setting, format!("`{}` is set here", param.name.text)),
                    None => (param.name.span.to(param.ty.span), format!("the parameter `{}`", param.name.text)),
                };
                diagnostic.labels.push(Label { span, text });
            }
        }
    }

    /// The results for the parameters, in the order of the files.
    pub fn finish(self) -> Vec<hir::Param> {
        let each = |(id, known): (&ParamId, &Option<ExpressionKind>)| {
            let param = self.param(*id);
            known.as_ref()?;
            Some(hir::Param {
                id: *id,
                name: param.name.text.clone(),
                ty: param.ty.text.clone(),
                docs: param.docs.clone(),
                value: self.sources.plain_text(param.value.span),
                used: self.used.contains(id),
                span: param.name.span,
            })
        };
        self.known.iter().filter_map(each).collect()
    }

    fn param(&self, id: ParamId) -> &'a Param {
        &self.loaded.files[self.place(id.0)].params[id.1]
    }

    /// The index of a file in the order of the files.
    fn place(&self, source: SourceId) -> usize {
        self.loaded.files.binary_search_by_key(&source, |file| file.source).expect("the file is loaded")
    }

    /// The index of the file whose names a parameter's value may use: the file of its declaration, or that of the matrix that sets it.
    fn read_in(&self, id: ParamId) -> usize {
        let param = self.param(id);
        let set_in = |_| self.loaded.files.binary_search_by_key(&param.value.span.source, |file| file.source).ok();
        param.setting.and_then(set_in).unwrap_or_else(|| self.place(id.0))
    }

    /// Checks a parameter, after those that define it. It does not recurse, since a chain of them may have any length.
    fn find(&mut self, id: ParamId, diagnostics: &mut Vec<Diagnostic>) {
        let mut open = vec![self.begin(id, diagnostics)];
        let mut begun = BTreeSet::from([id]);
        while let Some((place, id, needed)) = open.last_mut() {
            let (place, id) = (*place, *id);
            if let Some(next) = needed.pop() {
                if self.known.contains_key(&next) {
                    continue;
                }
                if begun.insert(next) {
                    let next = self.begin(next, diagnostics);
                    open.push(next);
                } else {
                    let name = &self.param(next).name;
                    diagnostics.push(diagnostics::param_cycle(name.span, &name.text));
                    self.known.insert(next, None);
                }
                continue;
            }
            open.pop();
            // A parameter of a cycle is known to be wrong.
            if !self.known.contains_key(&id) {
                let param = self.param(id);
                let mut written = param.value.clone();
                self.expression(&mut written, place);
                let found = self.checked(param, &written, place, diagnostics);
                self.known.insert(id, found);
            }
        }
    }

    /// A parameter to check, with those that must be checked before it, the first one last.
    fn begin(&self, id: ParamId, diagnostics: &mut Vec<Diagnostic>) -> (usize, ParamId, Vec<ParamId>) {
        let (param, place) = (self.param(id), self.read_in(id));
        if self.vocabulary.variables.iter().any(|variable| variable.name == param.name.text) {
            diagnostics.push(diagnostics::reserved_name(param.name.span, &param.name.text));
        }
        if matches!(param.name.text.as_str(), "true" | "false") {
            diagnostics.push(diagnostics::reserved_word(param.name.span, &param.name.text));
        }
        let mut needed = Vec::new();
        mentioned(&param.value, &self.names[place], &mut needed);
        needed.reverse();
        (place, id, needed)
    }

    /// The value of a parameter, if it fits its type.
    fn checked(
        &self,
        param: &Param,
        written: &Expression,
        place: usize,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<ExpressionKind> {
        let names = &self.names[place];
        let context = Context { vocabulary: self.vocabulary, forms: self.forms, names, sources: self.sources };
        let word = param.ty.text.as_str();
        let mut check = |ty: Type| value(written, &ty, &context, diagnostics);
        if let Some((_, dimension)) = DIMENSIONS.iter().find(|(name, _)| *name == word) {
            return measured(written, *dimension, check);
        }
        match word {
            "integer" => match check(Type::Integer { min: -1_000_000_000_000, max: i64::MAX })? {
                Value::Integer(value) => Some(ExpressionKind::Known(Known::Quantity(value as f64, Dimension::RATIO))),
                _ => None,
            },
            "boolean" => check(Type::Boolean).map(|_| written.kind.clone()),
            "text" => check(Type::Text).map(|_| written.kind.clone()),
            "word" if self.is_choice(&param.name.text) => {
                diagnostics.push(diagnostics::reserved_word(param.name.span, &param.name.text));
                None
            }
            "word" if matches!(written.kind, ExpressionKind::Name(_)) => Some(written.kind.clone()),
            "word" => {
                diagnostics.push(diagnostics::not_a(written.span, "word", "value"));
                None
            }
            _ => match self.forms.iter().find(|form| form.name == word) {
                Some(form) => match check(Type::Reference(form.name))? {
                    Value::Reference(id) => Some(ExpressionKind::Known(Known::Declaration(form.name, id))),
                    _ => None,
                },
                None => {
                    let mut known: Vec<&str> = DIMENSIONS.iter().map(|(name, _)| *name).collect();
                    known.extend(OTHER_TYPES);
                    known.extend(self.forms.iter().map(|form| form.name));
                    diagnostics.push(diagnostics::unknown_type(param.ty.span, word, &known));
                    None
                }
            },
        }
    }

    /// Whether a key accepts this word.
    fn is_choice(&self, word: &str) -> bool {
        fn takes(signature: &Signature, word: &str) -> bool {
            signature.params.iter().any(|param| param.ty.words().contains(&word))
                || signature.children.iter().any(|child| takes(child, word))
        }
        self.forms.iter().flat_map(|form| form.kinds.iter().chain(&form.plain)).any(|signature| takes(signature, word))
    }

    fn entries(&mut self, entries: &mut [Entry], place: usize) {
        for entry in entries {
            match entry {
                Entry::Property(Property { value, .. }) | Entry::Bare(value) => self.expression(value, place),
                Entry::Clause(Clause { formula, .. }) => self.expression(formula, place),
                Entry::Child(child) => self.entries(&mut child.entries, place),
                Entry::Unread => {}
            }
        }
    }

    fn expression(&mut self, expression: &mut Expression, place: usize) {
        let span = expression.span;
        match &mut expression.kind {
            ExpressionKind::Name(word) => {
                if let Some(id) = self.names[place].param(word) {
                    self.used.insert(id);
                    self.uses.insert((span.source, span.start), (span, id));
                    let known = self.known.get(&id).cloned().flatten();
                    expression.kind = known.unwrap_or(ExpressionKind::Known(Known::Wrong));
                    relocate(&mut expression.kind, span);
                }
            }
            ExpressionKind::Call { arguments: members, .. }
            | ExpressionKind::Group(members)
            | ExpressionKind::List(members) => {
                members.iter_mut().for_each(|member| self.expression(member, place));
            }
            ExpressionKind::Negate(inner) | ExpressionKind::Not(inner) | ExpressionKind::Conversion(inner, _) => {
                self.expression(inner, place);
            }
            ExpressionKind::Binary { left, right, .. } | ExpressionKind::Range(left, right) => {
                self.expression(left, place);
                self.expression(right, place);
            }
            ExpressionKind::Number { .. }
            | ExpressionKind::Text(_)
            | ExpressionKind::Inline { .. }
            | ExpressionKind::Known(_) => {}
        }
    }
}

fn mentioned_in(entry: &Entry, names: &Names, found: &mut Vec<ParamId>) {
    match entry {
        Entry::Property(Property { value, .. }) | Entry::Bare(value) => mentioned(value, names, found),
        Entry::Clause(Clause { formula, .. }) => mentioned(formula, names, found),
        Entry::Child(child) => child.entries.iter().for_each(|entry| mentioned_in(entry, names, found)),
        Entry::Unread => {}
    }
}

fn mentioned(expression: &Expression, names: &Names, found: &mut Vec<ParamId>) {
    match &expression.kind {
        ExpressionKind::Name(word) => found.extend(names.param(word)),
        ExpressionKind::Call { arguments: members, .. }
        | ExpressionKind::Group(members)
        | ExpressionKind::List(members) => members.iter().for_each(|member| mentioned(member, names, found)),
        ExpressionKind::Negate(inner) | ExpressionKind::Not(inner) | ExpressionKind::Conversion(inner, _) => {
            mentioned(inner, names, found);
        }
        ExpressionKind::Binary { left, right, .. } | ExpressionKind::Range(left, right) => {
            mentioned(left, names, found);
            mentioned(right, names, found);
        }
        ExpressionKind::Number { .. }
        | ExpressionKind::Text(_)
        | ExpressionKind::Inline { .. }
        | ExpressionKind::Known(_) => {}
    }
}

/// Moves messages about a parameter's value to where it is used.
fn relocate(kind: &mut ExpressionKind, place: Span) {
    if let ExpressionKind::Range(low, high) = kind {
        low.span = place;
        high.span = place;
    }
}

/// The value of a parameter with a dimension, if it fits.
fn measured(
    written: &Expression,
    dimension: Dimension,
    mut check: impl FnMut(Type) -> Option<Value>,
) -> Option<ExpressionKind> {
    let number = |value| ExpressionKind::Known(Known::Quantity(value, dimension));
    let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
    match &written.kind {
        ExpressionKind::Range(low, high) => {
            let Value::Range(a, b) = check(Type::Range { dimension, min, max })? else {
                return None;
            };
            let end = |value, span| Box::new(Expression { kind: number(value), span });
            Some(ExpressionKind::Range(end(a, low.span), end(b, high.span)))
        }
        ExpressionKind::Call { function, .. } if distributions().any(|name| name == function.text) => {
            let Value::Distribution(drawn) = check(Type::Distribution { dimension, min, max })? else {
                return None;
            };
            Some(ExpressionKind::Known(Known::Distribution(drawn, dimension)))
        }
        ExpressionKind::Known(Known::Distribution(..)) => {
            check(Type::Distribution { dimension, min, max }).map(|_| written.kind.clone())
        }
        _ => match check(Type::any(dimension))? {
            Value::Number(value) => Some(number(value)),
            _ => None,
        },
    }
}
