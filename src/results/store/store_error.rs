use std::io;
use std::path::PathBuf;

/// Why tasks cannot be stored.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("cannot write to the folder `{path}`: {source}", path = path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error("cannot write `{path}`: {source}", path = path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("cannot read `{path}`: {source}; it may be whole, so it is left as it is", path = path.display())]
    Unread { path: PathBuf, source: io::Error },
    #[error(
        "`{path}` is a link, and nothing in a folder of tasks is read or written through one; remove it, or choose another folder with \
         --out or --cache",
        path = path.display()
    )]
    Link { path: PathBuf },
    #[error(
        "the cache `{cache}` is in the folder for reports, `{out}`, where every folder is a report; name one elsewhere, or none to have it \
         in `{out}/.falsify`",
        cache = cache.display(), out = out.display()
    )]
    Inside { cache: PathBuf, out: PathBuf },
    #[error("the cache `{path}` is a file; name a folder", path = path.display())]
    NoFolder { path: PathBuf },
    #[error("the cache `{path}` holds other things, such as `{entry}`; name a new or an empty folder", path = path.display())]
    Foreign { path: PathBuf, entry: String },
    #[error(
        "`{beside}` is on another file system than the reports, so they could not appear in one step; take it away and name the place of \
         the tasks with --cache",
        beside = beside.display()
    )]
    Apart { beside: PathBuf },
}

impl StoreError {
    /// Whether the user should name another folder.
    pub fn is_misuse(&self) -> bool {
        !matches!(self, Self::Folder { .. } | Self::File { .. } | Self::Unread { .. })
    }
}
