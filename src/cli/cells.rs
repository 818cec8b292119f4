use std::collections::BTreeSet;

use super::args::CellsOptions;
use super::{ExitCode, front};
use crate::store::{Index, Store};

/// `falsify cells`
pub fn cells(options: &CellsOptions) -> ExitCode {
    let note = Box::new(|text: &str| front::warn(text));
    let opened = if options.prune { Store::open(&options.out, note) } else { Ok(Store::look(&options.out, note)) };
    let store = match opened {
        Ok(store) => store,
        Err(error) => {
            front::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    };
    let sizes = store.sizes();
    let mut used = BTreeSet::new();
    for name in store.campaigns() {
        let wanted = Index::read(&store, &name).wanted;
        let there: Vec<u64> = wanted.iter().filter_map(|id| sizes.get(id).copied()).collect();
        let (count, all) = (there.len(), wanted.len());
        front::say(&format!("campaign {name}: {count} of {all} cells, {}", megabytes(there.iter().sum())));
        used.extend(wanted);
    }
    let unused: Vec<(&String, &u64)> = sizes.iter().filter(|(id, _)| !used.contains(*id)).collect();
    let size = megabytes(unused.iter().map(|(_, size)| **size).sum());
    let what = format!("{} cells that no campaign wants any more, {size}", unused.len());
    if !options.prune {
        front::say(&format!("{what}{}", if unused.is_empty() { "" } else { "; --prune removes them" }));
        return ExitCode::Done;
    }
    for (id, _) in &unused {
        if let Err(error) = store.remove(id) {
            front::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    }
    front::say(&format!("removed {what}"));
    ExitCode::Done
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}
