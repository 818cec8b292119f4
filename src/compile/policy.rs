use std::sync::Arc;

use super::Catalog;
use super::lowering::Lowering;
use super::plan::Driver;
use super::policy_kind::{CommonKeys, FromArguments, PolicyKind};
use super::{outside, sensors};
use base::signature::{Form, Keys, Signature};
use lang::diagnostics;
use lang::hir::Declaration;
use ported::behavior_agent::BehaviorAgent;
use ported::interfuser::InterFuser;
use ported::lav::Lav;
use world::av::external::ExternalKeys;
use world::av::onnx::OnnxKeys;
use world::av::sensors::SensorWrapper;
use world::av::{ActuationDelay, Aeb, CarefulHuman, Cruise, CruiseKeys, Idm, OracleBrake, Predictive, RssGuarded};
use world::env::PolicyMaker;

/// All kinds of driving policies; a new one is a line here.
pub fn kinds() -> Vec<PolicyKind> {
    vec![
        PolicyKind::new(BehaviorAgent::from_keys),
        PolicyKind::new(Lav::from_keys),
        PolicyKind::new(InterFuser::from_keys),
        PolicyKind::new(Idm::new),
        PolicyKind::new(Cruise::new),
        PolicyKind::new(Aeb::new),
        PolicyKind::new(RssGuarded::new),
        PolicyKind::new(Predictive::new),
        PolicyKind::new(OracleBrake::new),
        PolicyKind::new(CarefulHuman::new),
        PolicyKind::outside::<ExternalKeys>(outside::external),
        PolicyKind::outside::<OnnxKeys>(outside::onnx),
    ]
}

/// The form `policy`. Every kind takes `sensors` and `actuation_delay` in addition to the keys of its own signature.
pub fn form() -> Form {
    Form::of_kinds("policy", "A driver under test.", Vec::new())
}

/// A maker of new drivers with their sensors and their delay; `None` after reporting what is wrong.
pub fn lower(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<PolicyMaker> {
    let make = from_arguments(declaration, lowering)?;
    let written = declaration.block.places.iter().find(|(key, _)| *key == "sensors");
    if let Some((_, span)) = written.filter(|_| declaration.kind == CruiseKeys::KIND) {
        lowering.said.push(diagnostics::sensors_without_effect(*span, declaration.kind));
    }
    Some(make(&declaration.block.arguments))
}

/// What makes drivers such as the declared one, with its sensors, of other arguments; `None` after reporting what is wrong.
pub fn from_arguments(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let make = driver(declaration, lowering)?;
    let CommonKeys { sensors, .. } = declaration.block.keys();
    let sensors = sensors.map(|sensors| lowering.program.get(sensors));
    let model = sensors.map(|sensors| Arc::new(sensors::lower(&sensors.block)));
    Some(Arc::new(move |arguments| {
        let mut make = make(arguments);
        let CommonKeys { actuation_delay, .. } = CommonKeys::read(arguments);
        if actuation_delay > 0.0 {
            let prompt = make;
            make = Arc::new(move || Box::new(ActuationDelay::new(prompt(), actuation_delay)));
        }
        let Some(model) = model.clone() else { return make };
        Arc::new(move || Box::new(SensorWrapper::new(make(), model.clone())))
    }))
}

/// The signature of a driver's kind.
pub fn signature<'a>(declaration: &Declaration, catalog: &'a Catalog) -> Option<&'a Signature> {
    let policies = catalog.forms.iter().filter(|form| form.name == declaration.form);
    policies.flat_map(|form| &form.kinds).find(|kind| kind.name == declaration.kind)
}

/// The description of a driver, for reports.
pub fn describe(declaration: &Declaration, lowering: &Lowering<'_>) -> Driver {
    let kind = signature(declaration, lowering.catalog);
    let arguments = &declaration.block.arguments;
    let CommonKeys { sensors, .. } = declaration.block.keys();
    let sensors = sensors.map(|sensors| lowering.program.get(sensors));
    Driver {
        name: declaration.name.clone(),
        kind: declaration.kind,
        settings: arguments
            .iter()
            .filter(|(key, _)| *key != "sensors")
            .map(|(key, value)| (key, value.clone()))
            .collect(),
        sensor_model: sensors.map(|sensors| sensors::lower(&sensors.block).into()),
        sensors: sensors.map(|sensors| sensors.name.clone()),
        surrogate: kind.map_or("", |kind| kind.surrogate),
    }
}

fn driver(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let found = lowering.catalog.policies.iter().find(|kind| kind.signature.name == declaration.kind);
    (found.expect("checked: the kind is in the catalogue").lower)(declaration, lowering)
}
