use std::sync::Arc;

use crate::av::behavior_agent::BehaviorAgent;
use crate::av::interfuser::InterFuser;
use crate::av::lav::Lav;
use crate::av::senses::{Sensing, SensorModel};
use crate::av::{Aeb, Cruise, DrivingPolicy, Idm, OracleBrake, Predictive, RssGuarded};
use crate::env::PolicyMaker;
use crate::signature::{Arguments, Form, Param, Signature, Type};

/// A kind of driving policy: what it takes, and how it is made.
pub struct PolicyKind {
    /// What it takes.
    pub signature: fn() -> Signature,
    /// Makes one from checked arguments.
    pub make: fn(&Arguments) -> Box<dyn DrivingPolicy>,
}

/// All kinds of driving policies; a new one is a line here.
pub fn kinds() -> Vec<PolicyKind> {
    vec![
        PolicyKind {
            signature: BehaviorAgent::signature,
            make: |arguments| Box::new(BehaviorAgent::from_arguments(arguments)),
        },
        PolicyKind { signature: Lav::signature, make: |arguments| Box::new(Lav::from_arguments(arguments)) },
        PolicyKind {
            signature: InterFuser::signature,
            make: |arguments| Box::new(InterFuser::from_arguments(arguments)),
        },
        PolicyKind { signature: Idm::signature, make: |arguments| Box::new(Idm::new(arguments)) },
        PolicyKind { signature: Cruise::signature, make: |arguments| Box::new(Cruise::new(arguments)) },
        PolicyKind { signature: Aeb::signature, make: |arguments| Box::new(Aeb::new(arguments)) },
        PolicyKind { signature: RssGuarded::signature, make: |arguments| Box::new(RssGuarded::new(arguments)) },
        PolicyKind { signature: Predictive::signature, make: |arguments| Box::new(Predictive::new(arguments)) },
        PolicyKind { signature: OracleBrake::signature, make: |arguments| Box::new(OracleBrake::new(arguments)) },
    ]
}

/// The form `policy`. Every kind takes `sensors` beside what its own signature says.
pub fn form(kinds: &[PolicyKind]) -> Form {
    let with_sensors = |kind: &PolicyKind| {
        let mut signature = (kind.signature)();
        signature.params.push(Param::with_default(
            "sensors",
            Type::Reference("sensors"),
            "perfect",
            "What stands between the world and the driver; without any it knows of everybody exactly and at once.",
        ));
        signature
    };
    Form {
        name: "policy",
        doc: "A driver under test.",
        plain: None,
        multiplies: false,
        kinds: kinds.iter().map(with_sensors).collect(),
    }
}

/// A maker of fresh drivers of this kind, behind these sensors.
pub fn lower(
    kinds: &[PolicyKind],
    kind: &str,
    arguments: &Arguments,
    sensors: Option<Arc<SensorModel>>,
) -> PolicyMaker {
    let found = kinds.iter().find(|candidate| (candidate.signature)().name == kind);
    let make = found.expect("checked: the kind is in the catalogue").make;
    let arguments = arguments.clone();
    match sensors {
        None => Arc::new(move || make(&arguments)),
        Some(model) => Arc::new(move || Box::new(Sensing::new(make(&arguments), model.clone()))),
    }
}
