use std::sync::Arc;

use base::keys;
use base::signature::{Arguments, DeclarationId, Keys, Signature};
use episode::PolicyMaker;
use world::av::sensors::{SensorModel, SensorWrapper};
use world::av::{ActuationDelay, DrivingPolicy};

/// What a kind of driver knows of other actors, unless its sensors say otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Nothing: sensors have no effect.
    Blind,
    /// Where those are that nothing hides.
    Clear,
    /// Where all are, also behind obstacles.
    ThroughWalls,
}

/// A kind of driver: the keys that it takes, and how one is made.
#[derive(Clone)]
pub struct PolicyKind {
    /// Its name, its keys and its documentation.
    pub signature: Signature,
    /// What its drivers know of other actors.
    pub sight: Sight,
    pub(super) maker: Maker,
}

/// What makes the drivers of a kind.
#[derive(Clone)]
pub(super) enum Maker {
    /// A function of their arguments.
    Here(FromArguments),
    /// A program of the user.
    Program,
    /// A network in a file.
    Network,
    /// PufferDrive's network, with weights from a file.
    PufferDrive,
}

/// From arguments of a kind to what makes new drivers.
pub(super) type FromArguments = Arc<dyn Fn(&Arguments) -> PolicyMaker + Send + Sync>;

impl PolicyKind {
    /// A kind with these keys. `make` is called once for each driver that is needed, from any thread.
    pub fn new<K: Keys + 'static, P: DrivingPolicy + 'static>(make: impl Fn(K) -> P + Send + Sync + 'static) -> Self {
        let make = Arc::new(make);
        Self::of::<K>(Maker::Here(Arc::new(move |arguments| {
            let (arguments, make) = (arguments.clone(), make.clone());
            Arc::new(move || Box::new(make(K::read(&arguments))))
        })))
    }

    /// A kind with these keys.
    pub(super) fn of<K: Keys>(maker: Maker) -> Self {
        Self { signature: K::signature(), sight: Sight::Clear, maker }
    }

    /// The same, with drivers that know this of other actors; without it, where those are that nothing hides.
    #[must_use]
    pub fn with_sight(self, sight: Sight) -> Self {
        Self { sight, ..self }
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

/// A driver with the delay of its arguments and behind sensors.
pub(super) fn assembled(mut make: PolicyMaker, arguments: &Arguments, model: Option<Arc<SensorModel>>) -> PolicyMaker {
    let CommonKeys { actuation_delay, .. } = CommonKeys::read(arguments);
    if actuation_delay > 0.0 {
        let prompt = make;
        make = Arc::new(move || Box::new(ActuationDelay::new(prompt(), actuation_delay)));
    }
    let Some(model) = model else { return make };
    Arc::new(move || Box::new(SensorWrapper::new(make(), model.clone())))
}
