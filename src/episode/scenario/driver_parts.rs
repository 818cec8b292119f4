use std::fmt;
use std::sync::Arc;

use world::av::{DrivingPolicy, Weakness};

/// Makes a fresh driving policy; every episode's environment owns one for each vehicle.
pub type PolicyMaker = Arc<dyn Fn() -> Box<dyn DrivingPolicy> + Send + Sync>;

/// What can be exchanged of a driver whose parts are known.
#[derive(Clone, Default)]
pub struct DriverParts {
    /// The driver with exact sensors that see through walls; `None` if its sensors are exact.
    pub exact_sensors: Option<PolicyMaker>,
    /// The driver whose sensors are exact in one respect, with the weakness that this takes away.
    pub sensors: Vec<(Weakness, PolicyMaker)>,
    /// The driver whose commands act at once; `None` if they do.
    pub prompt: Option<PolicyMaker>,
    pub settings: Vec<Setting>,
}

/// A quantity of a driver or of its sensors that can be varied.
#[derive(Clone)]
pub struct Setting {
    /// Its name, such as `margin` or `sensors.range`.
    pub name: String,
    /// Its unit of SI; empty for plain numbers.
    pub unit: &'static str,
    /// Its value in SI.
    pub value: f64,
    /// Between which values a repair of the driver is, its own included, in SI: never worse sensors, nor a faster car.
    pub bounds: (f64, f64),
    /// Makes drivers with another value.
    pub make: Arc<dyn Fn(f64) -> PolicyMaker + Send + Sync>,
}

impl fmt::Debug for DriverParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DriverParts").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl fmt::Debug for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} {}", self.name, self.value, self.unit)
    }
}
