//! Every diagnostic of the language, one function per code, so that all wording is in one place.

/// Declares diagnostics, each with its code, its message, and what else it says.
macro_rules! diagnostics {
    ($($name:ident($($given:ident: $of:ty),*) = $severity:ident($code:literal, $($message:tt)+) $(.$more:ident($($with:tt)*))*;)*) => {
        $(
            pub fn $name(span: Span $(, $given: $of)*) -> Diagnostic {
                Diagnostic::$severity($code, span, format!($($message)+)) $(.$more($($with)*))*
            }
        )*
    };
}

mod text;
mod naming;
mod values;
mod worlds;
mod foreign;

pub use foreign::explain_foreign;
pub use naming::*;
pub use text::*;
pub use values::*;
pub use worlds::*;

use base::diagnostic::Diagnostic;
use base::suggest::nearest;

/// Maximum number of words of a list that are shown; a hostile file may have any number.
const MAX_SHOWN: usize = 40;

fn quoted<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let mut words = words.into_iter();
    let mut shown: Vec<String> = words.by_ref().take(MAX_SHOWN).map(|word| format!("`{}`", cut(word))).collect();
    shown.extend(words.next().map(|_| "…".to_string()));
    shown.join(", ")
}

/// A word of the user's, shortened for messages.
pub(crate) fn cut(word: &str) -> std::borrow::Cow<'_, str> {
    const MAX_LETTERS: usize = 60;
    match word.char_indices().nth(MAX_LETTERS) {
        Some((end, _)) => format!("{}…", &word[..end]).into(),
        None => word.into(),
    }
}

/// A name with its article; a name that starts with a quote or `one of` has none.
pub(crate) fn one(thing: impl std::fmt::Display) -> String {
    let thing = thing.to_string();
    match thing.chars().next() {
        Some('`') => thing,
        _ if ["a ", "an ", "the "].iter().any(|article| thing.starts_with(article)) => thing,
        _ if thing.starts_with("one of") || thing.starts_with("text") => thing,
        Some('a' | 'e' | 'i' | 'o') => format!("an {thing}"),
        _ => format!("a {thing}"),
    }
}

/// Names of other programs, mostly of stable-baselines3, and ours.
const ELSEWHERE: [(&str, &str); 10] = [
    ("total_timesteps", "steps"),
    ("n_steps", "steps_per_update"),
    ("n_epochs", "epochs"),
    ("n_envs", "environments"),
    ("clip_range", "clip"),
    ("ent_coef", "entropy_coefficient"),
    ("vf_coef", "value_coefficient"),
    ("max_grad_norm", "max_gradient_norm"),
    ("normalize_advantage", "normalize_advantages"),
    ("net_arch", "hidden"),
];

/// Our word for one of another program's.
pub(crate) fn ours(word: &str) -> Option<&'static str> {
    ELSEWHERE.iter().find(|(name, _)| *name == word).map(|(_, ours)| *ours)
}

/// The known word that other programs call so, or the only one that begins with a word and goes on with another.
fn elsewhere<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let find = |name: &str| known.iter().copied().find(|known| *known == name);
    let longer = || {
        let mut begun = known.iter().filter(|known| known.strip_prefix(word).is_some_and(|rest| rest.starts_with('_')));
        begun.next().copied().filter(|_| begun.next().is_none() && word.len() > 2)
    };
    ours(word).and_then(find).or_else(longer)
}

/// Advice on an unknown word.
trait Offering {
    /// Offers the nearest known word, or lists them all.
    fn offering(self, word: &str, known: &[&str]) -> Self;
}

impl Offering for Diagnostic {
    fn offering(self, word: &str, known: &[&str]) -> Self {
        // A comparison of every unknown word with every known one would take too long.
        const MAX_COMPARED: usize = 200;
        let known = &known[..known.len().min(MAX_COMPARED)];
        match elsewhere(word, known).or_else(|| nearest(word, known.iter().copied())) {
            Some(near) => self.here(format!("did you mean `{near}`?")).fix(near),
            None if known.is_empty() => self.here("none is declared or imported"),
            None => self.help(format!("known here: {}", quoted(known.iter().copied()))),
        }
    }
}
