use std::collections::BTreeMap;
use std::path::PathBuf;

use base::keys;

keys! {
    /// What every program of the user takes.
    pub struct ProgramKeys {
        /// The program and its arguments, split at blanks and started without a shell in the folder of the file that
        /// names it.
        command: String,
        /// The files and folders that it consists of: finished work is used again as long as their contents stay the same. Without `files` and
        /// `version`, every run repeats the work of the program.
        files: Option<Vec<String>>,
        /// The version of a server, an image or an installed package: finished work is used again as long as the text stays the same.
        version: Option<String>,
        /// Time that it has for an answer.
        timeout: f64 as within(TIME, 0.001, 3600.0) = "1 s",
        /// Time that it has for its greeting.
        start_timeout: f64 as within(TIME, 0.001, 3600.0) = "30 s",
    }
}

/// A program with its arguments, and its working folder. No shell is involved.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// The program, then its arguments; never empty.
    pub words: Vec<String>,
    /// The folder in which it runs.
    pub folder: PathBuf,
    /// The files and folders that it consists of, relative to that folder.
    pub files: Vec<String>,
    /// Named numbers that its greeting tells it.
    pub parameters: BTreeMap<String, f64>,
}

impl Program {
    /// Reads a parameter, `NAME=NUMBER`.
    ///
    /// # Errors
    /// The reason why it is not one.
    pub fn parameter(text: &str) -> Result<(String, f64), &'static str> {
        let (name, number) = text.split_once('=').ok_or("write NAME=NUMBER")?;
        if name.is_empty() || !name.chars().all(|letter| letter.is_alphanumeric() || letter == '_') {
            return Err("a name consists of letters, digits and `_`");
        }
        let number: Option<f64> = number.parse().ok().filter(|number: &f64| number.is_finite());
        Ok((name.into(), number.ok_or("its value is not a number")?))
    }

    /// Splits a command at its blanks; text in single or double quotes stays together.
    ///
    /// # Errors
    /// The reason why it cannot be split.
    ///
    /// # Example
    /// ```
    /// use world::av::external::Program;
    /// let program = Program::parse("python 'my av.py' --fast", ".".into()).unwrap();
    /// assert_eq!(program.words, ["python", "my av.py", "--fast"]);
    /// ```
    pub fn parse(command: &str, folder: PathBuf) -> Result<Self, &'static str> {
        let mut words = Vec::new();
        let mut word: Option<String> = None;
        let mut quote = None;
        for character in command.chars() {
            match quote {
                Some(open) if open == character => quote = None,
                Some(_) => word.get_or_insert_default().push(character),
                None if character == '\'' || character == '"' => {
                    quote = Some(character);
                    word.get_or_insert_default();
                }
                None if character.is_whitespace() => words.extend(word.take()),
                None => word.get_or_insert_default().push(character),
            }
        }
        words.extend(word);
        if quote.is_some() {
            return Err("a quote is never closed");
        }
        if words.first().is_none_or(String::is_empty) {
            return Err("it names no program");
        }
        Ok(Self { words, folder, ..Self::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_words_together_and_nothing_else_is_special() {
        let words = |command| Program::parse(command, PathBuf::new()).map(|program| program.words);
        assert_eq!(words("  a  b\tc ").unwrap(), ["a", "b", "c"]);
        assert_eq!(words("a '' \"b 'c'\" d'e f'g").unwrap(), ["a", "", "b 'c'", "de fg"]);
        assert_eq!(words("a; rm -rf $HOME | b").unwrap(), ["a;", "rm", "-rf", "$HOME", "|", "b"]);
        assert_eq!(words("a 'b"), Err("a quote is never closed"));
        assert_eq!(words("   "), Err("it names no program"));
        assert_eq!(words("'' a"), Err("it names no program"));
    }

    #[test]
    fn a_parameter_is_a_name_and_a_number() {
        assert_eq!(Program::parameter("gap=-0.5"), Ok(("gap".into(), -0.5)));
        for wrong in ["gap", "=1", "g p=1", "gap=", "gap=NaN", "gap=1 m"] {
            assert!(Program::parameter(wrong).is_err(), "{wrong}");
        }
    }
}
