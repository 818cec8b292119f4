use std::sync::Arc;

use super::lowering::{Lowering, MadeDriver};
use super::plan::Driver;
use super::policy_kind::{CommonKeys, FromArguments, PolicyKind, Sight};
use super::{Catalog, driver_parts, outside, sensors};
use base::diagnostic::{Sources, Span};
use base::signature::{Arguments, Form, Keys, Signature, Type, Value, short};
use episode::PolicyMaker;
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use ported::behavior_agent::BehaviorAgent;
use ported::interfuser::InterFuser;
use ported::lav::Lav;
use ported::pufferdrive::PufferDriveKeys;
use world::av::external::ExternalKeys;
use world::av::onnx::OnnxKeys;
use world::av::sensors::{SensorKeys, SensorModel, SensorWrapper};
use world::av::{ActuationDelay, Aeb, CarefulHuman, Cruise, Idm, Native, OracleBrake, Predictive, RssGuarded};

/// All kinds of drivers; a new one is a line here.
pub fn kinds() -> Vec<PolicyKind> {
    vec![
        PolicyKind::new(BehaviorAgent::from_keys).with_sight(Sight::ThroughWalls),
        PolicyKind::new(Lav::from_keys),
        PolicyKind::new(InterFuser::from_keys).with_sight(Sight::ThroughWalls),
        PolicyKind::new(Idm::new),
        PolicyKind::new(Cruise::new).with_sight(Sight::Blind),
        PolicyKind::new(Aeb::new).with_sight(Sight::ThroughWalls),
        PolicyKind::new(RssGuarded::new).with_sight(Sight::ThroughWalls),
        PolicyKind::new(Predictive::new).with_sight(Sight::ThroughWalls),
        PolicyKind::new(OracleBrake::new),
        PolicyKind::new(CarefulHuman::new),
        PolicyKind::new(Native::new).with_sight(Sight::Blind),
        PolicyKind::outside::<ExternalKeys>(outside::external),
        PolicyKind::outside::<OnnxKeys>(outside::onnx),
        PolicyKind::outside::<PufferDriveKeys>(outside::pufferdrive).with_sight(Sight::ThroughWalls),
    ]
}

/// The form `driver`. Every kind takes `sensors` and `actuation_delay` in addition to the keys of its own signature.
pub fn form() -> Form {
    Form::of_kinds("driver", "A driver under test.", Vec::new())
}

/// A driver with its sensors and its delay, and what can be exchanged of it; `None` after reporting what is wrong.
pub fn lower(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<MadeDriver> {
    let make = driver(declaration, lowering)?;
    let model = sensor_model(declaration, lowering);
    let written = declaration.block.places.iter().find(|(key, _)| *key == "sensors");
    if let Some((_, span)) = written.filter(|_| kind(declaration, lowering).sight == Sight::Blind) {
        lowering.said.push(diagnostics::sensors_without_effect(*span, declaration.kind));
    }
    let arguments = &declaration.block.arguments;
    let policy = assembled(make(arguments), arguments, model.clone());
    let parts = Arc::new(driver_parts::parts(declaration, lowering, make, model.as_deref()));
    Some(MadeDriver { policy, parts })
}

/// What makes drivers such as the declared one, with its sensors, of other arguments; `None` after reporting what is wrong.
pub fn from_arguments(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    let make = driver(declaration, lowering)?;
    let model = sensor_model(declaration, lowering);
    Some(Arc::new(move |arguments| assembled(make(arguments), arguments, model.clone())))
}

fn sensor_model(declaration: &Declaration, lowering: &Lowering<'_>) -> Option<Arc<SensorModel>> {
    let CommonKeys { sensors, .. } = declaration.block.keys();
    sensors.map(|sensors| Arc::new(sensors::lower(&lowering.program.get(sensors).block)))
}

/// Whether a driver sees actors behind obstacles.
pub fn sees_through(declaration: &Declaration, lowering: &Lowering<'_>) -> bool {
    kind(declaration, lowering).sight == Sight::ThroughWalls
        && sensor_model(declaration, lowering).is_none_or(|model| !model.looks())
}

/// A driver with the delay of its arguments and behind sensors.
pub(crate) fn assembled(mut make: PolicyMaker, arguments: &Arguments, model: Option<Arc<SensorModel>>) -> PolicyMaker {
    let CommonKeys { actuation_delay, .. } = CommonKeys::read(arguments);
    if actuation_delay > 0.0 {
        let prompt = make;
        make = Arc::new(move || Box::new(ActuationDelay::new(prompt(), actuation_delay)));
    }
    let Some(model) = model else { return make };
    Arc::new(move || Box::new(SensorWrapper::new(make(), model.clone())))
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
    let mut changed = kind.map_or(Vec::new(), |kind| changed(kind, &declaration.block, "", lowering.sources));
    let of_sensors =
        sensors.map(|sensors| self::changed(&SensorKeys::signature(), &sensors.block, "sensors.", lowering.sources));
    changed.extend(of_sensors.into_iter().flatten());
    Driver {
        changed,
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

/// The keys of a block, and of those inside, that differ from their defaults, except `sensors`.
fn changed(signature: &Signature, block: &Block, prefix: &str, sources: &Sources) -> Vec<String> {
    let written = |(key, span): &(&'static str, Span)| {
        let param = signature.params.iter().find(|param| param.name == *key)?;
        let text = match (&param.ty, block.arguments.value(key)) {
            (Type::Quantity { dimension, .. }, Value::Number(number)) => {
                format!("{} {}", short(*number), driver_parts::unit(Some(*dimension)))
            }
            _ => sources.plain_text(*span),
        };
        (param.default != Some(text.trim())).then(|| format!("{prefix}{key}: {}", text.trim()))
    };
    let own = block.places.iter().filter(|(key, _)| *key != "sensors").filter_map(written);
    let inside = block.children.iter().flat_map(|child| {
        let known = signature.children.iter().find(|known| known.name == child.word);
        known.map_or(Vec::new(), |known| changed(known, child, &format!("{prefix}{}.", child.word), sources))
    });
    own.chain(inside).collect()
}

fn kind<'a>(declaration: &Declaration, lowering: &Lowering<'a>) -> &'a PolicyKind {
    let found = lowering.catalog.policies.iter().find(|kind| kind.signature.name == declaration.kind);
    found.expect("checked: the kind is in the catalogue")
}

fn driver(declaration: &Declaration, lowering: &mut Lowering<'_>) -> Option<FromArguments> {
    (kind(declaration, lowering).lower)(declaration, lowering)
}
