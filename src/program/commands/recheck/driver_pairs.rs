use std::str::FromStr;
use std::sync::Arc;

use crate::session::{Error, named};
use compile::{Campaign, Evaluation, HERE, Search};
use episode::{ExternalWorld, Scenario, VehicleRole};
use results::report::RecheckNote;

/// A driver of an old report and its new version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DriverPair {
    /// The name of the old one.
    pub before: String,
    pub after: String,
}

impl FromStr for DriverPair {
    type Err = String;

    /// Reads `OLD=NEW`, or `NAME` for a driver that has kept its name.
    fn from_str(text: &str) -> Result<Self, String> {
        let (before, after) = text.split_once('=').unwrap_or((text, text));
        let before = before.trim().to_owned();
        let after = after.trim().to_owned();
        if before.is_empty() || after.is_empty() {
            return Err("write OLD=NEW, or NAME for a driver that has kept its name".into());
        }
        Ok(Self { before, after })
    }
}

/// A driver in a scenario of a campaign.
pub(super) struct Place<'a> {
    pub policy: &'a str,
    pub town: &'a str,
    /// The vehicle; `None` in a search.
    vehicle: Option<&'a str>,
    /// The simulator.
    pub world: &'a str,
    pub scenario: &'a Arc<Scenario>,
}

pub(super) fn places(campaign: &Campaign) -> impl Iterator<Item = Place<'_>> {
    let evaluations = campaign.all::<Evaluation>().map(|evaluation| Place {
        policy: &evaluation.policy,
        town: &evaluation.town,
        vehicle: Some(&evaluation.vehicle),
        world: &evaluation.world,
        scenario: &evaluation.scenario,
    });
    let searches = campaign.all::<Search>().map(|search| Place {
        policy: &search.key.policy,
        town: &search.key.town,
        vehicle: None,
        world: HERE,
        scenario: &search.scenario,
    });
    evaluations.chain(searches)
}

/// The drivers that are evaluated or searched in campaigns, each once.
fn drivers(campaigns: &[Campaign]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for place in campaigns.iter().flat_map(places) {
        if names.iter().all(|name| name != place.policy) {
            names.push(place.policy.to_owned());
        }
    }
    names
}

/// The pairs that are rechecked: those given, or else drivers of equal names, or else the only driver of each side. Drivers without a
/// partner are notes.
pub(super) fn driver_pairs(
    old: &Campaign,
    new: &[Campaign],
    given: &[DriverPair],
) -> Result<(Vec<DriverPair>, Vec<RecheckNote>), Error> {
    let before = drivers(std::slice::from_ref(old));
    let after = drivers(new);
    for pair in given {
        let sides = [(&pair.before, "the runs of the report", &before), (&pair.after, "the new campaigns", &after)];
        if let Some((driver, place, known)) = sides.into_iter().find(|(driver, _, known)| !known.contains(driver)) {
            return Err(Error::Usage(format!("{place} have no driver `{driver}`; they have {}", named(known))));
        }
    }
    if !given.is_empty() {
        return Ok((given.to_vec(), Vec::new()));
    }
    if let ([before], [after]) = (before.as_slice(), after.as_slice()) {
        return Ok((vec![DriverPair { before: before.clone(), after: after.clone() }], Vec::new()));
    }
    let (shared, alone): (Vec<String>, Vec<String>) = before.iter().cloned().partition(|name| after.contains(name));
    if shared.is_empty() {
        return Err(Error::Usage(format!(
            "no driver of the report is among the new ones: the report has {}, the new files have {}; `--driver OLD=NEW` pairs drivers of different names",
            named(&before),
            named(&after)
        )));
    }
    let pairs = shared.into_iter().map(|name| DriverPair { before: name.clone(), after: name });
    Ok((pairs.collect(), alone.into_iter().map(|driver| RecheckNote::NoPartner { driver }).collect()))
}

/// The car and the driver of this name, in the scenario that is most like a town and a vehicle.
pub(super) fn new_role<'a>(
    campaigns: &'a [Campaign],
    policy: &str,
    town: &str,
    vehicle: Option<&str>,
) -> Option<&'a VehicleRole> {
    let of_driver = campaigns.iter().flat_map(places).filter(|place| place.policy == policy);
    let unlike = |place: &Place<'_>| (place.town != town, place.vehicle != vehicle);
    of_driver.min_by_key(unlike).map(|place| place.scenario.cast.ego())
}

/// A car with its driver, and the other simulator in which it drives; `None` if that is the simulator of the old scenario.
#[derive(Clone, Copy)]
pub(super) struct NewDriver<'a> {
    pub role: &'a VehicleRole,
    pub world: Option<&'a Arc<ExternalWorld>>,
}

/// The old scenario with the car and the driver of another. The grip of the road stays.
pub(super) fn with_driver(scenario: &Arc<Scenario>, NewDriver { role, world }: NewDriver<'_>) -> Arc<Scenario> {
    let mut scenario = Scenario::clone(scenario);
    let grip = scenario.cast.ego().blueprint.grip;
    scenario.cast.vehicles[0] = role.clone();
    scenario.cast.vehicles[0].blueprint.grip = grip;
    scenario.external_world = world.cloned().or(scenario.external_world);
    Arc::new(scenario)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_two_names_or_one() {
        let pair = |before: &str, after: &str| Ok(DriverPair { before: before.into(), after: after.into() });
        assert_eq!("v1=v2".parse(), pair("v1", "v2"));
        assert_eq!(" mine ".parse(), pair("mine", "mine"));
        for wrong in ["", "=", "a=", "=b"] {
            assert!(wrong.parse::<DriverPair>().is_err(), "{wrong}");
        }
    }
}
