use std::path::PathBuf;

use base::keys;

keys! {
    /// What every program of the user takes.
    pub struct ProgramKeys {
        /// The program and its arguments, split at blanks and started without a shell in the folder of the file that
        /// names it.
        command: String,
        /// Further files and folders that it depends on, beside those of its script's folder: when their contents change, its results are
        /// made again.
        files: Option<Vec<String>>,
        /// What it is where its files do not say so, such as the version of a server, of an image or of an installed package. Without it the
        /// results of such a program are made again in every run.
        version: Option<String>,
        /// Time that it has for an answer.
        timeout: f64 as within(TIME, 0.001, 3600.0) = "1 s",
        /// Time that it has for its greeting.
        start_timeout: f64 as within(TIME, 0.001, 3600.0) = "30 s",
    }
}

/// A program with its arguments, and its working folder. No shell is involved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// The program, then its arguments; never empty.
    pub words: Vec<String>,
    /// The folder in which it runs.
    pub folder: PathBuf,
    /// Further files and folders that it depends on, relative to that folder.
    pub files: Vec<String>,
}

impl Program {
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
        Ok(Self { words, folder, files: Vec::new() })
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
}
