//! The one way in which files of users are read: regular files only, up to a limit.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

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
    if bytes.len() as u64 > MAX_BYTES { Err(too_long()) } else { Ok(bytes) }
}

/// The text of a file.
///
/// # Errors
/// Those of [`bytes`], and bytes that are not UTF-8.
pub fn text(path: &Path) -> io::Result<String> {
    String::from_utf8(bytes(path)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
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
    String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

fn too_long() -> io::Error {
    io::Error::other(format!("it has more than {} MiB", MAX_BYTES >> 20))
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
        // Sparse, so that it takes no room.
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert_eq!(bytes(&path).unwrap_err().to_string(), "it has more than 256 MiB");
        assert_eq!(text_of(&b"abc"[..]).unwrap(), "abc");
        assert_eq!(text_of(io::repeat(b'a')).unwrap_err().to_string(), "it has more than 256 MiB");
        #[cfg(unix)]
        assert!(bytes(Path::new("/dev/zero")).unwrap_err().to_string().contains("regular files"));
    }
}
