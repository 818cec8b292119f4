use std::sync::Arc;

use super::lowering::Lowering;
use super::policy_kind::{CommonKeys, FromArguments, assembled};
use base::signature::{Arguments, Keys, Signature, Type, Value};
use base::units::Dimension;
use episode::{DriverParts, PolicyMaker, Setting};
use lang::hir::Declaration;
use world::av::Weakness;
use world::av::sensors::{SensorKeys, SensorModel};

/// Keys of drivers and of sensors of which more is a repair: earlier, harder, slower, farther.
const MORE: &str = "ahead aside behind full full_brake horizon least_gap margin memory partial partial_brake range reaction_allowance time_headway \
                    update_rate warning";
/// Those of which less is one.
const LESS: &str = "acceleration actuation_delay comfortable_braking confusion evaluation false_alarms heading_noise latency lateral_acceleration \
                    least_visible limit_share miss_far miss_near position_noise ramp size_noise speed_pull velocity_noise";
/// Either may be: `idm` brakes earlier with less of it, and `predictive` harder with more.
const EITHER: &str = "max_deceleration";

/// What can be exchanged of a declared driver, which `make` makes of arguments without its delay and its sensors.
pub fn parts(
    declaration: &Declaration,
    lowering: &Lowering<'_>,
    make: FromArguments,
    model: Option<&SensorModel>,
) -> DriverParts {
    let own = &declaration.block.arguments;
    let make = move |arguments: &Arguments, model: Option<SensorModel>| {
        assembled(make(arguments), arguments, model.map(Arc::new))
    };
    let CommonKeys { sensors, actuation_delay } = declaration.block.keys();
    let is_late = actuation_delay > 0.0 || model.is_some_and(|model| model.keys.latency > 0.0);
    let at_once = || {
        let mut arguments = own.clone();
        arguments.replace("actuation_delay", Value::Number(0.0));
        make(&arguments, model.map(|model| exact(model, Weakness::Delay)))
    };
    let respects =
        [Weakness::BlindSide, Weakness::Range, Weakness::Delay, Weakness::Dropouts, Weakness::Hidden, Weakness::Errors];
    let inexact = |weakness: Weakness| {
        let exact = model.map(|model| exact(model, weakness)).filter(|exact| Some(exact) != model)?;
        Some((weakness, make(own, Some(exact))))
    };
    let inexact: Vec<_> = respects.into_iter().filter_map(inexact).collect();
    let mut settings = Vec::new();
    if let Some(signature) = lowering.catalog.signature_of(declaration) {
        let (make, model, own) = (make.clone(), model.cloned(), own.clone());
        let maker: MakeOf = Arc::new(move |changed| make(changed, model.clone()));
        settings.extend(quantities(signature, &own, "", &maker));
    }
    if let (Some(sensors), Some(model), false) = (sensors, model, inexact.is_empty()) {
        let (make, model, own) = (make.clone(), model.clone(), own.clone());
        let maker: MakeOf =
            Arc::new(move |changed| make(&own, Some(SensorModel { keys: SensorKeys::read(changed), ..model.clone() })));
        let arguments = &lowering.program.get(sensors).block.arguments;
        settings.extend(quantities(&SensorKeys::signature(), arguments, "sensors.", &maker));
    }
    DriverParts {
        exact_sensors: (!inexact.is_empty()).then(|| make(own, None)),
        sensors: inexact,
        prompt: is_late.then(at_once),
        settings,
    }
}

/// Makes drivers of the changed arguments of a driver, or of its sensors.
type MakeOf = Arc<dyn Fn(&Arguments) -> PolicyMaker + Send + Sync>;

/// The quantities among arguments that a repair may change, within the values that are better.
fn quantities(signature: &Signature, own: &Arguments, prefix: &str, maker: &MakeOf) -> Vec<Setting> {
    let setting = |param: &base::signature::Param| {
        let Type::Quantity { dimension, mut min, mut max } = param.ty else { return None };
        let Value::Number(value) = own.value(param.name) else { return None };
        // Of the other keys, such as the place of the eye or the time for which an error lasts, no value is a repair.
        let is_in = |keys: &str| keys.split(' ').any(|key| key == param.name);
        match () {
            () if is_in(MORE) => min = *value,
            () if is_in(LESS) => max = *value,
            () if is_in(EITHER) => {}
            () => return None,
        }
        for [low, high] in &signature.rising {
            if let (true, Value::Number(high)) = (*low == param.name, own.value(high)) {
                max = max.min(*high);
            }
            if let (true, Value::Number(low)) = (*high == param.name, own.value(low)) {
                min = min.max(*low);
            }
        }
        let (name, own, maker) = (param.name, own.clone(), maker.clone());
        (min < max).then(|| Setting {
            name: format!("{prefix}{name}"),
            unit: unit(Some(dimension)),
            value: *value,
            bounds: (min, max),
            make: Arc::new(move |value| {
                let mut arguments = own.clone();
                arguments.replace(name, Value::Number(value));
                maker(&arguments)
            }),
        })
    };
    signature.params.iter().filter_map(setting).collect()
}

fn exact(model: &SensorModel, respect: Weakness) -> SensorModel {
    let mut model = model.clone();
    let keys = &mut model.keys;
    match respect {
        Weakness::BlindSide => {
            model.sectors.clear();
            model.seams.clear();
        }
        Weakness::Range => {
            (keys.ahead, keys.behind, keys.aside, keys.range) = (None, None, None, None);
            model.sectors.iter_mut().for_each(|sector| sector.range = None);
        }
        Weakness::Delay => (keys.latency, keys.update_rate) = (0.0, None),
        Weakness::Dropouts => {
            (keys.miss_near, keys.miss_far) = (0.0, 0.0);
            model.seams.clear();
        }
        Weakness::Hidden => keys.least_visible = 0.0,
        _ => {
            (keys.position_noise, keys.velocity_noise, keys.heading_noise, keys.size_noise) = (0.0, 0.0, 0.0, 0.0);
            (keys.confusion, keys.false_alarms, keys.speed_pull) = (0.0, 0.0, 0.0);
        }
    }
    model
}

/// The unit of SI of a dimension, as a file writes it.
pub(crate) fn unit(dimension: Option<Dimension>) -> &'static str {
    match dimension {
        Some(Dimension::ANGLE) => "rad",
        Some(Dimension::TURN_RATE) => "rad/s",
        other => other.and_then(|dimension| dimension.usual_units().first().copied()).unwrap_or(""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_quantity_of_a_driver_or_of_sensors_has_a_direction_or_is_no_repair() {
        let kinds = crate::policy::kinds().into_iter().map(|kind| kind.signature);
        let all =
            kinds.chain([SensorKeys::signature(), CommonKeys::signature()]).flat_map(|signature| signature.params);
        let quantity = |param: &base::signature::Param| matches!(param.ty, Type::Quantity { .. });
        let all: BTreeSet<&str> = all.filter(quantity).map(|param| param.name).collect();
        let directed: Vec<&str> = [MORE, LESS, EITHER].iter().flat_map(|keys| keys.split(' ')).collect();
        let known: BTreeSet<&str> = directed.iter().copied().collect();
        assert_eq!(known.len(), directed.len(), "a key has one direction");
        let none: Vec<&str> = all.difference(&known).copied().collect();
        let no_repair = "confused_length confused_width confusion_correlation eye false_alarm_length far miss_correlation near noise_correlation \
                         start_timeout timeout walking_speed";
        assert_eq!((none, known.difference(&all).next()), (no_repair.split(' ').collect(), None));
    }
}
