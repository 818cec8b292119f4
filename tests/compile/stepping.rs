//! If `check` is silent, building and stepping cannot fail. Scenarios with odd values for any keys are compiled; those without
//! errors are built and stepped.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use base::signature::{Form, Param, Signature, Type};
use base::units::Dimension;
use compile::{Catalog, compile};
use episode::{Draw, ObservationSpec, Outcome, Scenario};
use proptest::prelude::*;

use crate::samples::samples;

/// The number of ticks of each scenario.
const TICKS: u32 = 20;

/// Declarations that accompany those under test.
const BESIDE: &str = "edition 1
import \"std/paper.scn\"
import \"std/sensors.scn\"
import village from \"std/towns.scn\"
town lane { street { through: [(0 m, 0 m), (200 m, 0 m)] } parked_car { at: (60 m, -9 m, 0 deg) } }
";

/// Formulas that a reward may pay.
const PAID: &[&str] = &[
    "1",
    "max(3, 1.5 * ego_speed in m/s)",
    "exp(-miss_distance / 5 m)",
    "distance / max(ego_speed * 1 s, 0.1 m)",
    "(facing in rad) * (turn in deg) - (bearing in rad)",
    "log_likelihood(pace, walking_speed, 1 m/s)",
    "sqrt(ahead * ahead + aside * aside in m^2)",
    "(elapsed in s) * (distance in km) * (distance in mm)",
];

/// Conditions on starts.
const REQUIRED: &[&str] = &[
    "ahead > 5 m",
    "[facing > 0 deg, aside < 3 m]",
    "ego_speed < 5 m/s or distance > 12 m",
    "abs(bearing) > 20 deg",
    "distance * distance > 2 * ahead * ahead",
];

/// One of these, chosen by any number.
fn pick<T>(all: &[T], number: u16) -> &T {
    &all[usize::from(number) % all.len()]
}

/// A number within bounds, often equal to a bound, in its usual unit.
fn number(dimension: Dimension, min: f64, max: f64, choice: u16) -> String {
    let mut offers = vec![min, max];
    offers.extend([0.0, 1e-9, 1e-3, 0.05, 0.5, 1.0, 2.0, 10.0, 40.0, 1e3, 1e6].map(|size: f64| size.clamp(min, max)));
    offers.extend([-1e-3, -1.0, -30.0].map(|size: f64| size.clamp(min, max)));
    offers.retain(|offer| offer.is_finite() && (*offer == 0.0 || offer.abs() >= 1e-9));
    let si = match dimension {
        Dimension::RATIO => "",
        Dimension::ANGLE => "rad",
        Dimension::TURN_RATE => "rad/s",
        other => other.usual_units()[0],
    };
    format!("{:?} {si}", pick(&offers, choice)).trim_end().to_string()
}

/// A value for a key; none for keys that name a declaration.
fn value(param: &Param, a: u16, b: u16) -> Option<String> {
    fn of(ty: &Type, a: u16, b: u16) -> Option<String> {
        Some(match ty {
            Type::Quantity { dimension, min, max } => number(*dimension, *min, *max, a),
            Type::Range { dimension, min, max } => {
                format!("{} .. {}", number(*dimension, *min, *max, a), number(*dimension, *min, *max, b))
            }
            Type::Distribution { dimension, min, max } => {
                let of = |choice| number(*dimension, *min, *max, choice);
                match a % 4 {
                    0 => of(b),
                    1 => format!("{} .. {}", of(b), of(b / 16)),
                    2 => format!("choice({}, {})", of(b), of(b / 16)),
                    _ => format!("truncated(normal({}, {}), {} .. {})", of(b), of(b / 16), of(b / 8), of(b / 4)),
                }
            }
            Type::Integer { min, max } | Type::Ticks { min, max } => {
                let offers = [*min, *max, 1, 2, 7, 1000].map(|size| size.clamp(*min, *max));
                pick(&offers, a).to_string()
            }
            Type::Boolean => a.is_multiple_of(2).to_string(),
            Type::Choice(_) | Type::Step(_) | Type::WordOrPoint(_) | Type::WordOrReference(..) => {
                format!("\"{}\"", pick(ty.words(), a))
            }
            Type::List(item) if matches!(**item, Type::Pose) => "[(50 m, -1.75 m, 0 deg)]".into(),
            Type::List(item) if matches!(**item, Type::Condition(_)) => (*pick(REQUIRED, a)).to_string(),
            Type::List(item) => format!("[{}]", of(item, a, b)?),
            Type::Formula(_) => (*pick(PAID, a)).to_string(),
            Type::Requirement(_) => (*pick(&["always(gap > 1 m)", "eventually(in_sight, [0 s, 1 s])"], a)).to_string(),
            Type::Condition(_) => (*pick(&["distance > 60 m", "elapsed > 0.4 s", "ahead < 0 m"], a)).to_string(),
            Type::Text | Type::Path | Type::Point | Type::Pose | Type::Reference(_) => return None,
        })
    }
    of(&param.ty, a, b)
}

/// A declaration of a form: of one of its kinds, with some of its keys.
fn declaration(form: &Form, name: &str, kind: u16, keys: &[(u16, u16, u16)]) -> String {
    // Kinds that need something outside the program, a straight lane or a path need more than values.
    let needy = |kind: &&Signature| {
        matches!(kind.name, "external" | "onnx" | "pufferdrive" | "crossing_test" | "along_test" | "given_path")
    };
    let kinds: Vec<&Signature> = form.kinds.iter().filter(|kind| !needy(kind)).collect();
    let (head, signature) = match &form.plain {
        Some(plain) if kinds.is_empty() || kind.is_multiple_of(4) => (format!("{} {name}", form.name), plain),
        _ => {
            let kind = pick(&kinds, kind);
            (format!("{} {name} = {}", form.name, kind.name), *kind)
        }
    };
    let mut text = format!("{head} {{\n");
    let mut given = Vec::new();
    for (key, a, b) in keys {
        let param = pick(&signature.params, *key);
        if let Some(value) = value(param, *a, *b).filter(|_| !given.contains(&param.name)) {
            given.push(param.name);
            let _ = writeln!(text, "  {}: {value}", param.name);
        }
    }
    text + "}\n"
}

/// Forms of which a scenario holds one declaration each, under their own names.
const UNDER_TEST: &[&str] = &["vehicle", "body", "spawn", "episode", "sensors", "driver"];

fn scenario(kinds: &[u16; 6], keys: &[(u16, u16, u16, u16)], paid: u16, town: bool) -> String {
    let catalog = Catalog::builtin();
    let mut text = BESIDE.to_string();
    for ((place, name), kind) in UNDER_TEST.iter().enumerate().zip(kinds) {
        let form = catalog.forms.iter().find(|form| form.name == *name).unwrap();
        let own = keys.iter().filter(|(of, ..)| usize::from(*of) % UNDER_TEST.len() == place);
        let own: Vec<_> = own.map(|(_, key, a, b)| (*key, *a, *b)).collect();
        let mut written = declaration(form, &format!("one_{name}"), *kind, &own);
        if *name == "driver" && kind.is_multiple_of(3) {
            written = written.replacen("{\n", "{\n  sensors: one_sensors\n", 1);
        }
        text.push_str(&written);
    }
    let formula = pick(PAID, paid);
    let _ = write!(
        text,
        "reward one_reward {{ on step => {formula}  on touch => {formula}  on timeout => {formula}  potential: {formula} }}
campaign c {{
  vehicle: one_vehicle  body: one_body  spawn: one_spawn  episode: one_episode  training: ppo_paper
  train {{ towns: [{}]  drivers: [one_driver]  rewards: [one_reward]  runs: 1 }}
}}
",
        if town { "lane" } else { "village" }
    );
    text
}

/// The scenario of a text, unless the text has errors.
fn compiled(text: &str) -> Option<Arc<Scenario>> {
    let read = |path: &Path| match path == Path::new("s.scn") {
        true => Ok(text.to_string()),
        false => Err(std::io::ErrorKind::NotFound.into()),
    };
    let compiled = compile(&["s.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    Some(Arc::clone(&compiled.plan?.campaigns[0].nth::<compile::Training>(0).scenario))
}

fn step(text: &str) {
    // The checks of a fuzzer on a text belong here, too.
    let laid_out =
        lang::format(Sources::default().add("", text), text).unwrap_or_else(|said| panic!("{said:?}\n{text}"));
    assert_eq!(lang::format(Sources::default().add("", &laid_out), &laid_out).as_ref(), Ok(&laid_out), "{text}");
    let Some(scenario) = compiled(text) else { return };
    let mut env = scenario.simulation();
    for episode in 0..2 {
        env.start(Draw::new(&Seed::root(1), episode));
        let mut commands = [env.scene().intercept(0)];
        if episode == 1 {
            env.scene().write_commands(&[0.3, 1.0], &mut commands);
        }
        env.decide(&commands);
        for _ in 0..TICKS {
            let step = env.tick();
            assert!(env.outcome().and_then(Outcome::fault).is_none());
            if let Some(step) = step {
                assert!(step.reward.is_finite(), "a reward of {}", step.reward);
                let mut state = [0.0; ObservationSpec::DIM];
                env.scene().write_state(&mut state);
                assert!(state.iter().all(|part| part.is_finite()), "a state of {state:?}");
                if env.outcome().is_some() {
                    break;
                }
                env.decide(&[env.scene().homing(0)]);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: samples(100, 400) as u32, max_shrink_iters: 400, ..ProptestConfig::default() })]
    #[test]
    fn what_is_checked_can_be_stepped(
        kinds in prop::array::uniform6(any::<u16>()),
        keys in prop::collection::vec((any::<u16>(), any::<u16>(), any::<u16>(), any::<u16>()), 0..12),
        paid in any::<u16>(),
        town in any::<bool>(),
    ) {
        let text = scenario(&kinds, &keys, paid, town);
        let result = std::panic::catch_unwind(|| step(&text));
        prop_assert!(result.is_ok(), "{}", text);
    }
}

#[test]
fn most_odd_scenarios_can_be_stepped() {
    // Otherwise the property above would prove little. The numbers are the same every time.
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as u16
    };
    let mut stepped = 0;
    for _ in 0..100 {
        let kinds = std::array::from_fn(|_| next());
        let keys: Vec<_> = (0..4).map(|_| (next(), next(), next(), next())).collect();
        stepped += u32::from(compiled(&scenario(&kinds, &keys, next(), next() % 2 == 0)).is_some());
    }
    assert!(stepped > 50, "{stepped} of 100");
}
