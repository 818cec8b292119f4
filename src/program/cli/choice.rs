use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Reads one of several words: each with its value and its help. For types of packages that know nothing of a command line.
pub fn choice<T: Clone + Send + Sync + 'static, const N: usize>(
    choices: [(&'static str, T, &'static str); N],
) -> impl TypedValueParser<Value = T> {
    let words = choices.each_ref().map(|(word, _, help)| PossibleValue::new(*word).help(*help));
    PossibleValuesParser::new(words).map(move |word| {
        let chosen = choices.iter().find(|(known, ..)| *known == word);
        chosen.map(|(_, value, _)| value.clone()).expect("it is one of the words")
    })
}
