use base::keys;
use base::signature::{Form, Keys, Signature};
use world::sim::VehicleBlueprint;

keys! {
    /// Figures that override those of a model.
    pub struct VehicleKeys {
        /// Its length. model3 4.792 m, mkz_2017 4.902 m (B); generic 4.7 m.
        length: Option<f64> as within(LENGTH, 0.5, 30.0),
        /// Its width, mirrors included. model3 2.163 m, mkz_2017 2.128 m (B); generic 1.85 m.
        width: Option<f64> as within(LENGTH, 0.3, 10.0),
        /// Distance between its axles. model3 3.005 m, mkz_2017 2.871 m (C); generic 2.8 m.
        wheelbase: Option<f64> as within(LENGTH, 0.2, 30.0),
        /// Deceleration at full brake. model3 7.01 m/s^2, mkz_2017 9.8 m/s^2 (C); generic 9 m/s^2.
        full_brake: Option<f64> as within(ACCELERATION, 0.1, 100.0),
        /// Factor by which CARLA's cars brake harder below 5 m/s (that they do B, the speed D); a report without an explanation: 2 (D); generic 1.
        low_speed_braking: Option<f64> as within(RATIO, 0.01, 100.0),
        /// How long it stands after it has appeared at rest: 2 s (reports of 2 to 2.5 s, B); generic 0 s.
        start_up_pause: Option<f64> as within(TIME, 0.0, 10_000.0),
        /// By how much faster than the model it drives off at the same pedal: 1 (C; the model 3 does 3.7 m/s^2 with the pedal
        /// down).
        throttle_response: Option<f64> as within(RATIO, 0.01, 10.0),
        /// Deceleration for each m/s with the pedals released; none of it is left with the pedal down. model3 0.337 Hz (C),
        /// mkz_2017 0.134 Hz (C); generic 0.05 Hz.
        engine_drag: Option<f64> as within(FREQUENCY, 0.0, 10.0),
        /// Share of the wheel angle that the tyres follow: 0.7 (C); generic 1.
        steering_response: Option<f64> as within(RATIO, 0.01, 1.1),
    }
}

/// A model of car: its word, the sentence for the reference, and its figures.
type Model = (&'static str, &'static str, fn() -> VehicleBlueprint);

/// All models of car; a new one is a line here.
const MODELS: [Model; 3] = [
    ("model3", "CARLA's Tesla Model 3.", VehicleBlueprint::model3),
    ("mkz_2017", "CARLA's Lincoln MKZ 2017, which LAV and InterFuser drive.", VehicleBlueprint::mkz_2017),
    ("generic", "A middle-class car without CARLA's oddities.", VehicleBlueprint::generic),
];

/// The form `vehicle`.
pub fn form() -> Form {
    let kinds = MODELS.map(|(name, doc, _)| Signature { name, doc, ..VehicleKeys::signature() });
    Form::of_kinds("vehicle", "The model of car under test. Every key overrides a figure of the model.", kinds.into())
}

/// The model with its overrides.
pub fn lower(kind: &str, keys: VehicleKeys) -> VehicleBlueprint {
    let model = MODELS.iter().find(|(name, ..)| *name == kind);
    let mut blueprint = (model.expect("checked: the kind is in the catalogue").2)();
    let set = |field: &mut f64, value: Option<f64>| *field = value.unwrap_or(*field);
    set(&mut blueprint.half_length, keys.length.map(|length| length / 2.0));
    set(&mut blueprint.half_width, keys.width.map(|width| width / 2.0));
    set(&mut blueprint.wheelbase, keys.wheelbase);
    set(&mut blueprint.full_brake, keys.full_brake);
    set(&mut blueprint.low_speed_braking, keys.low_speed_braking);
    set(&mut blueprint.start_up_pause, keys.start_up_pause);
    set(&mut blueprint.steering_response, keys.steering_response);
    if let (Some(drag), Some(own)) = (keys.engine_drag, blueprint.throttle.first().map(|line| -line.slope)) {
        blueprint.throttle.iter_mut().for_each(|line| line.slope -= (drag - own) * (1.0 - line.throttle));
    }
    let response = keys.throttle_response.unwrap_or(1.0);
    blueprint.throttle.iter_mut().for_each(|line| line.at_rest *= response);
    blueprint
}
