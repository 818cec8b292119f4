//! A caller adds its own kind of driving policy to the catalogue. Scenarios name it as they name the built-in kinds.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex};

use base::diagnostic::Sources;
use base::keys;
use base::seed::{Seed, Stream};
use compile::{Catalog, Compiled, PolicyKind, TakenKind, compile};
use results::campaign::{InMemory, Silent, run};
use world::av::{DrivingMode, DrivingPolicy, Perception};
use world::sim::Control;

keys! {
    /// Brakes all the time.
    struct BrakingKeys = "braking" {
        /// Brake, 0 to 1.
        force: f64 as share() = "1",
    }
}

/// Always brakes with the same force.
struct Braking {
    force: f64,
}

impl DrivingPolicy for Braking {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {}

    fn drive(&mut self, _: &Perception<'_>) -> Control {
        Control { throttle: 0.0, brake: self.force, steer: 0.0 }
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::EmergencyStop
    }
}

/// The kind. It records the force of each driver that it makes, in percent.
fn kind(made: &Arc<Mutex<BTreeSet<i64>>>) -> PolicyKind {
    let made = made.clone();
    PolicyKind::new(move |BrakingKeys { force }| {
        made.lock().unwrap().insert((100.0 * force) as i64);
        Braking { force }
    })
}

fn compiled(catalog: &Catalog) -> Compiled {
    let text = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/sensors.scn"
import "lib/towns.scn"
policy firm = braking()
policy soft = braking(force: 0.25, sensors: perfect)
campaign braked {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour] policies: [firm, soft] pedestrians: [random] episodes: 20 }
}
"#;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/braked.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    compile(std::slice::from_ref(&root), catalog, &read, &mut Sources::default()).unwrap()
}

#[test]
fn a_policy_of_the_caller_is_checked_and_driven_like_the_others() {
    let made = Arc::default();
    let compiled = compiled(&Catalog::builtin().with_policy(kind(&made)).unwrap());
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let kept = InMemory::default();
    run(&plan.campaigns[0], &Seed::root(1), &kept, &Silent);
    let rows = kept.into_rows();
    for policy in ["firm", "soft"] {
        let driven: Vec<_> = rows.iter().filter(|row| row.key.cell.policy == *policy).collect();
        assert_eq!(driven.len(), 20, "{policy}");
        assert!(driven.iter().all(|row| row.outcome.last_mode == DrivingMode::EmergencyStop), "{policy}");
    }
    assert_eq!(*made.lock().unwrap(), [25, 100].into(), "the default and the value of the key reach the driver");
}

#[test]
fn a_kind_that_the_catalogue_lacks_is_an_error_and_so_is_one_that_it_has() {
    assert!(compiled(&Catalog::builtin()).plan.is_none());
    let made = Arc::default();
    let twice = Catalog::builtin().with_policy(kind(&made)).unwrap().with_policy(kind(&made));
    assert_eq!(twice.err(), Some(TakenKind { form: "policy", kind: "braking" }));
}
