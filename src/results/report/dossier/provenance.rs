use super::section;
use crate::report::Manifest;
use crate::report::render::{Column, Section, Table, Value};

/// Versions, digests, and the command that repeats everything.
pub fn provenance(manifest: &Manifest) -> Section {
    let mut lead = vec![
        format!(
            "falsify {}, code {}, seed {}, vector instructions {}. The same files, seed and version give the same numbers.",
            manifest.version, manifest.code, manifest.seed, manifest.vector_instructions
        ),
        format!("`{}`", manifest.command()),
    ];
    if !manifest.complete {
        lead.push("**The campaign is not complete: it was stopped, something failed, or it reached a limit.**".into());
    }
    if manifest.errors > 0 {
        lead.push(format!("**In {} episodes a program failed. No number includes them.**", manifest.errors));
    }
    let files = Table {
        title: "Files read".into(),
        head: ["file", "BLAKE3"].map(Column::text).into(),
        rows: manifest
            .files
            .iter()
            .map(|file| vec![Value::from(&file.path), Value::Code(file.blake3.clone())])
            .collect(),
        ..Table::default()
    };
    section("provenance", "Versions and digests", lead, vec![files])
}
