use base::signature::{Arguments, Form, Param, Signature, Type};
use base::units::Dimension;
use world::sim::VehicleBlueprint;

/// The form `vehicle`.
pub fn form() -> Form {
    let kind = |name, doc| Signature::new(name, doc, params());
    Form {
        name: "vehicle",
        doc: "The model of car under test. Every key overrides a figure of the model.",
        plain: None,
        multiplies: false,
        kinds: vec![
            kind("model3", "CARLA's Tesla Model 3."),
            kind("mkz_2017", "CARLA's Lincoln MKZ 2017, which LAV and InterFuser drive."),
            kind("generic", "A middle-class car without CARLA's oddities."),
        ],
    }
}

fn params() -> Vec<Param> {
    let within = |dimension, min, max| Type::Quantity { dimension, min, max };
    vec![
        Param::optional(
            "length",
            within(Dimension::LENGTH, 0.5, 30.0),
            "Its length. model3 4.792 m, mkz_2017 4.902 m (B); generic 4.7 m.",
        ),
        Param::optional(
            "width",
            within(Dimension::LENGTH, 0.3, 10.0),
            "Its width, mirrors included. model3 2.163 m, mkz_2017 2.128 m (B); generic 1.85 m.",
        ),
        Param::optional(
            "wheelbase",
            within(Dimension::LENGTH, 0.2, 30.0),
            "Distance between its axles. model3 3.005 m, mkz_2017 2.871 m (C); generic 2.8 m.",
        ),
        Param::optional(
            "full_brake",
            within(Dimension::ACCELERATION, 0.1, 100.0),
            "Deceleration at full brake. model3 7.01 m/s^2, mkz_2017 9.8 m/s^2 (C); generic 9 m/s^2.",
        ),
        Param::optional(
            "low_speed",
            within(Dimension::SPEED, 0.0, 100.0),
            "Below this speed CARLA's cars brake harder: 5 m/s (that they do B, the value D).",
        ),
        Param::optional(
            "low_speed_braking",
            within(Dimension::RATIO, 0.01, 100.0),
            "By this factor; a report without an explanation: 2 (D); generic 1.",
        ),
        Param::optional(
            "start_up_pause",
            within(Dimension::TIME, 0.0, 10_000.0),
            "How long it stands after it has appeared at rest: 2 s (reports of 2 to 2.5 s, B); generic 0 s.",
        ),
        Param::optional(
            "throttle_response",
            within(Dimension::RATIO, 0.01, 10.0),
            "By how much faster than the model it drives off at the same pedal: 1 (C; the model 3 does 3.7 m/s^2 with the pedal down).",
        ),
        Param::optional(
            "engine_drag",
            within(Dimension::FREQUENCY, 0.0, 10.0),
            "Deceleration for each m/s with the pedals released; none of it is left with the pedal down. model3 0.337 Hz (C), mkz_2017 0.134 Hz (C); generic 0.05 Hz.",
        ),
        Param::optional(
            "steering_response",
            within(Dimension::RATIO, 0.01, 1.1),
            "Share of the wheel angle that the tyres follow: 0.7 (C); generic 1.",
        ),
    ]
}

/// The model with its overrides.
pub fn lower(kind: &str, arguments: &Arguments) -> VehicleBlueprint {
    let mut blueprint = match kind {
        "model3" => VehicleBlueprint::model3(),
        "mkz_2017" => VehicleBlueprint::mkz_2017(),
        _ => VehicleBlueprint::generic(),
    };
    let given = |key: &str| arguments.has(key).then(|| arguments.number(key));
    let set = |field: &mut f64, value: Option<f64>| *field = value.unwrap_or(*field);
    set(&mut blueprint.half_length, given("length").map(|length| length / 2.0));
    set(&mut blueprint.half_width, given("width").map(|width| width / 2.0));
    set(&mut blueprint.wheelbase, given("wheelbase"));
    set(&mut blueprint.full_brake, given("full_brake"));
    set(&mut blueprint.low_speed, given("low_speed"));
    set(&mut blueprint.low_speed_braking, given("low_speed_braking"));
    set(&mut blueprint.start_up_pause, given("start_up_pause"));
    set(&mut blueprint.steering_response, given("steering_response"));
    if let (Some(drag), Some(own)) = (given("engine_drag"), blueprint.throttle.first().map(|line| -line.slope)) {
        blueprint.throttle.iter_mut().for_each(|line| line.slope -= (drag - own) * (1.0 - line.throttle));
    }
    let response = given("throttle_response").unwrap_or(1.0);
    blueprint.throttle.iter_mut().for_each(|line| line.at_rest *= response);
    blueprint
}
