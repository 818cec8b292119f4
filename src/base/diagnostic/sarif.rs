//! Diagnostics as SARIF 2.1.0, which code hosts show beside the lines.
//!
//! # Source
//! OASIS, Static Analysis Results Interchange Format 2.1.0.

use serde::Serialize;

use super::Severity;
use super::record::{Place, Record};

/// A log with one run.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Log {
    #[serde(rename = "$schema")]
    schema: &'static str,
    version: &'static str,
    runs: Vec<Run>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Run {
    tool: Tool,
    column_kind: &'static str,
    results: Vec<Finding>,
}

#[derive(Debug, Serialize)]
struct Tool {
    driver: Driver,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Driver {
    name: &'static str,
    semantic_version: String,
    rules: Vec<Rule>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Rule {
    id: String,
    short_description: Message,
}

#[derive(Debug, Serialize)]
struct Message {
    text: String,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Finding {
    rule_id: &'static str,
    rule_index: usize,
    level: Severity,
    message: Message,
    locations: Vec<Location>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    related_locations: Vec<Location>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    fixes: Vec<Fix>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<usize>,
    physical_location: PhysicalLocation,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<Message>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct PhysicalLocation {
    artifact_location: ArtifactLocation,
    region: Region,
}

#[derive(Debug, Serialize)]
struct ArtifactLocation {
    uri: String,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: usize,
    start_column: usize,
    end_line: usize,
    end_column: usize,
    byte_offset: usize,
    byte_length: usize,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Fix {
    description: Message,
    artifact_changes: Vec<ArtifactChange>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct ArtifactChange {
    artifact_location: ArtifactLocation,
    replacements: Vec<Replacement>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Replacement {
    deleted_region: Region,
    inserted_content: Message,
}

/// Makes a log of records; `rules` are all codes with a sentence each, in the order of the output.
pub fn sarif(records: &[Record], rules: &[(&str, &str)]) -> Log {
    let find = |code: &str| rules.iter().position(|(known, _)| *known == code).expect("every code is among the rules");
    let results = records.iter().map(|record| finding(record, find(record.code))).collect();
    let rules = rules.iter().map(|(id, text)| Rule { id: (*id).into(), short_description: message(text) }).collect();
    let driver = Driver { name: "falsify", semantic_version: env!("CARGO_PKG_VERSION").into(), rules };
    Log {
        schema: "https://json.schemastore.org/sarif-2.1.0.json",
        version: "2.1.0",
        runs: vec![Run { tool: Tool { driver }, column_kind: "unicodeCodePoints", results }],
    }
}

fn finding(record: &Record, rule_index: usize) -> Finding {
    let parts = [std::slice::from_ref(&record.message), std::slice::from_ref(&record.label), &record.help].concat();
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    let related = record.labels.iter().enumerate().map(|(index, label)| Location {
        id: Some(index),
        message: Some(message(&label.text)),
        ..location(&label.place)
    });
    let fixes = record.fixes.iter().map(|fix| Fix {
        description: message(&format!("write `{}`", fix.text.trim())),
        artifact_changes: vec![ArtifactChange {
            artifact_location: ArtifactLocation { uri: uri(&fix.place.file) },
            replacements: vec![Replacement {
                deleted_region: region(&fix.place),
                inserted_content: message(&fix.text),
            }],
        }],
    });
    Finding {
        rule_id: record.code,
        rule_index,
        level: record.severity,
        message: message(&parts.join("; ")),
        locations: vec![location(&record.place)],
        related_locations: related.collect(),
        fixes: fixes.collect(),
    }
}

fn message(text: &str) -> Message {
    Message { text: text.into() }
}

fn location(place: &Place) -> Location {
    let artifact_location = ArtifactLocation { uri: uri(&place.file) };
    Location {
        id: None,
        physical_location: PhysicalLocation { artifact_location, region: region(place) },
        message: None,
    }
}

fn region(place: &Place) -> Region {
    Region {
        start_line: place.line,
        start_column: place.column,
        end_line: place.end_line,
        end_column: place.end_column,
        byte_offset: place.byte_start,
        byte_length: place.byte_end - place.byte_start,
    }
}

/// A path as a reference: characters other than letters, digits and plain signs are percent-encoded.
pub fn uri(path: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let encoded: String =
        path.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect();
    if path.starts_with('/') { format!("file://{encoded}") } else { encoded }
}
