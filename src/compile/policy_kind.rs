use std::sync::Arc;

use crate::av::DrivingPolicy;
use crate::signature::{Arguments, Param, Signature, Type};

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

/// The signature of a kind with the key that every kind takes.
pub(super) fn with_sensors(mut signature: Signature) -> Signature {
    signature.params.push(Param::with_default(
        "sensors",
        Type::Reference("sensors"),
        "perfect",
        "What stands between the world and the driver; without any it knows of everybody exactly and at once.",
    ));
    signature
}
