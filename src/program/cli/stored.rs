use std::collections::BTreeSet;
use std::path::Path;

use super::exit_code::ExitCode;
use super::{console, failure};
use results::store::{References, Store, StoreError};

/// What to do with finished work that is stored.
#[derive(Debug)]
pub struct Stored<'a> {
    /// The folder for reports.
    pub out: &'a Path,
    /// The folder that `run` was given as --cache.
    pub cache: Option<&'a Path>,
    /// Remove tasks that no campaign needed in its last run, for any folder for reports.
    pub prune: bool,
    /// Also remove tasks of folders for reports that do not exist, or cannot be seen from here.
    pub gone: bool,
}

/// `falsify status --stored` and `--prune`
pub fn stored(options: &Stored<'_>) -> ExitCode {
    if let Some(missing) = options.cache.filter(|cache| !cache.exists()) {
        console::fail(&format!("the cache `{}` does not exist", missing.display()));
        return ExitCode::Usage;
    }
    let note = Box::new(|text: &str| console::warn(text));
    let (out, cache) = (options.out, options.cache);
    let opened = if options.prune { Store::open(out, cache, note) } else { Store::look(out, cache, note) };
    let told = opened.and_then(|store| tell(&store, options));
    told.map_or_else(
        |error| {
            console::fail(&error.to_string());
            failure::store_code(&error)
        },
        |()| ExitCode::Done,
    )
}

fn tell(store: &Store, options: &Stored<'_>) -> Result<(), StoreError> {
    // While this is held, no campaign records new wants. So no task is removed between its request and its use.
    let _still = options.prune.then(|| store.hold_still());
    let sizes = store.sizes();
    let mut used = BTreeSet::new();
    let (gone, kept): (Vec<References>, Vec<References>) =
        store.wants().into_iter().partition(|wants| options.gone && wants.is_gone());
    for References { campaign, tasks, elsewhere, .. } in gone.iter().chain(&kept) {
        let there: Vec<u64> = tasks.iter().filter_map(|id| sizes.get(id).copied()).collect();
        let of = elsewhere.as_ref().map_or(String::new(), |out| format!(" of `{}`", out.display()));
        let (count, all, size) = (there.len(), tasks.len(), megabytes(there.iter().sum()));
        console::say(&format!("campaign {campaign}{of}: {count} of {all} tasks, {size}"));
    }
    kept.iter().for_each(|wants| used.extend(&wants.tasks));
    let unused: Vec<(&String, &u64)> = sizes.iter().filter(|(id, _)| !used.contains(id)).collect();
    let size = megabytes(unused.iter().map(|(_, size)| **size).sum());
    let what = match unused.len() {
        1 => format!("1 task that no campaign needs, {size}"),
        count => format!("{count} tasks that no campaign needs, {size}"),
    };
    if options.prune {
        gone.iter().try_for_each(|wants| store.give_up(wants))?;
        unused.iter().try_for_each(|(id, _)| store.remove(id))?;
        console::say(&format!("removed {what}"));
    } else {
        console::say(&format!("{what}{}", if unused.is_empty() { "" } else { "; --prune removes them" }));
    }
    if !options.gone && kept.iter().any(References::is_gone) {
        console::say(
            "some folders for reports do not exist, or cannot be seen from here; --prune --gone removes their tasks",
        );
    }
    Ok(())
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
