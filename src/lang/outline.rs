use std::fmt::Debug;

/// The fields that an outline omits: places in files.
const PLACES: [&str; 7] = ["span", "head", "source", "places", "roots", "setting", "torn"];

/// Any tree as indented lines, without places in files: two files with the same meaning
/// have the same outline.
///
/// It is made from the debug form, so new kinds of nodes need no change here.
pub fn outline(tree: &impl Debug) -> String {
    let text = format!("{tree:#?}");
    let mut result = String::new();
    let mut skipped_at: Option<usize> = None;
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        let content = line.trim();
        let closes = matches!(content.chars().next(), Some('}' | ')' | ']'));
        if let Some(at) = skipped_at {
            if indent == at && closes {
                skipped_at = None;
            }
            continue;
        }
        let field = content.split_once(": ").map_or("", |(field, _)| field);
        if PLACES.contains(&field) || content == "Span {" {
            if content.ends_with(['{', '(', '[']) {
                skipped_at = Some(indent);
            }
            continue;
        }
        let content = content.trim_end_matches(',').trim_end_matches(['{', '(', '[']).trim_end();
        if closes || content.is_empty() {
            continue;
        }
        result.extend(std::iter::repeat_n(' ', indent / 2));
        result.push_str(content);
        result.push('\n');
    }
    result
}
