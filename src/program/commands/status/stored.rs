use std::collections::BTreeSet;

use super::StatusArgs;
use crate::cli::console;
use crate::cli::failure::{failed, misused};
use crate::exit_code::{Ended, ExitCode};
use results::store::{References, Store, StoreError};

/// `falsify status --stored` and `--prune` of a folder for reports and its cache.
pub fn stored(options: &StatusArgs) -> Ended {
    let cache = options.cache.as_deref();
    if let Some(missing) = cache.filter(|cache| !cache.exists()) {
        return Err(misused(format!("the cache `{}` does not exist", missing.display())));
    }
    let note = Box::new(|text: &str| console::warn(text));
    let open = if options.prune { Store::open } else { Store::look };
    let told = open(&options.place().0, cache, note).and_then(|store| tell(&store, options));
    told.map_err(|error| failed(error.into()))?;
    Ok(ExitCode::Done)
}

fn tell(store: &Store, options: &StatusArgs) -> Result<(), StoreError> {
    // While this is held, no campaign records new wants. So no task is removed between its request and its use.
    let _still = options.prune.then(|| store.hold_still());
    let sizes = store.sizes();
    let mut used = BTreeSet::new();
    let (gone, kept): (Vec<References>, Vec<References>) =
        store.wants().into_iter().partition(|wants| options.gone && wants.is_gone());
    for References { campaign, tasks, elsewhere, .. } in gone.iter().chain(&kept) {
        let there: Vec<u64> = tasks.iter().filter_map(|id| sizes.get(id).copied()).collect();
        let of = elsewhere.as_ref().map_or(String::new(), |out| format!(" of `{}`", out.display()));
        let size = megabytes(there.iter().sum());
        console::say(&format!("campaign {campaign}{of}: {} of {} tasks, {size}", there.len(), tasks.len()));
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
