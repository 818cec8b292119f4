use super::section;
use crate::report::render::{Column, Section, Table, Value};
use crate::report::{Manifest, ProgramRecord};

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
            .map(|file| vec![Value::from(&file.path), Value::code(file.blake3.clone())])
            .collect(),
        ..Table::default()
    };
    let of_program = |program: &ProgramRecord| -> Vec<Vec<Value>> {
        let version = if program.version.is_empty() { "none stated" } else { &program.version };
        let of =
            |file: &str, digest: &str| vec![(&program.name).into(), version.into(), file.into(), Value::code(digest)];
        let files = program.files.iter().map(|(file, digest)| of(file, digest));
        if program.files.is_empty() { vec![of("none declared", "–")] } else { files.collect() }
    };
    let programs = Table {
        title: "Programs that drive or walk".into(),
        head: ["program", "version", "file", "BLAKE3"].map(Column::text).into(),
        rows: manifest.programs.iter().flat_map(of_program).collect(),
        ..Table::default()
    };
    let tables = [files, programs].into_iter().filter(|table| !table.rows.is_empty());
    section("provenance", "Versions and digests", lead, tables.collect())
}
