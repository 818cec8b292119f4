//! Kinds with their keys in place of names.

use std::path::Path;

use base::diagnostic::Sources;
use compile::{Campaign, Catalog, Plan, compile};

const SCENARIO: &str = r#"
edition 1
import late_oracle from "std/drivers.scn"
import "std/pedestrians.scn"
import "std/rewards.scn"
import "std/towns.scn"
spawn ahead {}
episode short { ticks: 200 }
param base: driver = idm(margin: 1 m)
campaign c {
  vehicle: generic(length: 4 m)  body: plausible  spawn: ahead  episode: short
  training: ppo(steps: 1000)
  train { towns: [harbour]  drivers: [idm(time_headway: 0.8 s)]  rewards: [fault]  runs: 1 }
  evaluate {
    towns: [harbour]  pedestrians: [random]  episodes: 5
    drivers: [
      idm( time_headway:  0.8 s ), idm(), late_oracle, base,
      idm(sensors: interfuser_suite(latency: 0.1 s), margin: 1 m, time_headway: 2.5 s, least_gap: 3 m)
    ]
  }
}
"#;

fn compiled(text: &str) -> Result<Plan, Vec<String>> {
    let read = |path: &Path| match path.to_str() {
        Some("c.scn") => Ok(text.to_string()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    let compiled = compile(&["c.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let said = || compiled.diagnostics.iter().map(|each| format!("{}: {}", each.code, each.message)).collect();
    compiled.plan.clone().ok_or_else(said)
}

#[test]
fn a_kind_in_place_of_a_name_is_a_declaration_with_a_derived_name() {
    let plan = compiled(SCENARIO).unwrap_or_else(|said| panic!("{said:?}"));
    let campaign = &plan.campaigns[0];
    assert_eq!(campaign.nth::<compile::Training>(0).config.steps, 1000);
    assert_eq!(campaign.nth::<compile::Training>(0).key.policy, "idm_time_headway_0_8_s");
    let policies: Vec<&str> = campaign.all::<compile::Evaluation>().map(|each| &*each.policy).collect();
    let [same, plain, named, of_param, long] = policies.as_slice() else { panic!("{policies:?}") };
    assert_eq!(
        (*same, *plain, *named, *of_param),
        ("idm_time_headway_0_8_s", "idm_380cd764", "late_oracle", "idm_margin_1_m"),
        "equal texts are one declaration"
    );
    assert!(long.starts_with("idm_") && long.len() == 12, "a long text has a digest: {long}");
    let sensors = &campaign.drivers.iter().find(|driver| driver.name == *long).unwrap().sensors;
    assert_eq!(sensors.as_deref(), Some("interfuser_suite_latency_0_1_s"));
    // The names do not depend on what else the file declares.
    let more = SCENARIO.replace("spawn ahead {}", "spawn ahead {}\ndriver first = idm(margin: 2 m)");
    let again = compiled(&more).unwrap_or_else(|said| panic!("{said:?}"));
    let names: Vec<String> =
        again.campaigns[0].all::<compile::Evaluation>().map(|each| each.policy.to_string()).collect();
    assert_eq!(names, policies);
}

#[test]
fn a_derived_name_never_means_two_things() {
    let text = SCENARIO
        .replace("spawn ahead {}", "spawn ahead {}\ndriver idm = aeb()")
        .replace("late_oracle, base", "idm, base");
    let plan = compiled(&text).unwrap_or_else(|said| panic!("{said:?}"));
    let kinds: Vec<_> = plan.campaigns[0].drivers.iter().map(|driver| (driver.name.as_str(), driver.kind)).collect();
    assert!(kinds.contains(&("idm", "aeb")), "{kinds:?}");
    let mut names: Vec<&str> = kinds.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), kinds.len());
}

#[test]
fn what_is_wrong_inside_is_reported_there() {
    for (from, to, expected) in [
        ("idm()", "idm(margn: 1 m)", "unknown-key"),
        ("idm()", "idm(margin: 1 s)", "wrong-unit"),
        ("idm()", "imd(margin: 1 m)", "unknown-kind"),
        ("ppo(steps: 1000)", "ppo(1000)", "bare-argument"),
        ("idm()", "ppo(steps: 10)", "wrong-type"),
    ] {
        let said = compiled(&SCENARIO.replace(from, to)).expect_err(to);
        assert_eq!(said.len(), 1, "{to}: {said:?}");
        assert!(said[0].starts_with(expected), "{to}: {said:?}");
    }
}

#[test]
fn a_matrix_takes_kinds_in_place_of_names() {
    let with = |values: &str| {
        let text = SCENARIO.replace("campaign c {", &format!("campaign c {{\n  matrix {{ base: {values} }}"));
        compiled(&text.replace("idm(), late_oracle, base", "base"))
    };
    let plan =
        with("[late_oracle, idm(margin: 2 m), idm(margin: 1 m), cruise()]").unwrap_or_else(|said| panic!("{said:?}"));
    let driver = |campaign: &Campaign| campaign.nth::<compile::Evaluation>(1).policy.to_string();
    let drivers: Vec<String> = plan.campaigns.iter().map(driver).collect();
    assert_eq!(drivers, ["late_oracle", "idm_margin_2_m", "idm_margin_1_m", "cruise"]);
    let names: Vec<&str> = plan.campaigns.iter().map(|campaign| campaign.name.as_str()).collect();
    assert_eq!(names, ["c-base=late_oracle", "c-base=idm_margin_2m_", "c-base=idm_margin_1m_", "c-base=cruise__"]);
    // Each is what it is under a name of its own.
    let own = compiled(&SCENARIO.replace("idm(margin: 1 m)", "cruise()")).unwrap_or_else(|said| panic!("{said:?}"));
    let alone = own.campaigns[0].all::<compile::Evaluation>().find(|each| &*each.policy == "cruise").unwrap();
    assert_eq!(plan.campaigns[3].nth::<compile::Evaluation>(1).origin.fingerprint, alone.origin.fingerprint);
    for (values, expected) in [
        ("[aeb(), idm(margn: 1 m)]", "unknown-key"),
        ("[aeb(), ppo(steps: 10)]", "wrong-type"),
        ("[aeb(), aeb( )]", "repeated"),
    ] {
        let said = with(values).expect_err(values);
        assert!(said.len() == 1 && said[0].contains(expected), "{values}: {said:?}");
    }
}
