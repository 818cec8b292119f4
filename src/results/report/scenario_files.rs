//! Where a report holds the files of its scenario.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// The folder of a report with the files of its scenario.
pub(super) const SCENARIO: &str = "scenario";
/// The folder in it for files that are not in the folder of the first file or below.
const OUTSIDE: &str = "outside";
/// The greatest size of a file that a report holds (bytes). Of a larger one it has the digest.
pub const MAX_HELD_BYTES: usize = 4 << 20;

/// The places in a report of files with these paths, which are relative to `folder`. What lies in the folder of the first file or below keeps
/// its place in the tree, so that imports and maps are found there as they were. Other files are beside each other in `outside`. So the
/// places say nothing about the machine, and are the same wherever the scenario is.
pub fn held_places(paths: &[&str], folder: &Path) -> Vec<String> {
    let whole: Vec<Vec<String>> = paths.iter().map(|path| parts(&folder.join(path))).collect();
    let base = whole.first().and_then(|first| first.split_last()).map_or(Vec::new(), |(_, folders)| folders.to_vec());
    let mut owners: BTreeMap<String, &[String]> = BTreeMap::new();
    let mut places = Vec::new();
    for file in &whole {
        let is_free = |place: &String| owners.get(place).is_none_or(|owner| owner == file);
        let place = candidates(file, &base).find(is_free).expect("there is no end of numbers");
        places.push(format!("{SCENARIO}/{place}"));
        owners.insert(place, file);
    }
    places
}

/// The places that a file may have, the best one first.
fn candidates(file: &[String], base: &[String]) -> impl Iterator<Item = String> {
    let name = file.last().cloned().unwrap_or_default();
    let inside = file.strip_prefix(base).map(|rest| rest.join("/"));
    let outside = (1_u64..).map(move |number| match number {
        1 => format!("{OUTSIDE}/{name}"),
        _ => format!("{OUTSIDE}/{number}/{name}"),
    });
    inside.into_iter().chain(outside)
}

/// The names of the folders on a path and of its file, without `.` and `..`.
fn parts(path: &Path) -> Vec<String> {
    let mut parts = Vec::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            Component::ParentDir => drop(parts.pop()),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    parts
}

/// The path of a held file on the disk; `None` if the manifest names a place outside of the folder for them, or a link may lead there.
pub(super) fn held_path(report: &Path, held: &str) -> Option<PathBuf> {
    let inside = Path::new(held).components().all(|part| matches!(part, Component::Normal(_)));
    let is_link = |part: &Path| !part.as_os_str().is_empty() && report.join(part).is_symlink();
    let held = Path::new(held);
    (inside && held.starts_with(SCENARIO) && !held.ancestors().any(is_link)).then(|| report.join(held))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_files_keep_their_tree() {
        let places = |paths: &[&str]| held_places(paths, Path::new("/home/me/study"));
        assert_eq!(places(&["my.scn"]), ["scenario/my.scn"]);
        assert_eq!(
            places(&["my.scn", "lib/a.scn", "./lib/../b.scn"]),
            ["scenario/my.scn", "scenario/lib/a.scn", "scenario/b.scn"]
        );
        assert_eq!(places(&["my.scn", "../maps/a.xodr"]), ["scenario/my.scn", "scenario/outside/a.xodr"]);
        assert_eq!(
            places(&["/home/you/my.scn", "/home/you/b.scn", "/maps/a.xodr", "/maps/new/a.xodr"]),
            ["scenario/my.scn", "scenario/b.scn", "scenario/outside/a.xodr", "scenario/outside/2/a.xodr"]
        );
        assert_eq!(
            places(&["my.scn", "../x/my.scn", "../study/my.scn"])[1..],
            ["scenario/outside/my.scn", "scenario/my.scn"]
        );
        assert!(places(&[]).is_empty());
    }

    #[test]
    fn a_held_file_is_in_its_folder() {
        let report = Path::new("r");
        assert_eq!(held_path(report, "scenario/a/b.scn"), Some("r/scenario/a/b.scn".into()));
        for outside in ["../b.scn", "scenario/../../b.scn", "/etc/passwd", "pedestrians/a", ""] {
            assert_eq!(held_path(report, outside), None, "{outside}");
        }
    }
}
