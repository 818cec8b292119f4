//! The one way in which files of users are read: regular files only, up to a limit.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The maximum size of a file that is read as a whole (bytes).
pub const MAX_BYTES: u64 = 256 << 20;

/// Opens a file. A pipe or a device is refused, since it may have no end.
///
/// # Errors
/// There is no such file, it cannot be read, or it is not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    let known = fs::metadata(path).map_err(in_words)?;
    if known.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !known.is_file() {
        let reason = "it is a pipe, a socket or a device; only regular files are read, so save its contents as a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    File::open(path).map_err(in_words)
}

/// The same error, with words in place of the number of the system where it is a common one.
fn in_words(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::NotFound => io::Error::new(error.kind(), "there is no such file"),
        io::ErrorKind::PermissionDenied => io::Error::new(error.kind(), "you may not read it"),
        _ => error,
    }
}

/// The first symbolic link in a folder, at any depth; the folder itself may be one. `None` if there is no such folder.
///
/// # Errors
/// A folder in it cannot be read.
pub fn first_link(folder: &Path) -> io::Result<Option<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        // Another process may have removed it meanwhile.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        entries => entries?,
    };
    let mut first: Option<PathBuf> = None;
    for entry in entries {
        let entry = entry?;
        let kind = entry.file_type()?;
        let link = match () {
            () if kind.is_symlink() => Some(entry.path()),
            () if kind.is_dir() => first_link(&entry.path())?,
            () => None,
        };
        first = [first, link].into_iter().flatten().min();
    }
    Ok(first)
}

/// The same path for all paths of one file; a path without a file stays as it is.
pub fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The bytes of a file.
///
/// # Errors
/// Those of [`open`], and a size above [`MAX_BYTES`].
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let size = file.metadata()?.len();
    if size > MAX_BYTES {
        return Err(too_long());
    }
    // Room for the whole file, and for one byte more to see that it has ended.
    let mut bytes = Vec::with_capacity(size as usize + 1);
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_long());
    }
    if bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
        return invalid("it is a pointer of Git LFS, not the file itself: run `git lfs pull`".into());
    }
    Ok(bytes)
}

/// How files begin that are no text, and what to do about them.
const NO_TEXT: [(&[u8], &str); 7] = [
    (b"\x1f\x8b", "it is compressed with gzip: unpack it, as `gunzip --keep FILE` does"),
    (b"\x28\xb5\x2f\xfd", "it is compressed with Zstandard: unpack it, as `unzstd FILE` does"),
    (b"\xfd7zXZ\0", "it is compressed with xz: unpack it, as `unxz --keep FILE` does"),
    (b"BZh", "it is compressed with bzip2: unpack it, as `bunzip2 --keep FILE` does"),
    (b"PK\x03\x04", "it is a ZIP archive or an office document: unpack it, or save it as text"),
    (
        b"PAR1",
        "it is a Parquet table: save it as CSV, as pandas does with `read_parquet(FILE).to_csv(NAME, index=False)`",
    ),
    (b"\x89HDF", "it is an HDF5 file: save what it holds as text"),
];

fn invalid<T>(what: String) -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::InvalidData, what))
}

/// The text of a file.
///
/// # Errors
/// Those of [`bytes`], and bytes that are not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    decoded(bytes(path)?)
}

/// The text of a stream without a known end, such as the standard input.
///
/// # Errors
/// It cannot be read, it has more than [`MAX_BYTES`], or it is not UTF-8.
pub fn text_of(stream: impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    stream.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_long());
    }
    decoded(bytes)
}

/// The text of bytes in UTF-8. The error names another encoding that the bytes show or their XML declares.
fn decoded(bytes: Vec<u8>) -> io::Result<String> {
    let other = |what: &str| invalid(format!("{what}: save it as UTF-8"));
    if let Some((_, what)) = NO_TEXT.iter().find(|(start, _)| bytes.starts_with(start)) {
        return invalid((*what).into());
    }
    if matches!(bytes.as_slice(), [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, 1..=255, ..] | [1..=255, 0, ..]) {
        return other("it is UTF-16 text");
    }
    String::from_utf8(bytes).or_else(|error| {
        let head = String::from_utf8_lossy(&error.as_bytes()[..error.as_bytes().len().min(200)]).into_owned();
        let declared = head.split_once("?>").and_then(|(declaration, _)| declaration.split_once("encoding="));
        let name = declared.and_then(|(_, name)| name.split(['"', '\'']).nth(1)).unwrap_or_default();
        match name.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter)) {
            true if !name.is_empty() && !name.eq_ignore_ascii_case("utf-8") => other(&format!("it is {name} text")),
            _ => other("it is not UTF-8 text"),
        }
    })
}

fn too_long() -> io::Error {
    io::Error::other(format!("it has more than {} MiB", MAX_BYTES >> 20))
}

/// A name as a part of an address: bytes other than letters, digits and these plain ones are percent-encoded.
pub fn address(name: &str, plain: &[u8]) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || plain.contains(&byte);
    let encoded = |byte: u8| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    name.bytes().map(encoded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_are_read_and_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "abc").unwrap();
        assert_eq!(text(&path).unwrap(), "abc");
        assert_eq!(bytes(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(bytes(&folder.path().join("b")).unwrap_err().kind(), io::ErrorKind::NotFound);
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(text(&path).unwrap_err().kind(), io::ErrorKind::InvalidData);
        let said = |bytes: &[u8]| text_of(bytes).unwrap_err().to_string();
        assert_eq!(said(b"caf\xe9"), "it is not UTF-8 text: save it as UTF-8");
        let utf_16: Vec<u8> = "<?xml version".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(said(&utf_16), "it is UTF-16 text: save it as UTF-8");
        assert_eq!(said(&[&[0xff, 0xfe][..], &utf_16].concat()), "it is UTF-16 text: save it as UTF-8");
        let latin = b"<?xml version=\"1.0\" encoding='ISO-8859-1'?><road name=\"Stra\xdfe\"/>";
        assert_eq!(said(latin), "it is ISO-8859-1 text: save it as UTF-8");
        assert!(said(b"\x1f\x8b\x08\0").starts_with("it is compressed with gzip: unpack it"));
        assert!(said(b"PAR1\x15\x04").starts_with("it is a Parquet table: save it as CSV"));
        fs::write(&path, "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n").unwrap();
        assert!(text(&path).unwrap_err().to_string().ends_with("run `git lfs pull`"));
        // Sparse, so that it takes no room.
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert_eq!(bytes(&path).unwrap_err().to_string(), "it has more than 256 MiB");
        assert_eq!(text_of(&b"abc"[..]).unwrap(), "abc");
        assert_eq!(text_of(io::repeat(b'a')).unwrap_err().to_string(), "it has more than 256 MiB");
        #[cfg(unix)]
        assert!(bytes(Path::new("/dev/zero")).unwrap_err().to_string().contains("regular files"));
    }
}
