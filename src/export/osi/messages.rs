use base::messages;

messages! {
    GroundTruth {
        version: Option<InterfaceVersion> = 1 (message, optional),
        timestamp: Option<Timestamp> = 2 (message, optional),
        host_vehicle: Option<Identifier> = 3 (message, optional),
        stationary_objects: Vec<StationaryObject> = 4 (message, repeated),
        moving_objects: Vec<MovingObject> = 5 (message, repeated),
        map_reference: Option<String> = 15 (string, optional),
    }
    InterfaceVersion {
        major: Option<u32> = 1 (uint32, optional),
        minor: Option<u32> = 2 (uint32, optional),
        patch: Option<u32> = 3 (uint32, optional),
    }
    Timestamp {
        seconds: Option<i64> = 1 (int64, optional),
        nanos: Option<u32> = 2 (uint32, optional),
    }
    Identifier {
        value: Option<u64> = 1 (uint64, optional),
    }
    /// A vector; also length, width and height, and roll, pitch and yaw, which have the same numbers.
    Triple {
        x: Option<f64> = 1 (double, optional),
        y: Option<f64> = 2 (double, optional),
        z: Option<f64> = 3 (double, optional),
    }
    /// `BaseMoving`, and `BaseStationary` without a velocity.
    Base {
        dimension: Option<Triple> = 1 (message, optional),
        position: Option<Triple> = 2 (message, optional),
        orientation: Option<Triple> = 3 (message, optional),
        velocity: Option<Triple> = 4 (message, optional),
    }
    MovingObject {
        id: Option<Identifier> = 1 (message, optional),
        base: Option<Base> = 2 (message, optional),
        kind: Option<i32> = 3 (int32, optional),
        attributes: Option<VehicleAttributes> = 5 (message, optional),
        classification: Option<Classification> = 6 (message, optional),
        sources: Vec<ExternalReference> = 10 (message, repeated),
    }
    ExternalReference {
        kind: Option<String> = 2 (string, optional),
        identifiers: Vec<String> = 3 (string, repeated),
    }
    VehicleAttributes {
        centre_to_rear: Option<Triple> = 4 (message, optional),
        centre_to_front: Option<Triple> = 5 (message, optional),
    }
    Classification {
        kind: Option<i32> = 1 (int32, optional),
    }
    StationaryObject {
        id: Option<Identifier> = 1 (message, optional),
        base: Option<Base> = 2 (message, optional),
        classification: Option<Classification> = 3 (message, optional),
    }
}
