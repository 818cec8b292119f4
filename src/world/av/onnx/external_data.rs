//! Constants of a network that stand in other files, as exporters write large ones, such as torch by default.

use std::collections::BTreeMap;

use super::encoding::{Content, Refusal, field, put, text};
use base::files::MAX_BYTES;

/// The way from the file to its constants: the graph of the model, its initial values.
const CONSTANTS: [u32; 2] = [7, 5];

/// Puts the constants that stand in other files into the file itself. `read` returns the content of the file with a name; each is read once. A name is
/// that of a file in the same folder, never a path.
///
/// # Errors
/// It is not ONNX, a name is a path, `read` refuses it, a part lies beyond the end of its file, or all is more than [`MAX_BYTES`].
///
/// # Source
/// `onnx.proto` and the page about external data of the ONNX project.
pub fn with_external_data(
    bytes: Vec<u8>,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>, Refusal>,
) -> Result<Vec<u8>, Refusal> {
    if !has_external_data(&bytes, &CONSTANTS)? {
        return Ok(bytes);
    }
    let mut data = Data { read, files: BTreeMap::new(), left: MAX_BYTES.saturating_sub(bytes.len() as u64) };
    let whole = filled(&bytes, &CONSTANTS, &mut data)?;
    if whole.len() as u64 > MAX_BYTES { Err(too_long()) } else { Ok(whole) }
}

fn too_long() -> Refusal {
    format!("with the files of its constants it has more than {} MiB", MAX_BYTES >> 20)
}

/// The files of constants.
struct Data<'a> {
    read: &'a mut dyn FnMut(&str) -> Result<Vec<u8>, Refusal>,
    files: BTreeMap<String, Vec<u8>>,
    /// How many bytes may still be read, and how many taken.
    left: u64,
}

/// A part of a file.
#[derive(Default)]
struct Part {
    name: String,
    offset: u64,
    length: Option<u64>,
}

impl Data<'_> {
    fn part(&mut self, part: &Part) -> Result<&[u8], Refusal> {
        let name = &part.name;
        if name.is_empty() || [".", ".."].contains(&name.as_str()) || name.contains(['/', '\\', ':', '\0']) {
            return Err(format!("its constants are in `{name}`; they must be in a file of the same folder"));
        }
        if !self.files.contains_key(name) {
            let content = (self.read)(name).map_err(|reason| format!("its constants are in `{name}`: {reason}"))?;
            let read: u64 = self.files.values().map(|content| content.len() as u64).sum();
            if read + content.len() as u64 > MAX_BYTES {
                return Err(too_long());
            }
            self.files.insert(name.clone(), content);
        }
        let content = &self.files[name];
        let rest = usize::try_from(part.offset).ok().and_then(|offset| content.get(offset..));
        let found = rest.and_then(|rest| match part.length {
            None => Some(rest),
            Some(length) => rest.get(..usize::try_from(length).ok()?),
        });
        let found = found.ok_or_else(|| format!("a constant of it lies beyond the end of `{name}`"))?;
        self.left = self.left.checked_sub(found.len() as u64).ok_or_else(too_long)?;
        Ok(found)
    }
}

/// Whether a constant at the end of the way stands in another file.
fn has_external_data(mut bytes: &[u8], way: &[u32]) -> Result<bool, Refusal> {
    while let Some((number, content, _)) = field(&mut bytes)? {
        match (way, content) {
            ([], Content::Number(1)) if number == 14 => return Ok(true),
            ([next, rest @ ..], Content::Bytes(inner)) if number == *next && has_external_data(inner, rest)? => {
                return Ok(true);
            }
            _ => {}
        }
    }
    Ok(false)
}

/// The message with the constants at the end of the way filled in.
fn filled(mut bytes: &[u8], way: &[u32], data: &mut Data<'_>) -> Result<Vec<u8>, Refusal> {
    let [next, rest @ ..] = way else { return constant(bytes, data) };
    let mut written = Vec::with_capacity(bytes.len());
    while let Some((number, content, raw)) = field(&mut bytes)? {
        match content {
            Content::Bytes(inner) if number == *next => put(&mut written, number, &filled(inner, rest, data)?),
            _ => written.extend_from_slice(raw),
        }
    }
    Ok(written)
}

/// A constant with its numbers.
fn constant(tensor: &[u8], data: &mut Data<'_>) -> Result<Vec<u8>, Refusal> {
    let (mut bytes, mut written, mut part) = (tensor, Vec::new(), Part::default());
    while let Some((number, content, raw)) = field(&mut bytes)? {
        match (number, content) {
            (13, Content::Bytes(entry)) => part.read(entry)?,
            // Where the numbers are.
            (14, _) => {}
            _ => written.extend_from_slice(raw),
        }
    }
    if !has_external_data(tensor, &[])? {
        return Ok(tensor.to_vec());
    }
    put(&mut written, 9, data.part(&part)?);
    Ok(written)
}

impl Part {
    /// Reads an entry: a key and a value.
    fn read(&mut self, mut entry: &[u8]) -> Result<(), Refusal> {
        let (mut key, mut value) = (String::new(), String::new());
        while let Some((number, content, _)) = field(&mut entry)? {
            match (number, content) {
                (1, Content::Bytes(bytes)) => key = text(bytes),
                (2, Content::Bytes(bytes)) => value = text(bytes),
                _ => {}
            }
        }
        let number = || value.parse().map_err(|_| format!("the `{key}` of a constant of it is `{value}`, no number"));
        match key.as_str() {
            "location" => self.name = value,
            "offset" => self.offset = number()?,
            "length" => self.length = Some(number()?),
            // A checksum: the content is part of the fingerprint of results.
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &[u8] = include_bytes!("../../../../tests/reference/onnx/follow.onnx");
    const APART: &[u8] = include_bytes!("../../../../tests/reference/onnx/follow_apart.onnx");
    const DATA: &[u8] = include_bytes!("../../../../tests/reference/onnx/follow_apart.onnx.data");

    /// The numbers of each constant, by its name.
    fn constants(mut bytes: &[u8]) -> BTreeMap<String, Vec<u8>> {
        let mut found = BTreeMap::new();
        let mut graph: &[u8] = &[];
        while let Some((number, content, _)) = field(&mut bytes).unwrap() {
            if let (7, Content::Bytes(inner)) = (number, content) {
                graph = inner;
            }
        }
        while let Some((number, content, _)) = field(&mut graph).unwrap() {
            let (5, Content::Bytes(mut tensor)) = (number, content) else { continue };
            let (mut name, mut raw) = (String::new(), Vec::new());
            while let Some((number, content, _)) = field(&mut tensor).unwrap() {
                match (number, content) {
                    (8, Content::Bytes(bytes)) => name = text(bytes),
                    (9, Content::Bytes(bytes)) => raw = bytes.to_vec(),
                    _ => {}
                }
            }
            found.insert(name, raw);
        }
        found
    }

    #[test]
    fn constants_in_another_file_are_those_of_one_file() {
        let mut asked = Vec::new();
        let mut read = |name: &str| {
            asked.push(name.to_owned());
            Ok(DATA.to_vec())
        };
        let whole = with_external_data(APART.to_vec(), &mut read).unwrap();
        assert_eq!(asked, ["follow_apart.onnx.data"], "each file is read once");
        assert_eq!(constants(&whole), constants(WHOLE));
        let mut never = |name: &str| Err(format!("{name} is asked for"));
        assert_eq!(with_external_data(WHOLE.to_vec(), &mut never).unwrap(), WHOLE);
        assert!(with_external_data(APART[..40].to_vec(), &mut never).is_err());
        let short = with_external_data(APART.to_vec(), &mut |_| Ok(DATA[..DATA.len() - 1].to_vec()));
        assert_eq!(short.unwrap_err(), "a constant of it lies beyond the end of `follow_apart.onnx.data`");
        let absent = with_external_data(APART.to_vec(), &mut |_| Err("there is no such file".into()));
        assert_eq!(absent.unwrap_err(), "its constants are in `follow_apart.onnx.data`: there is no such file");
    }

    /// A file with one constant, whose data is described by these keys and values.
    fn model(entries: &[(&str, &str)]) -> Vec<u8> {
        let mut tensor = vec![14 << 3, 1];
        for (key, value) in entries {
            let mut entry = Vec::new();
            put(&mut entry, 1, key.as_bytes());
            put(&mut entry, 2, value.as_bytes());
            put(&mut tensor, 13, &entry);
        }
        let (mut graph, mut model) = (Vec::new(), Vec::new());
        put(&mut graph, 5, &tensor);
        put(&mut model, 7, &graph);
        model
    }

    #[test]
    fn files_elsewhere_and_sizes_out_of_bounds_are_refused() {
        for name in ["../secret", "/etc/passwd", "..", ".", "", "a/b", "c:\\b", "b\0"] {
            let refused = with_external_data(model(&[("location", name)]), &mut |_| panic!("{name:?} is read"));
            assert!(refused.unwrap_err().ends_with("they must be in a file of the same folder"), "{name:?}");
        }
        let mut eight = |_: &str| Ok(vec![7; 8]);
        let mut said = |entries: &[(&str, &str)]| {
            with_external_data(model(&[&[("location", "data")], entries].concat()), &mut eight).err()
        };
        assert_eq!(said(&[("offset", "4"), ("length", "4")]), None);
        assert_eq!(said(&[("offset", "8")]), None, "no bytes");
        for beyond in [("offset", "9"), ("length", "9"), ("length", "18446744073709551615")] {
            assert_eq!(said(&[beyond]).unwrap(), "a constant of it lies beyond the end of `data`", "{beyond:?}");
        }
        assert_eq!(said(&[("offset", "-1")]).unwrap(), "the `offset` of a constant of it is `-1`, no number");
    }

    #[test]
    fn one_file_that_many_constants_name_takes_no_more_memory_than_allowed() {
        let one = model(&[("location", "data")]);
        let many = one.repeat(40);
        let refused = with_external_data(many, &mut |_| Ok(vec![0; 8 << 20])).unwrap_err();
        assert_eq!(refused, "with the files of its constants it has more than 256 MiB");
    }
}
