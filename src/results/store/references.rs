//! The tasks that campaigns want, over all folders for reports that share a store.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use super::folder::entries;
use super::{Index, Store, StoreError};

/// The tasks that a campaign wants.
#[derive(Debug)]
pub struct References {
    pub campaign: String,
    /// The folder for its reports; `None` for the current one.
    pub elsewhere: Option<PathBuf>,
    pub tasks: BTreeSet<String>,
    file: PathBuf,
}

impl References {
    /// Whether the folder for its reports does not exist, or cannot be seen from here.
    pub fn is_gone(&self) -> bool {
        self.elsewhere.as_ref().is_some_and(|out| !out.is_dir())
    }
}

impl Store {
    /// What all campaigns want; those of this folder for reports come first.
    pub fn wants(&self) -> Vec<References> {
        let campaigns = self.place().root().join("campaigns");
        let mut found: Vec<References> = self.wanted_in(&campaigns);
        for folder in entries(&campaigns).filter(|path| path.is_dir() && !path.is_symlink()) {
            found.extend(self.wanted_in(&folder));
        }
        found.sort_by(|one, other| (&one.elsewhere, &one.campaign).cmp(&(&other.elsewhere, &other.campaign)));
        found
    }

    /// Removes the references of a campaign.
    ///
    /// # Errors
    /// Its file cannot be removed.
    pub fn give_up(&self, wants: &References) -> Result<(), StoreError> {
        fs::remove_file(&wants.file).map_err(|source| StoreError::File { path: wants.file.clone(), source })
    }

    fn wanted_in(&self, folder: &Path) -> Vec<References> {
        let place = self.place();
        let read = |file: PathBuf| {
            let campaign = file.file_name()?.to_str()?.strip_suffix(".json")?.to_string();
            let index: Index = serde_json::from_str(&base::files::text(&file).ok()?).ok()?;
            let elsewhere = if folder == place.campaigns() {
                None
            } else if folder.parent() == Some(place.root()) && place.root().file_name() == Some(OsStr::new(".falsify"))
            {
                // The store is beside its reports, even after both were moved.
                place.root().parent().map(Path::to_path_buf)
            } else {
                Some(PathBuf::from(index.out))
            };
            Some(References { campaign, elsewhere, tasks: index.wanted, file })
        };
        entries(folder).filter(|path| path.is_file() && !path.is_symlink()).filter_map(read).collect()
    }
}
