use prost::Message;

#[derive(Clone, PartialEq, Message)]
pub struct GroundTruth {
    #[prost(message, optional, tag = "1")]
    pub version: Option<InterfaceVersion>,
    #[prost(message, optional, tag = "2")]
    pub timestamp: Option<Timestamp>,
    #[prost(message, optional, tag = "3")]
    pub host_vehicle: Option<Identifier>,
    #[prost(message, repeated, tag = "4")]
    pub stationary_objects: Vec<StationaryObject>,
    #[prost(message, repeated, tag = "5")]
    pub moving_objects: Vec<MovingObject>,
    #[prost(string, optional, tag = "15")]
    pub map_reference: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct InterfaceVersion {
    #[prost(uint32, optional, tag = "1")]
    pub major: Option<u32>,
    #[prost(uint32, optional, tag = "2")]
    pub minor: Option<u32>,
    #[prost(uint32, optional, tag = "3")]
    pub patch: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct Timestamp {
    #[prost(int64, optional, tag = "1")]
    pub seconds: Option<i64>,
    #[prost(uint32, optional, tag = "2")]
    pub nanos: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct Identifier {
    #[prost(uint64, optional, tag = "1")]
    pub value: Option<u64>,
}

/// A vector; also length, width and height, and roll, pitch and yaw, which have the same numbers.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Triple {
    #[prost(double, optional, tag = "1")]
    pub x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub z: Option<f64>,
}

/// `BaseMoving`, and `BaseStationary` without a velocity.
#[derive(Clone, PartialEq, Message)]
pub struct Base {
    #[prost(message, optional, tag = "1")]
    pub dimension: Option<Triple>,
    #[prost(message, optional, tag = "2")]
    pub position: Option<Triple>,
    #[prost(message, optional, tag = "3")]
    pub orientation: Option<Triple>,
    #[prost(message, optional, tag = "4")]
    pub velocity: Option<Triple>,
}

#[derive(Clone, PartialEq, Message)]
pub struct MovingObject {
    #[prost(message, optional, tag = "1")]
    pub id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    pub base: Option<Base>,
    #[prost(int32, optional, tag = "3")]
    pub kind: Option<i32>,
    #[prost(message, optional, tag = "5")]
    pub attributes: Option<VehicleAttributes>,
    #[prost(message, optional, tag = "6")]
    pub classification: Option<Classification>,
    #[prost(message, repeated, tag = "10")]
    pub sources: Vec<ExternalReference>,
}

#[derive(Clone, PartialEq, Message)]
pub struct ExternalReference {
    #[prost(string, optional, tag = "2")]
    pub kind: Option<String>,
    #[prost(string, repeated, tag = "3")]
    pub identifiers: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct VehicleAttributes {
    #[prost(message, optional, tag = "4")]
    pub centre_to_rear: Option<Triple>,
    #[prost(message, optional, tag = "5")]
    pub centre_to_front: Option<Triple>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct Classification {
    #[prost(int32, optional, tag = "1")]
    pub kind: Option<i32>,
}

#[derive(Clone, PartialEq, Message)]
pub struct StationaryObject {
    #[prost(message, optional, tag = "1")]
    pub id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    pub base: Option<Base>,
    #[prost(message, optional, tag = "3")]
    pub classification: Option<Classification>,
}
