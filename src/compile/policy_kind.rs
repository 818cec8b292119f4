use std::sync::Arc;

use base::keys;
use base::signature::{Arguments, DeclarationId, Keys, Signature};
use world::av::DrivingPolicy;

/// Makes a driving policy from checked arguments.
pub type MakePolicy = Arc<dyn Fn(&Arguments) -> Box<dyn DrivingPolicy> + Send + Sync>;

/// A kind of driving policy: the keys that it takes, and how one is made.
#[derive(Clone)]
pub struct PolicyKind {
    /// Its name, its keys and its documentation.
    pub signature: Signature,
    /// Makes one from checked arguments.
    pub make: MakePolicy,
}

impl PolicyKind {
    /// A kind with these keys. `make` is called once for each driver that is needed, from any thread.
    pub fn new<K: Keys, P: DrivingPolicy + 'static>(make: impl Fn(K) -> P + Send + Sync + 'static) -> Self {
        Self { signature: K::signature(), make: Arc::new(move |arguments| Box::new(make(K::read(arguments)))) }
    }
}

keys! {
    /// What every kind takes in addition to its own keys.
    pub struct CommonKeys {
        /// What the driver perceives of other actors, and how late (`latency`); without any it knows of all exactly and at
        /// once.
        sensors: Option<DeclarationId> as Reference("sensors") = "perfect",
        /// Time from a command of the driver until pedals and wheel follow it, in whole ticks.
        actuation_delay: f64 as within(TIME, 0.0, 10.0) = "0 s",
    }
}

/// The signature of a kind with the keys that every kind takes.
pub(super) fn with_common_keys(mut signature: Signature) -> Signature {
    signature.params.extend(CommonKeys::signature().params);
    signature
}
