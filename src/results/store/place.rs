use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::StoreError;
use super::work_folder::{self, LOCK, WorkFolder};
use base::files;

/// The folder beside the reports: for tasks, and for reports that are being written.
const NAME: &str = ".falsify";
/// Tasks, claims, and the tasks that campaigns wanted.
const FOLDERS: [&str; 3] = ["tasks", "claims", "campaigns"];
/// The learning curves of trainings, which grow while they run.
const LEARNING: &str = "learning";
/// An explanation for people who find the folder.
const README: &str = "README.txt";
const ABOUT: &str = "\
Finished and unfinished work of falsify, from which reports are made.
If it is removed, only the time to repeat it is lost.
`head -2` of a file in `tasks` shows what it is. `learning` holds the learning curves of trainings, which grow while they run.
";
const ABOUT_DRAFTS: &str = "\
Reports that falsify is writing. Finished and unfinished work is in another folder, which was named by --cache,
FALSIFY_CACHE or `cache` in falsify.toml. `learning` holds the learning curves of trainings, which grow while they run.
";

/// Where the tasks of a folder for reports are stored, and where its reports are written.
#[derive(Debug, PartialEq)]
pub(super) struct Place {
    /// The folder for reports, as the file system has it.
    out: PathBuf,
    /// The folder beside the reports, on their file system.
    beside: PathBuf,
    /// The folder with the tasks.
    root: PathBuf,
    /// The folder with the tasks that the campaigns of this folder for reports wanted.
    campaigns: PathBuf,
}

impl Place {
    /// Finds the place of a folder for reports. Its tasks are in a cache, if one is named.
    ///
    /// # Errors
    /// The cache is inside the folder for reports.
    pub fn of(out: &Path, cache: Option<&Path>) -> Result<Self, StoreError> {
        let (beside, real_out) = (out.join(NAME), real(out));
        let cache = cache.filter(|cache| real(cache) != real(&beside));
        let Some(cache) = cache else {
            let (root, campaigns) = (beside.clone(), beside.join("campaigns"));
            return Ok(Self { out: real_out, beside, root, campaigns });
        };
        if real(cache).starts_with(&real_out) {
            return Err(StoreError::Inside { cache: cache.to_path_buf(), out: out.to_path_buf() });
        }
        // Campaigns of the same name may be run for several folders.
        let name = blake3::hash(real_out.as_os_str().as_encoded_bytes()).to_hex();
        let campaigns = cache.join("campaigns").join(&name[..16]);
        Ok(Self { out: real_out, beside, root: cache.to_path_buf(), campaigns })
    }

    /// The place in a folder that is one for reports or a cache.
    pub fn within(folder: &Path) -> Self {
        let beside = folder.join(NAME);
        let root = if !beside.join(FOLDERS[0]).is_dir() && folder.join(FOLDERS[0]).is_dir() {
            folder.to_path_buf()
        } else {
            beside.clone()
        };
        Self { out: real(folder), beside, campaigns: root.join("campaigns"), root }
    }

    /// The folder for reports, as the file system has it.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// The folder beside the reports.
    pub fn beside(&self) -> &Path {
        &self.beside
    }

    /// The folder with the tasks.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The folder with the tasks that its campaigns wanted.
    pub fn campaigns(&self) -> &Path {
        &self.campaigns
    }

    /// The folder for the learning curves of a campaign, beside its report.
    pub fn learning(&self, campaign: &str) -> PathBuf {
        self.beside.join(LEARNING).join(campaign)
    }

    /// Whether the tasks are beside the reports.
    pub fn is_beside(&self) -> bool {
        self.root == self.beside
    }

    /// Checks that no link is in the folders of tasks and drafts, or in place of the one beside the reports: what it leads to is not ours.
    ///
    /// # Errors
    /// There is one, or a folder cannot be read.
    pub fn check_links(&self) -> Result<(), StoreError> {
        let link = |folder: &Path| {
            if folder == self.beside && folder.is_symlink() {
                return Ok(Some(folder.to_path_buf()));
            }
            // What is no folder has a message of its own.
            let found = if folder.is_dir() { files::first_link(folder) } else { Ok(None) };
            found.map_err(|source| StoreError::Unread { path: folder.to_path_buf(), source })
        };
        let first = link(&self.beside)?;
        let first = if first.is_none() && !self.is_beside() { link(&self.root)? } else { first };
        first.map_or(Ok(()), |path| Err(StoreError::Link { path }))
    }

    /// Checks that a cache is a folder of tasks, or empty, or does not exist yet, and that no link is in it.
    ///
    /// # Errors
    /// It has other contents, or a link.
    pub fn check(&self) -> Result<(), StoreError> {
        self.check_links()?;
        let path = || self.root.clone();
        if self.is_beside() || !self.root.exists() {
            return Ok(());
        }
        if !self.root.is_dir() {
            return Err(StoreError::NoFolder { path: path() });
        }
        let entries = fs::read_dir(&self.root).map_err(|source| StoreError::Folder { path: path(), source })?;
        let foreign = entries.flatten().filter(|entry| !is_begun(entry));
        let Some(entry) = foreign.map(|entry| entry.file_name().to_string_lossy().into_owned()).min() else {
            return Ok(());
        };
        // The explanation is the first that a cache gets. It is read last: another process may have begun the cache meanwhile.
        let about = files::text(&self.root.join(README)).unwrap_or_default();
        if about.lines().next() == ABOUT.lines().next() {
            return Ok(());
        }
        Err(StoreError::Foreign { path: path(), entry })
    }

    /// Makes all folders that are missing.
    ///
    /// # Errors
    /// One cannot be made, or the cache has other contents.
    pub fn make(&self) -> Result<(), StoreError> {
        self.check()?;
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |source| StoreError::Folder { path, source }
        };
        let out = self.beside.parent().expect("it is in the folder for reports");
        fs::create_dir_all(out).map_err(failed(out))?;
        let root = if self.is_beside() { out } else { &self.root };
        make(&self.root, &FOLDERS, ABOUT).map_err(failed(root))?;
        if self.is_beside() { Ok(()) } else { make(&self.beside, &[], ABOUT_DRAFTS).map_err(failed(out)) }
    }

    /// Checks that reports can be moved from the folder in which they are written to their place.
    ///
    /// # Errors
    /// They cannot, since the two folders are on different file systems.
    pub fn check_drafts(&self, drafts: &WorkFolder) -> Result<(), StoreError> {
        let failed = |source| StoreError::Folder { path: self.beside.clone(), source };
        let probe = tempfile::tempdir_in(drafts.path().map_err(failed)?).map_err(failed)?;
        // The folder beside the reports is never empty, so this move must fail. Between file systems it fails with another error.
        match fs::rename(probe.path(), &self.beside) {
            Err(error) if error.kind() == ErrorKind::CrossesDevices => {
                Err(StoreError::Apart { beside: self.beside.clone() })
            }
            _ => Ok(()),
        }
    }
}

fn make(root: &Path, folders: &[&str], about: &str) -> io::Result<()> {
    fs::create_dir_all(root)?;
    let readme = root.join(README);
    if !readme.exists() {
        fs::write(readme, about)?;
    }
    folders.iter().try_for_each(|folder| fs::create_dir_all(root.join(folder)))
}

/// Whether an entry of a folder without our explanation is of a cache that was begun: one of our names, and nothing in it yet.
fn is_begun(entry: &fs::DirEntry) -> bool {
    let (path, name) = (entry.path(), entry.file_name());
    let known = name.to_str().is_some_and(|name| FOLDERS.contains(&name) || [README, LOCK, LEARNING].contains(&name));
    let is_empty = fs::symlink_metadata(&path).is_ok_and(|data| match data.is_dir() {
        true => fs::read_dir(&path).is_ok_and(|mut inside| inside.next().is_none()),
        false => data.is_file() && data.len() == 0,
    });
    known && is_empty || work_folder::is_ours(&path)
}

/// A path as the file system has it. Parts that do not exist yet stay as they are written.
fn real(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for ancestor in path.ancestors() {
        if let (Ok(real), Ok(rest)) = (ancestor.canonicalize(), path.strip_prefix(ancestor)) {
            return real.components().chain(rest.components()).collect();
        }
    }
    path
}
