use std::sync::Arc;

use super::lowering::{Lowering, MadeDriver};
use super::plan::Driver;
use super::policy_kind::{CommonKeys, FromArguments, Maker, PolicyKind, Sight, assembled};
use super::{driver_parts, outside, sensors};
use base::diagnostic::{Sources, Span};
use base::signature::{Form, Keys, Signature, Type, Value, short};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use ported::behavior_agent::BehaviorAgent;
use ported::interfuser::InterFuser;
use ported::lav::Lav;
use ported::pufferdrive::PufferDriveKeys;
use world::av::external::ExternalKeys;
use world::av::onnx::OnnxKeys;
use world::av::sensors::{SensorKeys, SensorModel};
use world::av::{Aeb, CarefulHuman, Cruise, Idm, Native, OracleBrake, Predictive, RssGuarded};

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
        PolicyKind::of::<ExternalKeys>(Maker::Program),
        PolicyKind::of::<OnnxKeys>(Maker::Network),
        PolicyKind::of::<PufferDriveKeys>(Maker::PufferDrive).with_sight(Sight::ThroughWalls),
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

/// The description of a driver, for reports.
pub fn describe(declaration: &Declaration, lowering: &Lowering<'_>) -> Driver {
    let kind = lowering.catalog.signature_of(declaration);
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
    match &kind(declaration, lowering).maker {
        Maker::Here(make) => Some(make.clone()),
        Maker::Program => outside::external(declaration, lowering),
        Maker::Network => outside::onnx(declaration, lowering),
        Maker::PufferDrive => outside::pufferdrive(declaration, lowering),
    }
}
