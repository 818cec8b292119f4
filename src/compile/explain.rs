use std::fmt::Write;

use super::{Catalog, interface_pages, reference};
use base::signature::Signature;
use base::suggest::nearest;
use base::units::{Dimension, UNIT_NAMES, parse_unit};
use lang::error_index::{Mistake, mistakes};
use lang::keywords::{WORDS, Word};
use lang::{DIMENSIONS, functions, library, temporal_operators};

/// Something that can be explained, under the words that lead to it.
struct Page {
    /// Such as `driver`, `idm`, `margin`.
    path: Vec<&'static str>,
    text: String,
    /// Whether its word means nothing else: a message, a topic or a form.
    is_whole: bool,
}

/// Pages about several things, with what they are about.
const TOPICS: [(&str, &str); 7] = [
    ("events", "what rewards answer to"),
    ("variables", "what formulas can name"),
    ("signals", "what requirements can name of a role, as in `child.gap` and `gap(child, van)`"),
    ("functions", "what formulas can call"),
    ("units", "what quantities are written in"),
    ("state", "what a pedestrian gets"),
    ("action", "what it chooses"),
];

impl Catalog {
    /// Explains a diagnostic code, a form, a kind (`driver idm`), a block or key of either (`driver idm margin`), a word of the
    /// language (`matrix`), an event, a variable, or all `events`, `variables`, `units`. Words before the last one may be left out.
    ///
    /// # Errors
    /// The name is unknown; the error offers the nearest known one.
    pub fn explain(&self, words: &[String]) -> Result<String, String> {
        // Settings name keys with points between the words.
        let point = |word: &str| if word.contains('/') { ' ' } else { '.' };
        let parts = words.iter().flat_map(|word| word.split([' ', '\t', point(word)]));
        let words: Vec<&str> = parts.filter(|word| !word.is_empty()).collect();
        let Some((last, before)) = words.split_last() else { return Ok(self.topics()) };
        let mut pages = self.pages();
        if let Some(whole) = pages.iter().find(|page| page.is_whole && page.path == words) {
            return Ok(whole.text.clone());
        }
        pages.retain(|page| {
            let mut path = page.path[..page.path.len() - 1].iter();
            before.iter().all(|word| path.any(|known| known == word))
        });
        let alone = before.is_empty().then_some(last);
        let mut found: Vec<String> = alone.and_then(|word| unit(word)).into_iter().collect();
        found.extend(pages.iter().filter(|page| page.path.last() == Some(last)).map(|page| page.text.clone()));
        found.extend(alone.into_iter().flat_map(|word| in_library(word)));
        if !found.is_empty() {
            return Ok(found.join("\n"));
        }
        let known = pages.iter().filter_map(|page| page.path.last().copied());
        let (words, before) = (words.join(" "), before.iter().map(|word| format!("{word} ")).collect::<String>());
        Err(match nearest(last, known) {
            Some(near) => format!("nothing is known of `{words}`; did you mean `{before}{near}`?"),
            None => format!("nothing is known of `{words}`; `falsify explain` lists what there is"),
        })
    }

    /// The text about what exactly these words lead to, or about a unit.
    pub fn page(&self, path: &[&str]) -> Option<String> {
        let exact = self.pages().into_iter().find(|page| page.path == path).map(|page| page.text);
        exact.or_else(|| path.first().and_then(|word| unit(word)))
    }

    /// Messages, topics, forms, words of the language, events, variables, functions, types, and all kinds, blocks, keys and words of choices.
    fn pages(&self) -> Vec<Page> {
        let mut pages = Vec::new();
        let mut add = |path: &[&'static str], text, is_whole| pages.push(Page { path: path.to_vec(), text, is_whole });
        mistakes().iter().for_each(|mistake| add(&[mistake.code], explain_mistake(mistake), true));
        TOPICS.iter().for_each(|(word, about)| add(&[word], self.topic(word, about), true));
        self.forms.iter().for_each(|form| add(&[form.name], reference::form(form), true));
        WORDS.iter().for_each(|word| add(&[word.name], explain_word(word), false));
        self.vocabulary.events.iter().for_each(|each| add(&["on", each.name], reference::event(each), false));
        self.vocabulary.variables.iter().for_each(|each| add(&[each.name], reference::variable(each), false));
        functions().chain(temporal_operators()).for_each(|each| add(&[each.0], reference::function(each), false));
        DIMENSIONS.iter().for_each(|(name, of)| add(&[name], dimension(name, *of), false));
        for form in &self.forms {
            for kind in &form.kinds {
                add(&[form.name, kind.name], reference::signature(&reference::head(form, Some(kind)), kind), false);
                inside(&[form.name, kind.name], &reference::head(form, Some(kind)), kind, &mut add);
            }
            if let Some(plain) = &form.plain {
                inside(&[form.name], &reference::head(form, None), plain, &mut add);
            }
        }
        pages
    }

    /// Everything that can be explained.
    fn topics(&self) -> String {
        let mut page = String::from("The language; `falsify explain FORM`, `falsify explain FORM KIND`:\n\n");
        for form in &self.forms {
            let kinds: Vec<&str> = form.kinds.iter().map(|kind| kind.name).collect();
            let _ = writeln!(page, "  {:10}  {}", form.name, kinds.join(", "));
        }
        let words: Vec<&str> = WORDS.iter().map(|word| word.name).collect();
        let _ = writeln!(page, "\nWords; `falsify explain WORD`:\n\n  {}\n", words.join(", "));
        page.extend(TOPICS.map(|(word, about)| format!("  {word:10}  {about}\n")));
        page.push_str("\nDiagnostics; `falsify explain CODE`:\n\n");
        for mistake in mistakes() {
            let _ = writeln!(page, "  {:22}  {}", mistake.code, reference::first_sentence(mistake.text));
        }
        page
    }

    fn topic(&self, word: &str, about: &str) -> String {
        let list: String = match word {
            "state" => return interface_pages::state(),
            "action" => return interface_pages::action(),
            "events" => self.vocabulary.events.iter().map(reference::event).collect(),
            "variables" => self.vocabulary.variables.iter().map(reference::variable).collect(),
            "signals" => self.vocabulary.signals.iter().map(reference::variable).collect(),
            "functions" => functions().chain(temporal_operators()).map(reference::function).collect(),
            _ => UNIT_NAMES.iter().map(|(name, unit)| format!("- `{name}`: {}\n", unit.dimension)).collect(),
        };
        format!("**{word}** {about}\n\n{list}")
    }
}

fn explain_word(word: &Word) -> String {
    format!("{}\n\n{}\n\n{}", word.name, word.text, indented(word.example))
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("    {line}\n")).collect()
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
    Some(format!("`{word}` (unit): {}{si}\n", unit.dimension))
}

/// The values that a type of parameters accepts.
fn dimension(name: &str, dimension: Dimension) -> String {
    let units = match dimension.usual_units() {
        [] => "without a unit".to_string(),
        units => format!("in `{}`", units.join("`, `")),
    };
    format!("`param name: {name} = …`: {dimension} {units}; a range or a distribution may stand for it as well.\n")
}

/// The file of the standard library of this name, and the declarations under it.
fn in_library(word: &str) -> Vec<String> {
    let word = word.strip_prefix("std/").map_or(word, |file| file.strip_suffix(".scn").unwrap_or(file));
    let about = |(comment, names): (String, Vec<&str>)| {
        format!("import \"std/{word}.scn\"\n\n{comment}\n\nIt declares `{}`.\n", names.join("`, `"))
    };
    let shown = |(file, text): (&str, &str)| format!("import \"std/{file}\"\n\n{}", indented(text.trim_end()));
    library::about(word).map(about).into_iter().chain(library::statements(word).map(shown)).collect()
}

/// Adds the pages of the keys of a signature, with the words that they accept, and of its blocks.
fn inside(
    path: &[&'static str],
    head: &str,
    signature: &Signature,
    add: &mut impl FnMut(&[&'static str], String, bool),
) {
    for param in &signature.params {
        let text = format!("`{head}`\n\n{}", reference::key(param));
        add(&[path, &[param.name]].concat(), text.clone(), false);
        param.ty.words().iter().for_each(|word| add(&[path, &[param.name, *word]].concat(), text.clone(), false));
    }
    for child in &signature.children {
        let path = [path, &[child.name]].concat();
        add(&path, format!("`{head}`, inside:\n\n{}", reference::block(child)), false);
        inside(&path, &format!("{head}, inside: {} {{ … }}", child.name), child, add);
    }
}

fn explain_mistake(mistake: &Mistake) -> String {
    let Mistake { code, text, bad, good } = mistake;
    format!("{code}\n\n{text}\n\nWrong:\n\n{}\nRight:\n\n{}", indented(bad), indented(good))
}
