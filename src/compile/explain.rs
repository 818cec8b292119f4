use std::fmt::Write;

use super::{Catalog, interface_pages};
use base::signature::{Event, Param, Signature, Variable};
use base::units::{Dimension, UNIT_NAMES, parse_unit};
use lang::error_index::{Mistake, mistakes};
use lang::keywords::{WORDS, Word};
use lang::nearest;
use lang::{DIMENSIONS, functions, library, temporal_operators};

impl Catalog {
    /// Explains a diagnostic code, a form, a kind (`policy idm`), a block or key of either (`policy idm margin`), a word of the
    /// language (`matrix`), an event, a variable, or all `events`, `variables`, `units`.
    ///
    /// # Errors
    /// The name is unknown; the error offers the nearest known one.
    pub fn explain(&self, words: &[String]) -> Result<String, String> {
        // Settings name keys with points between the words.
        let point = |word: &str| if word.contains('/') { ' ' } else { '.' };
        let parts = words.iter().flat_map(|word| word.split([' ', '\t', point(word)]));
        let words: Vec<&str> = parts.filter(|word| !word.is_empty()).collect();
        let Some((first, rest)) = words.split_first() else { return Ok(self.topics()) };
        let mistakes = mistakes();
        if rest.is_empty() {
            if let Some(mistake) = mistakes.iter().find(|mistake| mistake.code == *first) {
                return Ok(explain_mistake(mistake));
            }
            match *first {
                "events" => return Ok(self.events()),
                "variables" => return Ok(self.variables()),
                "units" => return Ok(units()),
                "state" | "states" => return Ok(interface_pages::state()),
                "action" | "actions" => return Ok(interface_pages::action()),
                "functions" => return Ok(all_functions()),
                "forms" | "form" => return Ok(self.topics()),
                "types" | "type" => return self.word(&["param"]).ok_or_else(String::new),
                _ => {}
            }
        }
        if let Some(page) = self.word(&words) {
            return Ok(page);
        }
        if let [word] = words.as_slice() {
            let pages: Vec<String> = [unit(word), dimension(word), function(word)].into_iter().flatten().collect();
            if !pages.is_empty() {
                return Ok(pages.join("\n"));
            }
        }
        if let Some(form) = self.forms.iter().find(|form| form.name == *first) {
            if rest.is_empty() {
                return Ok(self.form(form.name));
            }
            let heads = form.kinds.iter().map(|kind| (format!("{} name = {}(…)", form.name, kind.name), kind));
            let plain = form.plain.iter().map(|plain| (format!("{} name {{ … }}", form.name), plain));
            // The name of a kind selects it; otherwise the words are searched in everything that the form has.
            for (head, signature) in heads.chain(plain) {
                let inner = if signature.name == rest[0] { &rest[1..] } else { rest };
                if let Some(text) = inside(&head, signature, inner)
                    && (signature.name == rest[0] || !inner.is_empty())
                {
                    return Ok(text);
                }
            }
            return Err(unknown(&format!("{first} {}", rest.join(" ")), &self.words_of(form.name), first));
        }
        let mut found = self.named(&words);
        if let [word] = words.as_slice() {
            found.extend(self.choosing(word));
            found.extend(in_library(word));
        }
        if !found.is_empty() {
            return Ok(found.join("\n"));
        }
        let mut known: Vec<&str> = mistakes.iter().map(|mistake| mistake.code).collect();
        known.extend(["events", "variables", "functions", "units", "state", "action"]);
        known.extend(functions().chain(temporal_operators()).map(|(name, _)| name));
        known.extend(WORDS.iter().map(|word| word.name));
        known.extend(self.vocabulary.events.iter().map(|event| event.name));
        known.extend(self.vocabulary.variables.iter().map(|variable| variable.name));
        let all: Vec<String> = self.forms.iter().flat_map(|form| self.words_of(form.name)).collect();
        known.extend(self.forms.iter().map(|form| form.name));
        known.extend(all.iter().map(String::as_str));
        let known: Vec<String> = known.into_iter().map(str::to_string).collect();
        Err(unknown(&words.join(" "), &known, ""))
    }

    /// Kinds and keys of that name, which may be given without their form.
    fn named(&self, words: &[&str]) -> Vec<String> {
        let Some((first, rest)) = words.split_first() else { return Vec::new() };
        let mut found = Vec::new();
        for form in &self.forms {
            for signature in form.kinds.iter().chain(&form.plain) {
                let head = match form.plain.as_ref().is_some_and(|plain| std::ptr::eq(plain, signature)) {
                    true => format!("{} name {{ … }}", form.name),
                    false => format!("{} name = {}(…)", form.name, signature.name),
                };
                let inner = if signature.name == *first { rest } else { words };
                found.extend(inside(&head, signature, inner).filter(|_| signature.name == *first || !inner.is_empty()));
                let blocks = signature.children.iter();
                found.extend(
                    blocks.filter_map(|block| inside(&format!("{head}, inside: {} {{ … }}", block.name), block, words)),
                );
            }
        }
        found
    }

    /// The keys that accept a word.
    fn choosing(&self, word: &str) -> Vec<String> {
        fn gather(head: &str, signature: &Signature, word: &str, found: &mut Vec<String>) {
            let params = signature.params.iter().filter(|param| param.ty.words().contains(&word));
            found.extend(params.map(|param| format!("{head}\n\n{}", key(param))));
            for child in &signature.children {
                gather(&format!("{head}, inside: {} {{ … }}", child.name), child, word, found);
            }
        }
        let mut found = Vec::new();
        for form in &self.forms {
            for kind in &form.kinds {
                gather(&format!("{} name = {}(…)", form.name, kind.name), kind, word, &mut found);
            }
            if let Some(plain) = &form.plain {
                gather(&format!("{} name {{ … }}", form.name), plain, word, &mut found);
            }
        }
        found
    }

    /// Everything that can be explained.
    fn topics(&self) -> String {
        let mut page = String::from("The language; `falsify explain FORM`, `falsify explain FORM KIND`:\n\n");
        for form in &self.forms {
            let kinds: Vec<&str> = form.kinds.iter().map(|kind| kind.name).collect();
            let _ = writeln!(page, "  {:10}  {}", form.name, kinds.join(", "));
        }
        let words: Vec<&str> = WORDS.iter().map(|word| word.name).collect();
        let _ = writeln!(page, "\nWords; `falsify explain WORD`:\n\n  {}", words.join(", "));
        page.push_str("\n  events      what rewards answer to\n  variables   what formulas can name\n");
        page.push_str("  functions   what formulas can call\n  units       what quantities are written in\n");
        page.push_str("  state       what the controller of a pedestrian gets\n  action      what it chooses\n\n");
        page.push_str("Diagnostics; `falsify explain CODE`:\n\n");
        for mistake in mistakes() {
            let _ = writeln!(page, "  {:22}  {}", mistake.code, first_sentence(mistake.text));
        }
        page
    }

    fn form(&self, name: &str) -> String {
        let mut page = String::new();
        for form in self.forms.iter().filter(|form| form.name == name) {
            let _ = writeln!(page, "{}: {}\n", form.name, form.doc);
            if let Some(plain) = &form.plain {
                page.push_str(&contents(&format!("{} name {{ … }}", form.name), plain));
            }
            for kind in &form.kinds {
                let _ = writeln!(page, "{} name = {}(…)\n    {}", form.name, kind.name, kind.doc);
            }
            if !form.kinds.is_empty() {
                let _ = writeln!(page, "\n`falsify explain {} KIND` lists the keys of a kind.", form.name);
            }
        }
        page
    }

    /// Names of kinds, blocks and keys of a form.
    fn words_of(&self, form: &str) -> Vec<String> {
        fn gather(signature: &Signature, words: &mut Vec<String>) {
            words.push(signature.name.to_string());
            words.extend(signature.params.iter().map(|param| param.name.to_string()));
            signature.children.iter().for_each(|child| gather(child, words));
        }
        let mut words = Vec::new();
        for form in self.forms.iter().filter(|each| each.name == form) {
            form.kinds.iter().chain(&form.plain).for_each(|signature| gather(signature, &mut words));
        }
        words
    }

    /// A word of the language, an event (`hit`, `on hit`) or a variable; several of these if they share the name.
    fn word(&self, words: &[&str]) -> Option<String> {
        let name = match words {
            ["on", name] | [name] => *name,
            _ => return None,
        };
        let mut pages: Vec<String> = Vec::new();
        pages.extend(WORDS.iter().filter(|word| word.name == name).map(explain_word));
        pages.extend(self.vocabulary.events.iter().filter(|each| each.name == name).map(event));
        let variables = self.vocabulary.variables.iter().filter(|each| each.name == name);
        pages.extend(variables.map(variable));
        // A form or key may have the name of an event or variable.
        if !pages.is_empty() && words.len() == 1 {
            pages.extend(self.named(words));
        }
        (!pages.is_empty()).then(|| pages.join("\n"))
    }

    fn events(&self) -> String {
        let all = self.vocabulary.events.iter().map(|each| format!("\n{}", event(each)));
        std::iter::once("Events: `on event => formula` inside a reward.\n".to_string()).chain(all).collect()
    }

    fn variables(&self) -> String {
        let mut page = String::from("Variables: what formulas can name.\n\n");
        self.vocabulary.variables.iter().for_each(|each| page.push_str(&variable(each)));
        page
    }
}

fn event(event: &Event) -> String {
    let head =
        if event.answered { format!("on {}", event.name) } else { format!("{} (for conditions alone)", event.name) };
    let mut page = format!("{head}\n    {}\n", event.doc);
    if !event.words.is_empty() {
        let _ = writeln!(page, "    words: {}", event.words.join(", "));
    }
    let _ = writeln!(page, "    variables: {}", event.variables.join(", "));
    page
}

fn variable(variable: &Variable) -> String {
    format!("{} ({})\n    {}\n", variable.name, variable.within(), variable.doc)
}

fn explain_word(word: &Word) -> String {
    format!("{}\n\n{}\n\n{}", word.name, word.text, indented(word.example))
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
}

fn units() -> String {
    let mut page = String::from("Units, which `/`, `*` and `^` combine, as in `km/h` and `m/s^2`.\n\n");
    for (name, unit) in UNIT_NAMES {
        let _ = writeln!(page, "{name:8}  {}", unit.dimension);
    }
    page
}

/// What a unit measures, and its size.
fn unit(word: &str) -> Option<String> {
    let unit = parse_unit(word).ok()?;
    let si = match unit.dimension.usual_units().first() {
        Some(first) if *first == word => String::new(),
        Some(first) => {
            let base = parse_unit(first).map_or(1.0, |base| base.factor);
            format!("; 1 {word} = {} {first}", (unit.factor / base * 1e9).round() / 1e9)
        }
        None if unit.dimension == Dimension::RATIO => format!("; 1 {word} = {}", unit.factor),
        None => String::new(),
    };
    Some(format!("{word} (unit)\n    {}{si}\n", unit.dimension))
}

/// The values that a type of parameters accepts.
fn dimension(word: &str) -> Option<String> {
    let (name, dimension) = DIMENSIONS.iter().find(|(name, _)| *name == word)?;
    let units = match dimension.usual_units() {
        [] => "without a unit".to_string(),
        units => format!("in {}", units.join(", ")),
    };
    Some(format!(
        "param name: {name} = …\n    {}, {units}; a range or a distribution may stand for it as well.\n",
        if *dimension == Dimension::ANGLE { "An angle".into() } else { format!("A {dimension}") }
    ))
}

/// The value of a function.
fn function(word: &str) -> Option<String> {
    functions()
        .chain(temporal_operators())
        .find(|(name, _)| *name == word)
        .map(|(name, doc)| format!("{name}(…)\n    {doc}\n"))
}

fn all_functions() -> String {
    std::iter::once("Functions of formulas.\n\n".to_string())
        .chain(functions().chain(temporal_operators()).filter_map(|(name, _)| function(name)))
        .collect()
}

/// The declarations of the standard library under a name.
fn in_library(word: &str) -> Vec<String> {
    let shown = |(file, text): (&str, &str)| format!("import \"std/{file}\"\n\n{}", indented(text.trim_end()));
    library::statements(word).map(shown).collect()
}

fn unknown(word: &str, known: &[String], form: &str) -> String {
    let last = word.rsplit(' ').next().unwrap_or(word);
    let form = if form.is_empty() { String::new() } else { format!("{form} ") };
    match nearest(last, known.iter().map(String::as_str)) {
        Some(near) => format!("nothing is known of `{word}`; did you mean `{form}{near}`?"),
        None => format!("nothing is known of `{word}`; `falsify explain` lists what there is"),
    }
}

/// A signature, or a block or key inside it.
fn inside(head: &str, signature: &Signature, words: &[&str]) -> Option<String> {
    let Some((first, rest)) = words.split_first() else { return Some(contents(head, signature)) };
    if let Some(param) = signature.params.iter().find(|param| param.name == *first).filter(|_| rest.is_empty()) {
        return Some(format!("{head}\n\n{}", key(param)));
    }
    let child = signature.children.iter().find(|child| child.name == *first)?;
    inside(&format!("{head}, inside: {} {{ … }}", child.name), child, rest)
}

fn contents(head: &str, signature: &Signature) -> String {
    let mut page = format!("{head}\n");
    if !signature.doc.is_empty() {
        let _ = writeln!(page, "    {}", signature.doc);
    }
    if !signature.surrogate.is_empty() {
        let _ = writeln!(page, "\n    A surrogate. {}", signature.surrogate);
    }
    page.push('\n');
    for param in &signature.params {
        page.push_str(&key(param));
    }
    if signature.clauses {
        page.push_str("on event => formula\n    see `falsify explain events`\n");
    }
    page.extend(signature.rising.iter().map(|[low, high]| format!("{low} is at most {high}.\n")));
    page.extend(signature.tick.map(|tick| format!("Made for ticks of {tick} s.\n")));
    for child in &signature.children {
        let keys: Vec<&str> = child.params.iter().map(|param| param.name).collect();
        let _ = writeln!(
            page,
            "{} {{ … }}, {}\n    {}\n    keys: {}",
            child.name,
            child.occurrence(),
            child.doc,
            keys.join(", ")
        );
    }
    page
}

fn key(param: &Param) -> String {
    let default = match param.default {
        None => "must be given".into(),
        Some("") => "may be left out".into(),
        Some(text) => format!("default {text}"),
    };
    format!("{}: {}; {default}\n    {}\n", param.name, param.ty.describe_bounded(), param.doc)
}

fn first_sentence(text: &str) -> &str {
    text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.')
}

fn explain_mistake(mistake: &Mistake) -> String {
    let Mistake { code, text, bad, good } = mistake;
    format!("{code}\n\n{text}\n\nWrong:\n\n{}\nRight:\n\n{}", indented(bad), indented(good))
}
