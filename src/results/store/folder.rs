use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::place::Place;
use super::task_file::{self, Found, Header};
use super::work_folder::{LOCK, WorkFolder};
use super::{Id, Ids, StoreError};
use crate::campaign::{State, tasks};
use base::files;
use compile::Campaign;

/// Number of bytes that are read to see how a file starts.
const START: usize = 4096;
/// Receives notes about files.
pub type Note = Box<dyn Fn(&str) + Send + Sync>;

/// The tasks of a folder for reports.
pub struct Store {
    place: Place,
    /// For tasks that are being written; none in a store that is only read.
    work: Option<WorkFolder>,
    /// For reports that are being written, when the tasks are in another folder.
    drafts: Option<WorkFolder>,
    note: Note,
    /// The tasks that were reported as damaged.
    said: Mutex<BTreeSet<Id>>,
}

/// A claim on a task: no other process takes it until this is dropped.
struct Claim {
    path: PathBuf,
    _file: File,
}

impl Drop for Claim {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

impl Store {
    /// Opens the store of a folder for reports, and makes both if needed. If a cache is named, the tasks are in the cache, which several
    /// such folders may share. Otherwise they are beside the reports.
    ///
    /// # Errors
    /// One of the folders cannot be made or written to, or has other contents.
    pub fn open(out: &Path, cache: Option<&Path>, note: Note) -> Result<Self, StoreError> {
        let place = Place::of(out, cache)?;
        place.make()?;
        let begin =
            |root: &Path| WorkFolder::begin(root).map_err(|source| StoreError::Folder { path: root.into(), source });
        let work = begin(place.root())?;
        let drafts = if place.is_beside() { None } else { Some(begin(place.beside())?) };
        place.check_drafts(drafts.as_ref().unwrap_or(&work))?;
        Ok(Self { place, work: Some(work), drafts, note, said: Mutex::default() })
    }

    /// Opens the store of a folder for reports without changing anything.
    ///
    /// # Errors
    /// The named cache is not a cache, or a link is in the store.
    pub fn look(out: &Path, cache: Option<&Path>, note: Note) -> Result<Self, StoreError> {
        let place = Place::of(out, cache)?;
        place.check()?;
        Ok(Self { place, work: None, drafts: None, note, said: Mutex::default() })
    }

    /// Opens the store in a folder for reports, or in a cache, without changing anything.
    ///
    /// # Errors
    /// A link is in it.
    pub fn within(folder: &Path, note: Note) -> Result<Self, StoreError> {
        let place = Place::within(folder);
        place.check_links()?;
        Ok(Self { place, work: None, drafts: None, note, said: Mutex::default() })
    }

    /// The path of a task, if it is there.
    pub fn path(&self, id: Id) -> PathBuf {
        self.path_of(&id.to_string())
    }

    /// The path of the task with this name.
    pub(super) fn path_of(&self, id: &str) -> PathBuf {
        // Some file systems are slow with a hundred thousand files in one folder.
        self.root().join("tasks").join(id.get(..2).unwrap_or_default()).join(id)
    }

    /// The paths of this store.
    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// The folder for the growing learning curves of a campaign: `OUT/.falsify/learning/NAME`, whichever folder holds the tasks.
    pub fn learning(&self, campaign: &str) -> PathBuf {
        self.place.learning(campaign)
    }

    /// Whether there is a folder for tasks.
    pub fn is_there(&self) -> bool {
        self.root().join("tasks").is_dir()
    }

    fn root(&self) -> &Path {
        self.place.root()
    }

    /// Reads a task; reports it when it is damaged.
    ///
    /// # Errors
    /// Its file is there and cannot be read, for example without permission or when too many files are open.
    pub fn read(&self, id: Id) -> Result<Found, StoreError> {
        let found = self.read_named(&id.to_string())?;
        if let Found::Damaged(reason) = &found {
            self.unused(id, reason);
        }
        Ok(found)
    }

    /// Reads the task with this name.
    ///
    /// # Errors
    /// As [`Store::read`].
    pub(super) fn read_named(&self, name: &str) -> Result<Found, StoreError> {
        let path = self.path_of(name);
        let bytes = match files::bytes(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Found::Nothing),
            Err(source) => return Err(StoreError::Unread { path, source }),
        };
        Ok(match task_file::decode_of(name, bytes) {
            Ok((header, bytes)) => Found::Whole(header, bytes),
            Err(reason) => Found::Damaged(reason),
        })
    }

    /// Reports once that a task is damaged.
    pub fn damaged(&self, id: Id) {
        self.unused(id, "is damaged");
    }

    fn unused(&self, id: Id, reason: &str) {
        if self.said.lock().unwrap_or_else(PoisonError::into_inner).insert(id) {
            (self.note)(&format!("`{}` {reason}; its task is done again", self.path(id).display()));
        }
    }

    /// Reads the header of a task without its bytes; the error is `damaged`, `unreadable` or `of another task`.
    pub fn head(&self, id: Id) -> Option<Result<Header, &'static str>> {
        self.head_of(&self.path(id))
    }

    /// Reads the header of the task in a file.
    pub(super) fn head_of(&self, path: &Path) -> Option<Result<Header, &'static str>> {
        let read = || -> io::Result<(Vec<u8>, u64)> {
            let mut start = Vec::new();
            let file = files::open(path)?;
            let length = file.metadata()?.len();
            file.take(START as u64).read_to_end(&mut start)?;
            Ok((start, length))
        };
        let (start, length) = match read() {
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            Err(_) => return Some(Err("unreadable")),
        };
        let head = task_file::head(&start);
        let whole = head.filter(|(header, start)| task_file::whole_length(header, *start) == length);
        let Some((header, _)) = whole else { return Some(Err("damaged")) };
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        Some(if header.check(name).is_ok() { Ok(header) } else { Err("of another task") })
    }

    /// Writes a task. Its file appears whole or not at all. A finished task survives a power cut.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, id: Id, header: &Header, bytes: &[u8]) -> Result<(), StoreError> {
        let header = Header { task: id.to_string(), length: bytes.len() as u64, ..header.clone() };
        let sync = header.state == State::Finished;
        self.put(&self.path(id), &task_file::encode(&header, bytes), sync)
    }

    fn put(&self, path: &Path, bytes: &[u8], sync: bool) -> Result<(), StoreError> {
        let failed = |source| StoreError::File { path: path.to_path_buf(), source };
        let work = self.work.as_ref().expect("a store that is written to was opened");
        let put = || -> io::Result<()> {
            let parent = path.parent().expect("a file of the store is in a folder");
            fs::create_dir_all(parent)?;
            let mut draft = readable(&mut tempfile::Builder::new()).tempfile_in(work.path()?)?;
            draft.write_all(bytes)?;
            if sync {
                draft.as_file().sync_all()?;
            }
            draft.persist(path).map(|_| ()).map_err(|error| error.error)
        };
        put().map_err(failed)
    }

    /// Claims a task; none while another process has it.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn claim(&self, id: Id) -> Result<Option<Box<dyn Send>>, StoreError> {
        let folder = self.root().join("claims");
        let path = folder.join(id.to_string());
        let failed = |source| StoreError::File { path: path.clone(), source };
        let file = File::create(&path).or_else(|_| fs::create_dir_all(&folder).and_then(|()| File::create(&path)));
        let file = file.map_err(failed)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Ok(None),
            // Where files cannot be locked, two processes may do the same work. Their results are the same.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(Box::new(Claim { path, _file: file }))),
        }
    }

    /// A folder for files that are being written, on the same file system as the reports.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn drafts(&self) -> Result<PathBuf, StoreError> {
        let work = self.drafts.as_ref().or(self.work.as_ref()).expect("a store that is written to was opened");
        work.path().map_err(|source| StoreError::Folder { path: self.place.beside().to_path_buf(), source })
    }

    /// Reads a text that belongs to a campaign; `None` if it is missing or damaged.
    ///
    /// # Errors
    /// Its file is there and cannot be read.
    pub(super) fn campaign_text(&self, name: &str) -> Result<Option<String>, StoreError> {
        let path = self.campaign_path(name);
        match files::text(&path) {
            Ok(text) => Ok(Some(text)),
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::InvalidData) => Ok(None),
            Err(source) => Err(StoreError::Unread { path, source }),
        }
    }

    /// Writes a text that belongs to a campaign.
    pub(super) fn put_campaign_text(&self, name: &str, text: &str) -> Result<(), StoreError> {
        let _still = self.hold_still();
        self.put(&self.campaign_path(name), text.as_bytes(), false)
    }

    /// The names of all campaigns that were run in the folder for reports.
    pub fn campaigns(&self) -> Vec<String> {
        let entries = fs::read_dir(self.place.campaigns()).into_iter().flatten().flatten();
        let name = |entry: fs::DirEntry| Some(entry.file_name().to_str()?.strip_suffix(".json")?.to_string());
        let mut names: Vec<String> = entries.filter_map(name).collect();
        names.sort();
        names
    }

    /// The names of all tasks that are there, with their sizes in bytes. A link is neither a folder of tasks nor a task: what it leads to is not ours.
    pub fn sizes(&self) -> BTreeMap<String, u64> {
        let tasks = self.root().join("tasks");
        let folders = entries(&tasks).filter(|path| path.is_dir() && !path.is_symlink());
        let files = folders.flat_map(|folder| entries(&folder).collect::<Vec<_>>());
        let size = |path: PathBuf| {
            let known = fs::symlink_metadata(&path).ok().filter(fs::Metadata::is_file)?;
            Some((path.file_name()?.to_str()?.to_owned(), known.len()))
        };
        files.filter_map(size).filter(|(name, _)| is_id(name) && self.path_of(name).is_file()).collect()
    }

    /// Removes the tasks of a campaign, so that they are done again.
    ///
    /// # Errors
    /// One cannot be removed.
    pub fn forget(&self, ids: &Ids, campaign: &Campaign) -> Result<(), StoreError> {
        for path in tasks(campaign).map(|task| self.path(ids.get(task))) {
            match fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(StoreError::File { path, source: error });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Waits until no other process moves a report of this folder to its place. No other process may do so while this is held.
    pub fn door(&self) -> Option<File> {
        locked(self.place.beside())
    }

    /// Waits until no other process records what campaigns want. No other process may do so while this is held.
    pub fn hold_still(&self) -> Option<File> {
        locked(self.root())
    }

    /// Removes a task by its name.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove(&self, name: &str) -> Result<(), StoreError> {
        let path = self.root().join("tasks").join(&name[..2]).join(name);
        fs::remove_file(&path).map_err(|source| StoreError::File { path, source })
    }

    fn campaign_path(&self, name: &str) -> PathBuf {
        self.place.campaigns().join(format!("{name}.json"))
    }
}

fn locked(folder: &Path) -> Option<File> {
    let door = File::create(folder.join(LOCK)).ok()?;
    let _ = door.lock();
    Some(door)
}

/// Temporary files are for their owner alone. Tasks are for all who may read their folder.
#[cfg(unix)]
fn readable<'a, 'b, 'c>(builder: &'a mut tempfile::Builder<'b, 'c>) -> &'a mut tempfile::Builder<'b, 'c> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable<'a, 'b, 'c>(builder: &'a mut tempfile::Builder<'b, 'c>) -> &'a mut tempfile::Builder<'b, 'c> {
    builder
}

/// The entries of a folder; none of a link to one.
pub(super) fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let read = (!folder.is_symlink()).then(|| fs::read_dir(folder));
    read.into_iter().flatten().flatten().flatten().map(|entry| entry.path())
}

fn is_id(name: &str) -> bool {
    name.len() == 32 && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}
