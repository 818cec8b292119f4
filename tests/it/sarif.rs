//! `check --format sarif` follows the schema of SARIF 2.1.0: the objects, their required properties and bounds, as far as the log
//! has them. A property that is not listed here is not in the schema either, and reading it fails.

use serde::Deserialize;

use crate::program::falsify;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Log {
    #[serde(rename = "$schema")]
    schema: String,
    version: String,
    runs: Vec<Run>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Run {
    tool: Tool,
    column_kind: ColumnKind,
    results: Vec<Finding>,
}

#[derive(Deserialize, PartialEq, Debug)]
#[serde(rename_all = "camelCase")]
enum ColumnKind {
    Utf16CodeUnits,
    UnicodeCodePoints,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tool {
    driver: Component,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Component {
    name: String,
    semantic_version: String,
    rules: Vec<ReportingDescriptor>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct ReportingDescriptor {
    id: String,
    short_description: Message,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Message {
    text: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Finding {
    rule_id: String,
    rule_index: usize,
    level: Level,
    message: Message,
    locations: Vec<Location>,
    #[serde(default)]
    related_locations: Vec<Location>,
    #[serde(default)]
    fixes: Vec<Fix>,
}

#[derive(Deserialize, PartialEq, Debug)]
#[serde(rename_all = "camelCase")]
enum Level {
    None,
    Note,
    Warning,
    Error,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Location {
    id: Option<i64>,
    physical_location: PhysicalLocation,
    message: Option<Message>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct PhysicalLocation {
    artifact_location: ArtifactLocation,
    region: Region,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArtifactLocation {
    uri: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Region {
    start_line: u64,
    start_column: u64,
    end_line: u64,
    end_column: u64,
    byte_offset: u64,
    byte_length: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Fix {
    description: Message,
    artifact_changes: Vec<ArtifactChange>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct ArtifactChange {
    artifact_location: ArtifactLocation,
    replacements: Vec<Replacement>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Replacement {
    deleted_region: Region,
    inserted_content: Message,
}

impl Region {
    fn is_sound(&self) -> bool {
        let order = (self.start_line, self.start_column) <= (self.end_line, self.end_column);
        self.start_line >= 1 && self.start_column >= 1 && order && self.byte_offset + self.byte_length < 1 << 31
    }
}

impl ArtifactLocation {
    /// Whether it is a reference in the sense of RFC 3986: all other characters are written as `%` and two digits.
    fn is_reference(&self) -> bool {
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
        let path = self.uri.strip_prefix("file://").unwrap_or(&self.uri);
        let mut parts = path.split('%');
        let escaped = |part: &str| part.len() >= 2 && part.as_bytes()[..2].iter().all(u8::is_ascii_hexdigit);
        !path.is_empty()
            && parts.next().is_some_and(|first| first.bytes().all(plain))
            && parts.all(|part| escaped(part) && part.bytes().skip(2).all(plain))
    }
}

#[test]
fn the_log_keeps_to_the_schema_of_the_standard() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nrewrd a {}\n/* é */ reward r { on hit => max(3, v_c) }\npolicy p = idm(margin: 1 m speed: 2)\n\
                param unused: length = 3 m\nreward r {}\n? x\n";
    for name in ["plain.scn", "a b.scn", "ä 100%#?.scn", "no\\slash.scn"] {
        std::fs::write(folder.path().join(name), text).unwrap();
        let absolute = folder.path().join(name).display().to_string();
        for shown in [name, &absolute] {
            let output = falsify(&["check", "--format", "sarif", shown], folder.path());
            assert_eq!((output.status.code(), output.stderr.len()), (Some(3), 0));
            let log: Log = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{name}: {error}"));
            check(&log);
            let uri = &log.runs[0].results[0].locations[0].physical_location.artifact_location.uri;
            assert_eq!(uri.starts_with("file:///"), shown == absolute, "{uri}");
        }
    }
}

fn check(log: &Log) {
    assert_eq!((log.version.as_str(), log.runs.len()), ("2.1.0", 1));
    assert!(log.schema.ends_with("sarif-2.1.0.json"));
    let Run { tool: Tool { driver }, column_kind, results } = &log.runs[0];
    assert_eq!((driver.name.as_str(), column_kind), ("falsify", &ColumnKind::UnicodeCodePoints));
    assert_eq!(driver.semantic_version.split('.').count(), 3);
    assert!(driver.rules.iter().all(|rule| !rule.short_description.text.is_empty()));
    assert!(results.len() > 4);
    for result in results {
        assert_eq!(driver.rules[result.rule_index].id, result.rule_id);
        assert!(matches!(result.level, Level::Error | Level::Warning) && !result.message.text.is_empty());
        assert_eq!(result.locations.len(), 1);
        for (place, index) in result.related_locations.iter().zip(0..) {
            assert_eq!(place.id, Some(index));
            assert!(place.message.as_ref().is_some_and(|message| !message.text.is_empty()));
        }
        for place in result.locations.iter().chain(&result.related_locations) {
            let PhysicalLocation { artifact_location, region } = &place.physical_location;
            assert!(artifact_location.is_reference() && region.is_sound(), "{}", artifact_location.uri);
        }
        for fix in &result.fixes {
            assert!(!fix.description.text.is_empty() && !fix.artifact_changes.is_empty());
            for change in &fix.artifact_changes {
                assert!(change.artifact_location.is_reference() && !change.replacements.is_empty());
                assert!(change.replacements.iter().all(|each| each.deleted_region.is_sound()));
                assert!(change.replacements.iter().all(|each| !each.inserted_content.text.is_empty()));
            }
        }
    }
    assert!(results.iter().any(|result| !result.fixes.is_empty()));
    assert!(results.iter().any(|result| !result.related_locations.is_empty()));
}
