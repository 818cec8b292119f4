use std::fmt::Write;

use super::{Catalog, interface_pages};
use base::signature::{Event, Param, Signature, Variable};
use base::units::{Dimension, UNIT_NAMES, parse_unit};
use lang::error_index::{Mistake, mistakes};
use lang::keywords::{WORDS, Word};
use lang::nearest;
use lang::{DIMENSIONS, functions, library, temporal_operators};

/// Something that can be explained, under the words that lead to it.
struct Page {
    /// Such as `policy`, `idm`, `margin`.
    path: Vec<&'static str>,
    text: String,
}

/// A word, and the text that explains it.
type Topic = (&'static str, fn(&Catalog) -> String);

/// Pages about several things.
const TOPICS: [Topic; 6] = [
    ("events", Catalog::events),
    ("variables", Catalog::variables),
    ("functions", |_| all_functions()),
    ("units", |_| units()),
    ("state", |_| interface_pages::state()),
    ("action", |_| interface_pages::action()),
];

impl Catalog {
    /// Explains a diagnostic code, a form, a kind (`policy idm`), a block or key of either (`policy idm margin`), a word of the
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
        let pages = self.pages();
        let leads = |page: &&Page| {
            let mut path = page.path[..page.path.len() - 1].iter();
            before.iter().all(|word| path.any(|known| known == word))
        };
        let mut found: Vec<String> = Vec::new();
        if before.is_empty() {
            if let Some(page) = self.whole_page(last) {
                return Ok(page);
            }
            found.extend(unit(last));
        }
        found.extend(
            pages.iter().filter(leads).filter(|page| page.path.last() == Some(last)).map(|page| page.text.clone()),
        );
        if before.is_empty() {
            found.extend(in_library(last));
        }
        if !found.is_empty() {
            return Ok(found.join("\n"));
        }
        let codes = mistakes().into_iter().map(|mistake| mistake.code);
        let single = codes.chain(TOPICS.map(|(name, _)| name)).filter(|_| before.is_empty());
        let known = single.chain(pages.iter().filter(leads).filter_map(|page| page.path.last().copied()));
        let (words, before) = (words.join(" "), before.iter().map(|word| format!("{word} ")).collect::<String>());
        Err(match nearest(last, known) {
            Some(near) => format!("nothing is known of `{words}`; did you mean `{before}{near}`?"),
            None => format!("nothing is known of `{words}`; `falsify explain` lists what there is"),
        })
    }

    /// The page of a message, a topic or a form.
    fn whole_page(&self, word: &str) -> Option<String> {
        if let Some(mistake) = mistakes().iter().find(|mistake| mistake.code == word) {
            return Some(explain_mistake(mistake));
        }
        if let Some((_, page)) = TOPICS.iter().find(|(name, _)| *name == word) {
            return Some(page(self));
        }
        self.forms.iter().any(|form| form.name == word).then(|| self.form(word))
    }

    /// Words of the language, events, variables, functions, types, and all kinds, blocks, keys and words of choices.
    fn pages(&self) -> Vec<Page> {
        let mut pages = Vec::new();
        let mut add = |path: &[&'static str], text| pages.push(Page { path: path.to_vec(), text });
        WORDS.iter().for_each(|word| add(&[word.name], explain_word(word)));
        self.vocabulary.events.iter().for_each(|each| add(&["on", each.name], event(each)));
        self.vocabulary.variables.iter().for_each(|each| add(&[each.name], variable(each)));
        functions().chain(temporal_operators()).for_each(|(name, doc)| add(&[name], function(name, doc)));
        DIMENSIONS.iter().for_each(|(name, of)| add(&[name], dimension(name, *of)));
        for form in &self.forms {
            for kind in &form.kinds {
                let head = format!("{} name = {}(…)", form.name, kind.name);
                signature_pages(&[form.name, kind.name], &head, kind, &mut pages);
            }
            if let Some(plain) = &form.plain {
                signature_pages(&[form.name], &format!("{} name {{ … }}", form.name), plain, &mut pages);
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
fn dimension(name: &str, dimension: Dimension) -> String {
    let units = match dimension.usual_units() {
        [] => "without a unit".to_string(),
        units => format!("in {}", units.join(", ")),
    };
    format!(
        "param name: {name} = …\n    {}, {units}; a range or a distribution may stand for it as well.\n",
        if dimension == Dimension::ANGLE { "An angle".into() } else { format!("A {dimension}") }
    )
}

fn function(name: &str, doc: &str) -> String {
    format!("{name}(…)\n    {doc}\n")
}

fn all_functions() -> String {
    let all = functions().chain(temporal_operators()).map(|(name, doc)| function(name, doc));
    std::iter::once("Functions of formulas.\n\n".to_string()).chain(all).collect()
}

/// The declarations of the standard library under a name.
fn in_library(word: &str) -> Vec<String> {
    let shown = |(file, text): (&str, &str)| format!("import \"std/{file}\"\n\n{}", indented(text.trim_end()));
    library::statements(word).map(shown).collect()
}

/// The pages of a signature, its keys with the words that they accept, and its blocks.
fn signature_pages(path: &[&'static str], head: &str, signature: &Signature, pages: &mut Vec<Page>) {
    pages.push(Page { path: path.to_vec(), text: contents(head, signature) });
    for param in &signature.params {
        let text = format!("{head}\n\n{}", key(param));
        let words = param.ty.words().iter().map(|word| [path, &[param.name, *word][..]].concat());
        let paths = std::iter::once([path, &[param.name][..]].concat()).chain(words);
        pages.extend(paths.map(|path| Page { path, text: text.clone() }));
    }
    for child in &signature.children {
        let head = format!("{head}, inside: {} {{ … }}", child.name);
        signature_pages(&[path, &[child.name][..]].concat(), &head, child, pages);
    }
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
