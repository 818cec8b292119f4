//! Words of other languages and libraries, and their equivalents in this language.

/// The equivalents of a word of another language or library: of stable-baselines3, Scenic, OpenSCENARIO, Python, C. Which of them is meant depends on
/// what may stand in its place.
pub(super) fn own_words(word: &str) -> &'static [&'static str] {
    match word {
        "n_steps" => &["steps_per_update"],
        "total_timesteps" | "timesteps" => &["steps"],
        "n_epochs" => &["epochs"],
        "n_envs" | "num_envs" => &["environments"],
        "batch" | "minibatch_size" => &["batch_size"],
        "lr" | "step_size" => &["learning_rate"],
        "clip_range" | "clip_param" => &["clip"],
        "clip_range_vf" => &["value_clip"],
        "ent_coef" => &["entropy_coefficient"],
        "vf_coef" => &["value_coefficient"],
        "max_grad_norm" => &["max_gradient_norm"],
        "normalize_advantage" => &["normalize_advantages"],
        "stats_window_size" => &["statistics_window"],
        "net_arch" | "layers" | "hidden_layers" | "hidden_sizes" | "policy_kwargs" => &["hidden"],
        "network" => &["onnx", "hidden"],
        "lam" | "lambda" => &["gae_lambda"],
        "discount" => &["gamma"],
        "max_speed" | "speeds" => &["speed"],
        "velocity" | "v_ego" | "car_speed" => &["speed", "ego_speed"],
        "speed" | "initial_speed" => &["ego_speed"],
        "pedestrian_speed" | "walker_speed" => &["walking_speed", "speed"],
        "impact_speed" | "collision_speed" | "closing_speed" => &["v_c"],
        "ttc" | "time_to_collision" => &["min_ttc"],
        "dt" | "timestep" | "delta" | "fps" => &["tick"],
        "max_steps" | "max_ticks" | "steps" => &["ticks", "budget"],
        "duration" | "timeout" | "time_limit" | "max_time" | "horizon" | "time" => &["ticks", "budget", "elapsed"],
        "weather" | "rain" | "wet" | "mu" => &["friction"],
        "angle" => &["bearing"],
        "radius" | "range" | "dist" => &["distance"],
        "float" | "double" | "real" | "f64" => &["number"],
        "int" | "uint" | "i64" => &["integer"],
        "bool" => &["boolean"],
        "string" | "str" => &["text"],
        "collision" | "crash" | "collide" => &["hit"],
        "end" | "done" | "finish" => &["timeout"],
        "always" | "every_step" => &["step"],
        "avoidable" => &["preventable"],
        "attributable" | "at_fault" | "blame" => &["fault"],
        "policy" | "drivers" | "agents" => &["policies"],
        "driver" | "agent" => &["policy"],
        "ego" | "car" => &["vehicle"],
        "pedestrian" | "walker" => &["adversary"],
        "pedestrians" | "walkers" | "methods" | "searches" => &["falsifiers"],
        "search" | "searcher" | "method" | "attacker" => &["falsifier"],
        "scenario" | "experiment" | "test" => &["campaign"],
        "map" => &["town", "file"],
        "world" => &["town"],
        "maps" | "worlds" => &["towns"],
        "xodr" | "opendrive" => &["file"],
        "road" | "roads" | "streets" => &["street"],
        "house" | "houses" | "buildings" => &["building"],
        "program" | "cmd" | "script" | "executable" | "run" => &["command"],
        "python" | "process" | "subprocess" | "custom" => &["external"],
        "file" | "path" | "weights" => &["model", "command", "file"],
        "seeds" | "repeats" | "repetitions" | "trials" => &["runs"],
        "n_episodes" | "num_episodes" | "n_eval_episodes" => &["episodes"],
        "headway" => &["time_headway"],
        "reaction" | "reaction_time" => &["reaction_allowance"],
        "delay" => &["actuation_delay"],
        "emergency_brake" | "brake_guard" | "guard" => &["aeb"],
        "Range" | "Uniform" | "between" | "random" => &["uniform"],
        "Normal" | "Gaussian" | "gaussian" => &["normal"],
        "Options" | "Choice" | "uniform_choice" | "one_of" => &["choice"],
        "Discrete" => &["weighted"],
        "maximum" => &["max"],
        "minimum" => &["min"],
        "True" | "yes" | "TRUE" | "on" => &["true"],
        "False" | "no" | "FALSE" | "off" => &["false"],
        _ => &[],
    }
}

/// The kind and its key for a file that is written in place of a kind: `town t = "my.xodr"`.
pub(super) fn kind_of_file(path: &str) -> Option<String> {
    let (_, ending) = path.rsplit_once('.')?;
    match ending {
        "xodr" | "xml" | "net" => Some(format!("opendrive(file: \"{path}\")")),
        "onnx" => Some(format!("onnx(model: \"{path}\")")),
        "py" => Some(format!("external(command: \"python3 {path}\")")),
        _ => None,
    }
}

/// Words for the number of pedestrians, which every episode has one of.
pub(super) fn counts_pedestrians(word: &str) -> bool {
    matches!(word, "pedestrians" | "pedestrian" | "walkers" | "people" | "count" | "num_pedestrians" | "n_pedestrians")
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
