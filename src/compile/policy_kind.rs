use std::sync::Arc;

use base::signature::{Arguments, Param, Signature, Type};
use base::units::Dimension;
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
    /// A kind with this signature. `make` is called once for each driver that is needed, from any thread; it gets a value for each key of the
    /// signature.
    pub fn new<P: DrivingPolicy + 'static>(
        signature: Signature,
        make: impl Fn(&Arguments) -> P + Send + Sync + 'static,
    ) -> Self {
        Self { signature, make: Arc::new(move |arguments| Box::new(make(arguments))) }
    }
}

/// The signature of a kind with the keys that every kind takes.
pub(super) fn with_common_keys(mut signature: Signature) -> Signature {
    signature.params.push(Param::with_default(
        "sensors",
        Type::Reference("sensors"),
        "perfect",
        "What the driver perceives of other actors, and how late (`latency`); without any it knows of all exactly and at once.",
    ));
    signature.params.push(Param::with_default(
        "actuation_delay",
        Type::Quantity { dimension: Dimension::TIME, min: 0.0, max: 10.0 },
        "0 s",
        "Time from a command of the driver until pedals and wheel follow it, in whole ticks.",
    ));
    signature
}
