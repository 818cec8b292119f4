//! The descriptor of the messages that a trace holds: an excerpt of OSI's.
//!
//! # Source
//! `descriptor.proto` of protobuf; the messages are those of ASAM OSI 3.8.0.

use base::messages;

messages! {
    FileDescriptorSet {
        files: Vec<FileDescriptor> = 1 (message, repeated),
    }
    FileDescriptor {
        name: String = 1 (string),
        package: String = 2 (string),
        messages: Vec<Descriptor> = 4 (message, repeated),
        syntax: String = 12 (string),
    }
    Descriptor {
        name: String = 1 (string),
        fields: Vec<FieldDescriptor> = 2 (message, repeated),
        nested: Vec<Descriptor> = 3 (message, repeated),
        enums: Vec<EnumDescriptor> = 4 (message, repeated),
    }
    FieldDescriptor {
        name: String = 1 (string),
        number: i32 = 3 (int32),
        label: i32 = 4 (int32),
        kind: i32 = 5 (int32),
        type_name: Option<String> = 6 (string, optional),
    }
    EnumDescriptor {
        name: String = 1 (string),
        values: Vec<EnumValue> = 2 (message, repeated),
    }
    EnumValue {
        name: String = 1 (string),
        number: Option<i32> = 2 (int32, optional),
    }
}

/// The type of a field.
#[derive(Clone, Copy)]
enum Kind {
    Double,
    Int64,
    Uint64,
    Uint32,
    String,
    Strings,
    /// A message of the package, by its path.
    Message(&'static str),
    Repeated(&'static str),
    /// An enumeration of the package, by its path.
    Enum(&'static str),
}

/// Numbers of labels.
const OPTIONAL: i32 = 1;
const REPEATED: i32 = 3;

type Field = (&'static str, i32, Kind);

/// The descriptor set of `osi3.GroundTruth`.
pub fn descriptor() -> FileDescriptorSet {
    use Kind::{Double, Enum, Int64, Message, Repeated, Uint32, Uint64};
    let triple = |name, [x, y, z]: [&'static str; 3]| message(name, &[(x, 1, Double), (y, 2, Double), (z, 3, Double)]);
    let place = [("dimension", 1, Message("Dimension3d")), ("position", 2, Message("Vector3d"))];
    let orientation = ("orientation", 3, Message("Orientation3d"));
    let still = [place[0], place[1], orientation];
    let moving = [place[0], place[1], orientation, ("velocity", 4, Message("Vector3d"))];
    let ground_truth = message(
        "GroundTruth",
        &[
            ("version", 1, Message("InterfaceVersion")),
            ("timestamp", 2, Message("Timestamp")),
            ("host_vehicle_id", 3, Message("Identifier")),
            ("stationary_object", 4, Repeated("StationaryObject")),
            ("moving_object", 5, Repeated("MovingObject")),
            ("map_reference", 15, Kind::String),
        ],
    );
    let mut stationary_object = message(
        "StationaryObject",
        &[
            ("id", 1, Message("Identifier")),
            ("base", 2, Message("BaseStationary")),
            ("classification", 3, Message("StationaryObject.Classification")),
        ],
    );
    let mut classification = message("Classification", &[("type", 1, Enum("StationaryObject.Classification.Type"))]);
    classification.enums.push(enumeration(&[("TYPE_UNKNOWN", 0), ("TYPE_OTHER", 1)]));
    stationary_object.nested.push(classification);
    let version = [("version_major", 1, Uint32), ("version_minor", 2, Uint32), ("version_patch", 3, Uint32)];
    let messages = vec![
        message("InterfaceVersion", &version),
        message("Timestamp", &[("seconds", 1, Int64), ("nanos", 2, Uint32)]),
        message("Identifier", &[("value", 1, Uint64)]),
        triple("Vector3d", ["x", "y", "z"]),
        triple("Dimension3d", ["length", "width", "height"]),
        triple("Orientation3d", ["roll", "pitch", "yaw"]),
        message("ExternalReference", &[("type", 2, Kind::String), ("identifier", 3, Kind::Strings)]),
        message("BaseStationary", &still),
        message("BaseMoving", &moving),
        stationary_object,
        moving_object(),
        ground_truth,
    ];
    let file = FileDescriptor {
        name: "osi_groundtruth_excerpt.proto".to_owned(),
        package: "osi3".to_owned(),
        messages,
        syntax: "proto2".to_owned(),
    };
    FileDescriptorSet { files: vec![file] }
}

fn moving_object() -> Descriptor {
    use Kind::{Enum, Message, Repeated};
    let mut all = message(
        "MovingObject",
        &[
            ("id", 1, Message("Identifier")),
            ("base", 2, Message("BaseMoving")),
            ("type", 3, Enum("MovingObject.Type")),
            ("vehicle_attributes", 5, Message("MovingObject.VehicleAttributes")),
            ("vehicle_classification", 6, Message("MovingObject.VehicleClassification")),
            ("source_reference", 10, Repeated("ExternalReference")),
        ],
    );
    let attributes = [("bbcenter_to_rear", 4, Message("Vector3d")), ("bbcenter_to_front", 5, Message("Vector3d"))];
    let mut classification =
        message("VehicleClassification", &[("type", 1, Enum("MovingObject.VehicleClassification.Type"))]);
    classification.enums.push(enumeration(&[("TYPE_UNKNOWN", 0), ("TYPE_MEDIUM_CAR", 4)]));
    all.nested = vec![message("VehicleAttributes", &attributes), classification];
    all.enums.push(enumeration(&[("TYPE_UNKNOWN", 0), ("TYPE_VEHICLE", 2), ("TYPE_PEDESTRIAN", 3)]));
    all
}

fn message(name: &str, fields: &[Field]) -> Descriptor {
    Descriptor { name: name.to_owned(), fields: fields.iter().map(field).collect(), ..Descriptor::default() }
}

fn field(&(name, number, kind): &Field) -> FieldDescriptor {
    // Numbers of `FieldDescriptorProto.Type`.
    let (code, type_name) = match kind {
        Kind::Double => (1, None),
        Kind::Int64 => (3, None),
        Kind::Uint64 => (4, None),
        Kind::String | Kind::Strings => (9, None),
        Kind::Message(path) | Kind::Repeated(path) => (11, Some(path)),
        Kind::Uint32 => (13, None),
        Kind::Enum(path) => (14, Some(path)),
    };
    FieldDescriptor {
        name: name.to_owned(),
        number,
        label: if matches!(kind, Kind::Repeated(_) | Kind::Strings) { REPEATED } else { OPTIONAL },
        kind: code,
        type_name: type_name.map(|path| format!(".osi3.{path}")),
    }
}

/// The values of the enumeration `Type` of a message that occur.
fn enumeration(values: &[(&str, i32)]) -> EnumDescriptor {
    let value = |&(name, number): &(&str, i32)| EnumValue { name: name.to_owned(), number: Some(number) };
    EnumDescriptor { name: "Type".to_owned(), values: values.iter().map(value).collect() }
}
