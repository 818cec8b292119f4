//! Words of other languages and libraries, and their equivalents in this language.

/// The equivalent of a word of another language or library: of stable-baselines3, Scenic, OpenSCENARIO, Python, C.
pub(super) fn own_word(word: &str) -> Option<&'static str> {
    Some(match word {
        "n_steps" => "steps_per_update",
        "total_timesteps" | "timesteps" => "steps",
        "n_epochs" => "epochs",
        "n_envs" | "num_envs" => "environments",
        "batch" | "minibatch_size" => "batch_size",
        "lr" | "step_size" => "learning_rate",
        "clip_range" | "clip_param" => "clip",
        "clip_range_vf" => "value_clip",
        "ent_coef" => "entropy_coefficient",
        "vf_coef" => "value_coefficient",
        "max_grad_norm" => "max_gradient_norm",
        "normalize_advantage" => "normalize_advantages",
        "stats_window_size" => "statistics_window",
        "lam" | "lambda" => "gae_lambda",
        "discount" => "gamma",
        "max_speed" | "speeds" => "speed",
        "dt" | "timestep" | "delta" => "tick",
        "max_steps" | "max_ticks" => "ticks",
        "angle" => "bearing",
        "radius" | "range" => "distance",
        "float" | "double" | "real" | "f64" => "number",
        "int" | "uint" | "i64" => "integer",
        "bool" => "boolean",
        "string" | "str" => "text",
        "collision" | "crash" | "collide" => "hit",
        "policy" | "drivers" | "agents" => "policies",
        "driver" | "agent" => "policy",
        "ego" | "car" => "vehicle",
        "pedestrian" | "walker" => "adversary",
        "scenario" | "experiment" => "campaign",
        "map" | "world" => "town",
        "road" => "street",
        "house" => "building",
        "headway" => "time_headway",
        "reaction" | "reaction_time" => "reaction_allowance",
        "delay" => "actuation_delay",
        "Range" | "Uniform" => "uniform",
        "Normal" | "Gaussian" | "gaussian" => "normal",
        "Options" | "Choice" | "uniform_choice" => "choice",
        "Discrete" => "weighted",
        "True" | "yes" | "TRUE" | "on" => "true",
        "False" | "no" | "FALSE" | "off" => "false",
        _ => return None,
    })
}

/// The unit for its full name, or for an abbreviation of another language.
pub(super) fn own_unit(word: &str) -> Option<&'static str> {
    let lower = word.to_lowercase();
    match lower.as_str() {
        "mps" => return Some("m/s"),
        "mps2" | "m/s/s" | "mpss" => return Some("m/s^2"),
        "pct" => return Some("percent"),
        "mi/h" | "mile/h" | "miles/h" | "miles/hour" => return Some("mph"),
        _ => {}
    }
    Some(match lower.strip_suffix('s').filter(|rest| rest.len() > 1).unwrap_or(&lower) {
        "meter" | "metre" => "m",
        "kilometer" | "kilometre" => "km",
        "centimeter" | "centimetre" => "cm",
        "millimeter" | "millimetre" => "mm",
        "second" | "sec" => "s",
        "millisecond" | "msec" => "ms",
        "minute" => "min",
        "hour" | "hr" => "h",
        "degree" => "deg",
        "radian" => "rad",
        "hertz" => "Hz",
        "kilogram" => "kg",
        "kmh" | "kmph" => "km/h",
        _ => return None,
    })
}
