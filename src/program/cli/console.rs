//! Output and error stream.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use anstyle::{AnsiColor, Style};
use serde::Serialize;
use terminal_size::{Width, terminal_size_of};

use base::diagnostic::{Colour, Diagnostic, Label, Sources, render};
use base::printable::{is_command, printable};

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// Maximum number of diagnostics that are shown at once.
const SHOWN: usize = 50;

/// The width of text that goes to no terminal, such as a file (columns).
const WIDTH: u16 = 80;

/// Whether a line of the output could not be written.
static LOST: AtomicBool = AtomicBool::new(false);

/// Whether the reader of the output has closed it.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// The width of the terminal that the output goes to (columns); 80 if it goes elsewhere.
pub fn width() -> u16 {
    let size = terminal_size_of(std::io::stdout());
    // Some terminals state a width of 0.
    size.map(|(Width(width), _)| width).filter(|width| *width > 0).unwrap_or(WIDTH)
}

/// Writes a line to the error stream, without commands to a terminal, also where it goes to a file that is looked at later. A failure of this cannot be reported, and does not end the command.
pub fn note(line: &str) {
    let _ = writeln!(anstream::stderr(), "{}", printable(line));
}

/// Reports an error, in the form of the diagnostics.
pub fn fail(message: &str) {
    note(&format!("{ERROR}error{ERROR:#}: {message}"));
}

/// Reports a notice.
pub fn warn(message: &str) {
    note(&format!("{WARNING}warning{WARNING:#}: {message}"));
}

/// Prints a line, without commands to a terminal as [`note`]. A closed reader, as after `| head`, is not an error; [`lost`] reports other losses.
pub fn say(line: &str) {
    let mut output = anstream::stdout();
    settle(writeln!(output, "{}", printable(line)).and_then(|()| output.flush()));
}

/// Notes a failure to write to the output.
fn settle(written: std::io::Result<()>) {
    match written {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => CLOSED.store(true, Ordering::Relaxed),
        Err(_) => LOST.store(true, Ordering::Relaxed),
        Ok(()) => {}
    }
}

/// An object as JSON. Commands to a terminal are escaped in its texts, which changes none of them.
fn json(object: &impl Serialize) -> String {
    let written = serde_json::to_string(object).expect("texts and numbers have a form in JSON");
    let escape = |letter: char| if is_command(letter) { format!("\\u{:04x}", letter as u32) } else { letter.into() };
    if written.chars().any(is_command) { written.chars().map(escape).collect() } else { written }
}

/// Prints an object for programs.
pub fn say_object(object: &impl Serialize) {
    say(&json(object));
}

/// Prints objects, one a line, in a single write, since there may be very many.
pub fn say_objects(objects: &[impl Serialize]) {
    let lines: Vec<String> = objects.iter().map(|object| json(object) + "\n").collect();
    let mut output = std::io::stdout();
    settle(output.write_all(lines.concat().as_bytes()).and_then(|()| output.flush()));
}

/// Whether the reader of the output has closed it, as after `| head`. Then further output is not needed.
pub fn closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Whether a line of the output could not be written, for example to a full disk.
pub fn lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Draws diagnostics on the error stream: the first 50. Names that one import would add are one.
pub fn show(diagnostics: &[Diagnostic], sources: &Sources) {
    let drawn = joined(diagnostics);
    for diagnostic in drawn.iter().take(SHOWN) {
        // The stream strips the colours if they are not wanted.
        note(&format!("{}\n", render(diagnostic, sources, Colour::Always)));
    }
    if drawn.len() > SHOWN {
        note(&format!("… and {} more\n", drawn.len() - SHOWN));
    }
}

/// Joins diagnostics with the same repair at the same place: the first has the places of the others, too.
fn joined(diagnostics: &[Diagnostic]) -> Vec<Diagnostic> {
    let mut joined: Vec<Diagnostic> = Vec::new();
    // There may be as many diagnostics as lines, so those before are not searched for each.
    let mut places = BTreeMap::new();
    for each in diagnostics {
        // Other repairs replace the text that is wrong.
        if let [fix] = each.fixes.as_slice()
            && fix.span != each.primary.span
        {
            let first = *places.entry((each.code, fix.span, fix.text.as_str())).or_insert(joined.len());
            if let Some(first) = joined.get_mut(first) {
                first.labels.push(Label { span: each.primary.span, text: "nor this".into() });
                continue;
            }
        }
        joined.push(each.clone());
    }
    joined
}

/// Breaks long lines between words, at 80 columns.
pub fn wrapped(text: &str) -> String {
    broken(text, WIDTH)
}

/// Breaks lines that are longer than a number of columns between words, but no command. Lines that continue one are indented as it is, and by two columns more.
pub fn broken(text: &str, columns: u16) -> String {
    let mut all = String::new();
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        if line[indent..].starts_with("falsify ") {
            all.push_str(&format!("{line}\n"));
            continue;
        }
        let mut column = 0;
        for word in line[indent..].split(' ') {
            let width = word.chars().count();
            if column == 0 {
                all.push_str(&line[..indent]);
                column = indent;
            } else if column + 1 + width > usize::from(columns) {
                all.push('\n');
                all.push_str(&" ".repeat(indent + 2));
                column = indent + 2;
            } else {
                all.push(' ');
                column += 1;
            }
            all.push_str(word);
            column += width;
        }
        all.push('\n');
    }
    all
}

/// A number of things: `1 file`, `2 files`.
pub fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words_and_others_stay_as_they_are() {
        let short = "key: a  b\n    its meaning\n\nend";
        assert_eq!(wrapped(short), format!("{short}\n"));
        let word = "1234567890";
        let long = format!("    {}", [word; 12].join(" "));
        let first = format!("    {}", [word; 7].join(" "));
        let second = format!("      {}", [word; 5].join(" "));
        assert_eq!(wrapped(&long), format!("{first}\n{second}\n"));
    }
}
