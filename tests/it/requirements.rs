//! Requirements: the worked traces of the book, the signals of episodes against what else is known of these, and reports with requirements.

use std::ops::ControlFlow;
use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use base::signature::VariableId;
use compile::{Catalog, Plan, compile};
use episode::requirement::Trace;
use episode::{Draw, Outcome, Trace as EpisodeTrace};
use falsify::session::{FailuresArgs, Input, RepeatOptions, Repeated, ReplayOptions, RunOptions, Session};
use results::campaign::{self, NoStore, Silent};
use results::jobs::{Repeatable, watch};
use results::report::{
    CountedEvent, Failures, Gate, Judged as Judgement, Side, StoredReport, all_of_searches, compare_reports,
    compared_cells, comparison_reference, driver_results, narrative, requirements_in,
};
use results::tables::metrics::COLLISION_RATE;
use verdict::{Blame, Judged, LaneDeparture, NearMiss, NoVerdict, judge};
use world::sim::WalkCommand;

/// The plan of a campaign in the harbour with these requirements.
fn plan(declared: &str, names: &str, policies: &str) -> Plan {
    let text = format!(
        "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         import \"std/requirements.scn\"\n{declared}\n\
         spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }}\n\
         episode until_passed {{ ticks: 240  hold: 10  end_when: ahead < -6 m }}\n\
         campaign mine {{\n  vehicle: model3  body: plausible  spawn: near  episode: until_passed\n  requirements: [{names}]\n\
         evaluate {{ towns: [harbour]  drivers: [{policies}]  pedestrians: [intercept]  episodes: 400 }}\n}}\n"
    );
    let read = |path: &Path| if path == Path::new("my.scn") { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(&["my.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{text}\n{:?}", compiled.diagnostics))
}

#[test]
fn the_worked_traces_of_the_book_are_true() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/reference/requirements.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, table) = page.split_once("## Worked traces").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let variables = Catalog::builtin().vocabulary.variables;
    let x = VariableId(variables.iter().position(|variable| variable.name == "ahead").unwrap());
    let mut lines = 0;
    for line in table.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [formula, samples, robustness, decided] = cells[..] else { panic!("{line}") };
        let formula = formula.trim_matches('`').replace('x', "ahead");
        let plan = plan(&format!("requirement worked = {formula}"), "worked", "idm");
        let requirement = &plan.campaigns[0].requirements[0].requirement;
        let mut trace = Trace::new(requirement, 8, &|_| false);
        for sample in samples.split(", ") {
            let value: f64 = sample.parse().unwrap();
            trace.push(requirement, &|id| if id == x { value } else { f64::NAN });
        }
        let found = trace.degree(requirement, 1.0);
        let wanted = match robustness.replace('−', "-").replace('∞', "inf").parse::<f64>() {
            Ok(wanted) => wanted,
            Err(error) => panic!("{line}: {error}"),
        };
        assert_eq!(found.robustness.to_bits(), wanted.to_bits(), "{line}: {found:?}");
        assert_eq!(found.sample.to_string(), decided, "{line}");
        lines += 1;
    }
    assert!(lines > 12, "{lines}");
}

/// What stands before an `implies` inside another must hold together with that; a part without `implies` always says something.
#[test]
fn a_requirement_applies_where_one_of_its_parts_says_something() {
    let variables = Catalog::builtin().vocabulary.variables;
    let x = VariableId(variables.iter().position(|variable| variable.name == "ahead").unwrap());
    for (formula, samples, applies) in [
        ("always(ahead > 5 m implies ahead < 9 m)", [6.0, 1.0], true),
        ("always(ahead > 5 m implies ahead < 9 m)", [1.0, 2.0], false),
        ("always(ahead > 5 m implies ahead > 7 m implies ahead < 9 m)", [6.0, 1.0], false),
        ("always(ahead > 5 m implies ahead > 7 m implies ahead < 9 m)", [6.0, 8.0], true),
        ("always(ahead > 5 m implies ahead < 9 m) and always(ahead < 99 m)", [1.0, 2.0], true),
        ("always(ahead > 5 m implies ahead < 9 m) and always(ahead > 7 m implies ahead < 99 m)", [1.0, 2.0], false),
    ] {
        let plan = plan(&format!("requirement asked = {formula}"), "asked", "idm");
        let requirement = &plan.campaigns[0].requirements[0].requirement;
        let mut trace = Trace::new(requirement, 8, &|_| false);
        for sample in samples {
            trace.push(requirement, &|id| if id == x { sample } else { f64::NAN });
        }
        assert_eq!(trace.degree(requirement, 1.0).applies, applies, "{formula} {samples:?}");
    }
}

#[test]
fn signals_agree_with_what_is_known_of_an_episode() {
    let declared = "
        requirement near = always(gap > 1000 m)
        requirement soon = always(ttc > 9 s)
        requirement encroached = always(pet > 9 s)
        requirement on_road = always(not left_road)
        requirement braked = always(ego_acceleration > -100 m/s^2)
        requirement closer = always(closing_speed < 200 m/s)
        requirement walked = always(pedestrian_acceleration < 100 m/s^2)
        requirement seen = always(in_sight)";
    let names = "no_collision, near, soon, encroached, keeps_lane, on_road, braked, closer, walked, seen";
    let plan = plan(declared, names, "behavior, blind");
    let (mut collisions, mut met, mut left, mut hidden) = (0, 0, 0, 0);
    for evaluation in plan.campaigns[0].all::<compile::Evaluation>() {
        let scenario = &evaluation.scenario;
        let mut note = |outcome: &Outcome, trace: &EpisodeTrace| {
            let pair = trace.main_pair(scenario);
            let near_miss = NearMiss::new(&pair);
            let lane = LaneDeparture::new(&pair).unwrap();
            let degrees = trace.degrees();
            assert_eq!(degrees.len(), scenario.requirements.len());
            let of = |name: &str| degrees[scenario.requirements.iter().position(|each| &*each.name == name).unwrap()];
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b} {outcome:?}");
            assert_eq!(of("no_collision").is_violated(), outcome.is_collision());
            close(of("near").robustness + 1000.0, outcome.least_gap);
            let frames: Vec<_> = pair.frames().collect();
            if !outcome.is_touch() {
                close(of("soon").robustness + 9.0, near_miss.min_ttc.unwrap_or(10.0));
                close(of("encroached").robustness + 9.0, near_miss.pet.map_or(10.0, |pet| pet.min(10.0)));
                let speeds = frames.windows(2).map(|pair| (pair[1].ego.speed - pair[0].ego.speed) / 0.05);
                close(of("braked").robustness - 100.0, speeds.fold(0.0, f64::min));
                let changes = frames
                    .windows(2)
                    .map(|two| (two[1].pedestrian.velocity - two[0].pedestrian.velocity).norm() / 0.05);
                close(100.0 - of("walked").robustness, changes.fold(0.0, f64::max));
                let sample = of("closer").sample as usize;
                let apart =
                    |frame: &episode::Frame| (frame.pedestrian.pose.position() - frame.ego.pose.position()).norm();
                if sample > 0 && sample + 1 < frames.len() {
                    let rate = (apart(&frames[sample]) - apart(&frames[sample + 1])) / 0.05;
                    assert!((200.0 - of("closer").robustness - rate).abs() < 0.6, "{rate} {:?}", of("closer"));
                }
                met += u32::from(near_miss.pet.is_some());
            }
            assert_eq!(of("keeps_lane").is_violated(), lane.left_lane > 0.0, "{lane:?}");
            assert_eq!(of("on_road").is_violated(), lane.left_road, "{lane:?}");
            let unseen = frames.iter().position(|frame| !pair.in_sight(frame));
            assert_eq!(of("seen").is_violated(), unseen.is_some());
            if let Some(unseen) = unseen {
                assert_eq!(of("seen").sample as usize, unseen);
            }
            collisions += u32::from(outcome.is_collision());
            left += u32::from(lane.left_lane > 0.0);
            hidden += u32::from(unseen.is_some());
        };
        watch(evaluation, None, 0..100, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()));
    }
    assert!(collisions > 5 && met > 5 && hidden > 5, "{collisions} {met} {left} {hidden}");
}

#[test]
fn requirements_change_no_episode() {
    let with = plan("", "no_collision, safe_passing, comfort, yields_at_crosswalk, stops_at_red", "idm");
    let mut without = with.campaigns[0].nth::<compile::Evaluation>(0).clone();
    without.scenario = std::sync::Arc::new(episode::Scenario {
        requirements: [].into(),
        ..episode::Scenario::clone(&without.scenario)
    });
    let digests = |evaluation: &compile::Evaluation| {
        let mut note = |outcome: &Outcome, _: &EpisodeTrace| (outcome.digest, outcome.reward.to_bits());
        watch(evaluation, None, 0..40, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()))
    };
    assert_eq!(digests(with.campaigns[0].nth::<compile::Evaluation>(0)), digests(&without));
}

/// A campaign whose searches look for violations.
fn searches(goal: &str) -> Plan {
    let text = format!(
        "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         requirement slow_pass = always(gap < 1.5 m implies ego_speed < 3 m/s)\n\
         reward none_at_all {{ on timeout => 0 }}\n\
         training quick = ppo(steps: 200, steps_per_update: 50)\n\
         spawn near {{ ego_speed: 6 m/s  bearing: -60 deg .. 60 deg  distance: 7 m .. 20 m }}\n\
         episode until_passed {{ ticks: 160  hold: 10  end_when: ahead < -6 m }}\n\
         method plans = cem(tries: 20, population: 5, elite: 2)\n\
         method evolved = cma_es(tries: 20)\n\
         method grown = mcts(reward: none_at_all, tries: 20)\n\
         method kinds = archive(reward: none_at_all)\n\
         method learnt = ppo(reward: none_at_all)\n\
         method meet = intercept()\n\
         campaign mine {{\n  vehicle: model3  body: plausible  spawn: near  episode: until_passed  training: quick\n\
         search {{ towns: [harbour]  drivers: [behavior]  methods: [plans, evolved, grown, kinds, learnt, meet]\n\
         budget: 20_000  runs: 1  episodes: 20  {goal} }}\n}}\n"
    );
    let read = |path: &Path| if path == Path::new("my.scn") { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(&["my.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{text}\n{:?}", compiled.diagnostics))
}

#[test]
fn every_method_searches_for_violations_of_its_goal() {
    let seed = Seed::root(5);
    let plan = searches("goal: slow_pass");
    let finished = campaign::run(&plan.campaigns[0], &seed, &NoStore, &Silent);
    assert_eq!(finished.all::<results::jobs::SearchResult>().len(), 6);
    let mut without_touch = 0;
    for (search, result) in
        plan.campaigns[0].all::<compile::Search>().zip(finished.all::<results::jobs::SearchResult>())
    {
        let name = &search.key.falsifier;
        assert!(!result.spent.failures.is_empty(), "{name} finds one in {} episodes", result.spent.episodes);
        for failure in result.spent.failures.iter().take(5) {
            let repeatable = Repeatable::SearchFailure { search, start: failure.start, commands: &failure.commands };
            let results::jobs::Repeated { judged: Judged { outcome, .. }, trace, .. } =
                repeatable.repeat(&seed).unwrap();
            assert_eq!(outcome.digest, failure.outcome.digest, "{name}");
            let degree = trace.degrees()[search.scenario.criterion.requirement().unwrap()];
            assert!(degree.is_violated() && outcome.reward >= 1.0, "{name}: {degree:?} earns {}", outcome.reward);
            let worth = 1.0 - degree.robustness / (1.0 + degree.robustness.abs());
            assert!((outcome.reward - worth).abs() < 1e-12, "{name}: {worth} {}", outcome.reward);
            without_touch += u32::from(!outcome.is_touch());
        }
        let cells: std::collections::BTreeSet<_> = result.spent.failures.iter().map(|failure| failure.cell).collect();
        assert!(!cells.is_empty());
    }
    assert!(without_touch > 0, "a violation needs no touch");
    for result in finished
        .all::<results::jobs::SearchResult>()
        .iter()
        .filter(|it| ["plans", "evolved", "grown"].contains(&&*it.key.falsifier))
    {
        let failures = &result.spent.failures;
        let starts: std::collections::BTreeSet<u64> = failures.iter().map(|failure| failure.start).collect();
        assert_eq!(starts.len(), failures.len(), "{} leaves a start after a violation", result.key.falsifier);
    }
    let of_driver = driver_results(
        &plan.campaigns[0].drivers,
        &[],
        &Failures::default(),
        &all_of_searches(finished.all::<results::jobs::SearchResult>()),
        &[],
    );
    let counted = of_driver[0].searched.unwrap();
    let count = |blame| {
        finished
            .all::<results::jobs::SearchResult>()
            .iter()
            .flat_map(|it| it.failures())
            .filter(|find| find.is(blame))
            .count()
    };
    let wanted = (count(Blame::Preventable), count(Blame::Fault));
    assert_eq!((counted.preventable, counted.breaches), wanted, "by the goal in every table");
    let others = searches("");
    let same = |a: &compile::Search, b: &compile::Search| a.origin.fingerprint == b.origin.fingerprint;
    let pairs = plan.campaigns[0].all::<compile::Search>().zip(others.campaigns[0].all::<compile::Search>());
    assert!(pairs.into_iter().all(|(a, b)| !same(a, b)), "a goal makes another search");
}

#[test]
fn a_report_has_rates_failures_and_replays_of_requirements() {
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        import no_collision from \"std/requirements.scn\"\n\
        requirement slow_pass = always(gap < 1.5 m implies ego_speed < 3 m/s) { priority: 2 }\n\
        requirement sees = always(in_sight)\n\
        spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }\n\
        episode until_passed { ticks: 160  hold: 10  end_when: ahead < -6 m }\n\
        method meet = intercept()\n\
        campaign mine {\n  vehicle: model3  body: plausible  spawn: near  episode: until_passed\n\
        requirements: [no_collision, slow_pass, sees]\n\
        evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [intercept, random]  episodes: 30 }\n\
        search { towns: [harbour]  drivers: [blind]  methods: [meet]  budget: 6_000  runs: 1  episodes: 0  goal: slow_pass }\n}\n";
    let read = move |path: &Path| match path.to_str() {
        Some("my.scn") => Ok(text.to_string()),
        _ => std::fs::read_to_string(path),
    };
    let session = Session::default().with_reader(read);
    let folder = tempfile::tempdir().unwrap();
    let run = |out: &str, threads: u16| {
        let options =
            RunOptions { input: Input::file("my.scn"), out: folder.path().join(out), threads, ..RunOptions::default() };
        session.run(&options).unwrap().reports().next().unwrap().folder.clone()
    };
    let (first, other) = (run("one", 1), run("two", 3));
    let table = |folder: &Path, name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    for name in ["requirements.csv", "metrics.csv", "failures.csv"] {
        assert_eq!(table(&first, name), table(&other, name), "{name}");
    }
    let before = table(&first, "requirements.csv");
    assert_eq!(before.lines().count(), 1 + 3 * 60);
    // What was stored gives the same table.
    std::fs::remove_dir_all(&first).unwrap();
    let again = run("one", 2);
    assert_eq!(table(&again, "requirements.csv"), before);

    let failures = |requirements: &[&str]| {
        let requirement = requirements.iter().map(ToString::to_string).collect();
        let options = FailuresArgs { reports: vec![again.clone()], requirement, ..FailuresArgs::default() };
        session.failures(&options).unwrap().into_iter().map(|found| found.failure).collect::<Vec<_>>()
    };
    let slow = failures(&["slow_pass"]);
    let evaluated: Vec<_> = slow.iter().filter(|failure| !failure.is_of_search()).collect();
    let rows =
        |column: &str| before.lines().filter(|line| line.contains(",slow_pass,") && line.contains(column)).count();
    assert_eq!(evaluated.len(), rows(",slow_pass,true,"));
    assert!(!evaluated.is_empty() && slow.iter().any(|failure| failure.is_of_search()), "{slow:?}");
    let searched = slow.iter().filter(|failure| failure.is_of_search()).count();
    let found = table(&again, "searches.csv");
    let id = found.lines().nth(1).unwrap().split(',').next().unwrap();
    let stored = table(&again, "failures.csv").lines().filter(|line| line.starts_with(id)).count();
    assert_eq!(searched, stored, "those that end in a bump, too");
    let metrics = table(&again, "metrics.csv");
    let violations: f64 = metrics
        .lines()
        .filter(|line| line.contains(",violations(slow_pass),"))
        .map(|line| line.split(',').nth(12).unwrap().parse::<f64>().unwrap())
        .sum();
    assert_eq!(violations as usize, evaluated.len());
    let head: Vec<&str> = metrics.lines().next().unwrap().split(',').collect();
    let of = |metric: &str, column: &str| -> Vec<f64> {
        let place = head.iter().position(|name| *name == column).unwrap();
        let rows = metrics.lines().filter(|line| line.contains(&format!(",{metric},")));
        rows.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    let applied = of("applied(slow_pass)", "value");
    assert!(applied.iter().any(|applied| *applied < 30.0), "it says nothing of all episodes: {applied:?}");
    assert_eq!(of("violation_rate(slow_pass)", "n"), applied);
    for ((rate, violations), applied) in
        of("violation_rate(slow_pass)", "value").iter().zip(of("violations(slow_pass)", "value")).zip(applied)
    {
        assert!((rate - violations / applied).abs() < 1e-12, "{rate}");
    }
    assert_eq!(metrics.matches("violation_rate(sees),").count(), 2);
    let faults: f64 = metrics
        .lines()
        .filter(|line| line.contains(",fault_violations(slow_pass),"))
        .map(|line| line.split(',').nth(12).unwrap().parse::<f64>().unwrap())
        .sum();
    let listed = |verdict: &str| {
        let options = FailuresArgs {
            reports: vec![again.clone()],
            requirement: vec!["slow_pass".into()],
            verdict: vec![verdict.into()],
            ..FailuresArgs::default()
        };
        session.failures(&options).unwrap().into_iter().map(|found| found.failure).collect::<Vec<_>>()
    };
    let blamed = listed("fault");
    assert_eq!(faults as usize, blamed.iter().filter(|failure| !failure.is_of_search()).count());
    assert!(blamed.iter().all(|failure| failure.word() == "breach"), "{blamed:?}");
    let page = table(&again, "report.html");
    let link = page.split("href=\"#play-").skip(1).filter_map(|rest| rest.split_once('"'));
    let links: std::collections::BTreeSet<&str> = link.map(|(name, _)| name).collect();
    let is_played = |failure: &&results::failure::Failure| {
        links.contains(failure.name().replace(':', "-").as_str()) && page.contains(&failure.name())
    };
    assert!(evaluated.iter().copied().filter(|failure| is_played(failure)).count() > 0, "{links:?}");
    for link in links {
        assert_eq!(page.matches(&format!("id=\"play-{link}\"")).count(), 1, "{link} has one player");
    }
    for found in &slow {
        assert_eq!(found.in_words(), format!("{}, violates `slow_pass`", found.word()));
    }
    let avoidable = listed("preventable");
    assert!(!avoidable.is_empty() && avoidable.len() >= blamed.len() && listed("no_verdict").is_empty());
    let found = slow.iter().filter(|failure| failure.is_of_search() && failure.fault).count();
    let searches = table(&again, "searches.csv");
    let column = searches.lines().next().unwrap().split(',').position(|name| name == "faults").unwrap();
    let counted: usize = searches.lines().nth(1).unwrap().split(',').nth(column).unwrap().parse().unwrap();
    assert_eq!(counted, found, "the faults of a search are those of its goal");
    // A collision that violates `no_collision` at its touch is listed once.
    let all = failures(&[]);
    let named = |name: &str| {
        all.iter().filter(|failure| failure.violation.as_ref().is_some_and(|found| found.requirement == name)).count()
    };
    assert_eq!(named("no_collision"), 0);
    assert!(all.len() > slow.len());
    for failure in [evaluated[0], slow.iter().find(|failure| failure.is_of_search()).unwrap()] {
        let options = ReplayOptions {
            name: failure.name().parse().unwrap(),
            report: again.clone(),
            repeat: RepeatOptions::default(),
        };
        let replay = session.replay(&options).unwrap();
        let Repeated { scenario, trace, judged, differences, .. } = &replay.episode;
        assert!(differences.is_empty(), "{differences:?}");
        let told = narrative(scenario, trace, judged);
        assert!(told.short.contains("violates") && told.short.contains("`slow_pass`"), "{}", told.short);
        let (time, text) = told.events.iter().find(|(_, text)| text.contains("violates `slow_pass`")).unwrap();
        assert!((time - failure.length).abs() < 1e-9 && text.contains("decides"), "{time} {text} {failure:?}");
    }
    let stored = [&again, &other].map(|folder| StoredReport::open(folder).unwrap());
    let side = |side: usize| Side { report: &stored[side], driver: None, world: None };
    let compared = compare_reports(side(0), side(1)).unwrap();
    let violation = CountedEvent { figure: &COLLISION_RATE, requirement: Some("slow_pass".into()) };
    let slow_pass = compared.changed(&violation);
    assert_eq!(
        (slow_pass.new, slow_pass.fixed, slow_pass.same),
        (0, 0, evaluated.len() as u64),
        "both reports are one"
    );
    assert_eq!(
        (violation.rate(), violation.number()),
        ("violation_rate(slow_pass)".into(), "violations(slow_pass)".into())
    );
    // An unchanged driver has 1 in each column of p, and passes a gate.
    assert!(compared.cells.iter().all(|cell| cell.differing == 0));
    let gate = "violation_rate(slow_pass)_p_holm < 0.05 and violation_rate(slow_pass)_difference > 0";
    let gate = Gate::of_table(gate, &comparison_reference(&requirements_in(gate))).unwrap();
    let judged = gate.judge(&compared_cells(&compared));
    assert!(!judged.is_empty() && judged.iter().all(|judged| matches!(judged, Judgement::Passed(_))), "{judged:?}");
    let requirement = vec!["slow_pas".into()];
    let options = FailuresArgs { reports: vec![again.clone()], requirement, ..FailuresArgs::default() };
    let refused = session.failures(&options).unwrap_err().to_string();
    assert!(
        refused.contains("no report has a requirement `slow_pas`; known are: no_collision, sees, slow_pass"),
        "{refused}"
    );
    let gate = |text: &str| Gate::parse(text).and_then(|gate| gate.check(&plan("", "no_collision", "idm").campaigns));
    assert_eq!(gate("violation_rate(no_collision) > 0.5 and town == harbour"), Ok(()));
    let refused = gate("violation_rate(slow_pass) > 0.5").unwrap_err().to_string();
    assert!(refused.contains("no campaign requires `slow_pass`; there are no_collision"), "{refused}");
}

/// Episodes of each driver in a town, with the requirements of a scenario: the number that violates each requirement.
fn violations(text: &str, episodes: u32) -> Vec<(String, Vec<(String, u32)>)> {
    let read =
        |path: &Path| if path == Path::new("my.scn") { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(&["my.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{text}\n{:?}", compiled.diagnostics));
    let count = |evaluation: &compile::Evaluation| {
        let named = &evaluation.scenario.requirements;
        let mut found: Vec<(String, u32)> = named.iter().map(|each| (each.name.to_string(), 0)).collect();
        let mut note = |_: &Outcome, trace: &EpisodeTrace| {
            for (found, degree) in found.iter_mut().zip(trace.degrees()) {
                found.1 += u32::from(degree.is_violated());
            }
        };
        watch(evaluation, None, 0..episodes, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()));
        (evaluation.policy.to_string(), found)
    };
    plan.campaigns[0].all::<compile::Evaluation>().map(count).collect()
}

#[test]
fn drivers_that_see_no_lights_run_red_ones() {
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        import \"std/requirements.scn\"\n\
        requirement no_light = always(light_distance > 99.9 m)\n\
        requirement no_red = always(not red_light)\n\
        requirement near_the_middle = always(abs(lane_offset) < 1.2 m)\n\
        spawn far { ego_speed: 0 m/s  bearing: -180 deg .. 180 deg  distance: 50 m .. 90 m }\n\
        episode long { ticks: 600  hold: 20 }\n\
        campaign mine {\n  vehicle: model3  body: plausible  spawn: far  episode: long\n\
        requirements: [stops_at_red, no_light, no_red, near_the_middle]\n\
        evaluate { towns: [village]  drivers: [idm, blind]  pedestrians: [random]  episodes: 60 }\n}\n";
    let found = violations(text, 60);
    let of = |driver: &str, name: &str| {
        let (_, all) = found.iter().find(|(policy, _)| policy == driver).unwrap();
        all.iter().find(|(requirement, _)| requirement == name).unwrap().1
    };
    assert!(of("blind", "no_light") > 20 && of("blind", "no_red") > 10, "there are lights: {found:?}");
    assert!(of("idm", "stops_at_red") <= 3 && of("blind", "stops_at_red") > 30, "{found:?}");
    assert!(of("blind", "near_the_middle") + of("idm", "near_the_middle") <= 3, "{found:?}");
}

#[test]
fn drivers_that_yield_at_crosswalks_satisfy_the_requirement() {
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport model3 from \"std/drivers.scn\"\n\
        import \"std/requirements.scn\"\n\
        town straight { street main { through: [(0 m, 0 m), (300 m, 0 m)]  speed_limit: 40 km/h }  crosswalk { at: (100 m, 0 m) } }\n\
        driver polite = idm(crosswalks: \"yield\")\n\
        driver rude = cruise()\n\
        requirement apart = always(crosswalk_distance > 0 m)\n\
        requirement free = always(not crosswalk_taken)\n\
        requirement deserted = always(not crosswalk_waiting)\n\
        // The front is 2.4 m before the middle of the car, the edge of the crosswalk 2 m before its own.\n\
        requirement first = always(crosswalk_distance > 30 m, [0 s, 0 s])\n\
        spawn path = given_path { ego_poses: [(55 m, -1.75 m, 0 deg)]  ego_speed: 9 m/s  through: [(100 m, -4.5 m), (100 m, 6 m)]  speeds: [1.4 m/s] }\n\
        episode long { ticks: 240  hold: 20 }\n\
        campaign mine {\n  vehicle: model3  body: plausible  spawn: path  episode: long\n\
        requirements: [yields_at_crosswalk, apart, free, deserted, first]\n\
        evaluate { towns: [straight]  drivers: [polite, rude]  pedestrians: [scripted]  episodes: 1 }\n}\n";
    let found = violations(text, 1);
    let of = |driver: &str, name: &str| {
        let (_, all) = found.iter().find(|(policy, _)| policy == driver).unwrap();
        all.iter().find(|(requirement, _)| requirement == name).unwrap().1
    };
    for driver in ["polite", "rude"] {
        assert_eq!((of(driver, "free"), of(driver, "first")), (1, 0), "{found:?}");
    }
    assert_eq!((of("polite", "yields_at_crosswalk"), of("rude", "yields_at_crosswalk")), (0, 1), "{found:?}");
    assert_eq!(of("rude", "apart"), 1, "it drives onto the crosswalk: {found:?}");
}

#[test]
fn a_comparison_has_no_rate_of_a_requirement_that_never_applied() {
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport model3 from \"std/drivers.scn\"\n\
        town plain { street main { through: [(0 m, 0 m), (300 m, 0 m)]  speed_limit: 40 km/h } }\n\
        town marked { street main { through: [(0 m, 0 m), (300 m, 0 m)]  speed_limit: 40 km/h }  crosswalk { at: (100 m, 0 m) } }\n\
        driver rude = cruise()\n\
        requirement apart = always(crosswalk_distance < 50 m implies crosswalk_distance > 0 m)\n\
        spawn path = given_path { ego_poses: [(55 m, -1.75 m, 0 deg)]  ego_speed: 9 m/s  through: [(100 m, -4.5 m), (100 m, 6 m)]  speeds: [1.4 m/s] }\n\
        episode long { ticks: 240  hold: 20 }\n\
        campaign mine {\n  vehicle: model3  body: plausible  spawn: path  episode: long\n  requirements: [apart]\n\
        evaluate { towns: [plain, marked]  drivers: [rude]  pedestrians: [scripted]  episodes: 1 }\n}\n";
    let session = Session::default().with_reader(move |path: &Path| match path.to_str() {
        Some("my.scn") => Ok(text.to_string()),
        _ => std::fs::read_to_string(path),
    });
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        input: Input::file("my.scn"),
        out: folder.path().to_path_buf(),
        threads: 1,
        ..RunOptions::default()
    };
    let report = session.run(&options).unwrap().reports().next().unwrap().folder.clone();
    let stored = StoredReport::open(&report).unwrap();
    let side = || Side { report: &stored, driver: None, world: None };
    let compared = compare_reports(side(), side()).unwrap();
    let place = compared.events.iter().position(CountedEvent::is_violation).unwrap();
    for cell in &compared.cells {
        assert_eq!(cell.rates[place].is_some(), cell.keys[0].town == "marked", "{}", cell.title());
    }
    assert_eq!(compared.cells.len(), 2);
}

#[test]
fn careful_humans_are_asked_whose_fault_a_violation_is() {
    let declared = "
        requirement slow_pass = always(gap < 1.5 m implies ego_speed < 3 m/s)
        requirement impossible = always(gap > 1000 m)";
    let plan =
        plan(declared, "no_collision, slow_pass, impossible, safe_passing, comfort, keeps_lane", "behavior, blind");
    let (mut collisions, mut same, mut preventable, mut faults, mut slow) = (0, 0, 0, 0, [0; 3]);
    for evaluation in plan.campaigns[0].all::<compile::Evaluation>() {
        let scenario = &evaluation.scenario;
        let of = |name: &str| scenario.requirements.iter().position(|each| &*each.name == name).unwrap();
        let why = |name: &str| NoVerdict::of(&scenario.requirements[of(name)].requirement);
        assert_eq!(
            ["slow_pass", "comfort", "keeps_lane"].map(why),
            [None, Some(NoVerdict::Braking), Some(NoVerdict::NoPedestrian)]
        );
        let mut note = |outcome: &Outcome, trace: &EpisodeTrace| {
            let pair = trace.main_pair(scenario);
            let judged = Judged::new(outcome, &pair);
            let verdicts: Vec<_> = judged.degrees.iter().map(|each| each.verdict).collect();
            let found = |name: &str| verdicts[of(name)];
            for (degree, verdict) in trace.degrees().iter().zip(&verdicts) {
                assert!(degree.is_violated() || verdict.is_none());
                assert!(verdict.is_none_or(|verdict| verdict.danger <= degree.sample), "{verdict:?} {degree:?}");
            }
            assert_eq!((found("comfort"), found("keeps_lane")), (None, None));
            assert!(!found("impossible").unwrap().preventable, "no careful human satisfies it");
            let collision = judge(&pair).filter(|_| outcome.is_collision());
            assert_eq!(found("no_collision").is_some(), collision.is_some());
            if let (Some(found), Some(collision)) = (found("no_collision"), collision) {
                // Asked as a requirement, the question goes on after the car has passed; so it is at most harder.
                assert!(collision.is_preventable() || !found.preventable, "{found:?} {:?}", collision.label);
                same += u32::from(collision.is_preventable() == found.preventable);
                preventable += u32::from(found.preventable);
                assert_eq!(found.foreseeable, collision.foreseeable);
                assert_eq!(found.fault, found.preventable && collision.is_fault());
                faults += u32::from(found.fault);
                collisions += 1;
            }
            if let Some(verdict) = found("slow_pass") {
                slow[usize::from(verdict.preventable) + usize::from(verdict.fault)] += 1;
            }
        };
        watch(evaluation, None, 0..400, &Seed::root(3), &mut note, &mut |_| ControlFlow::Continue(()));
    }
    assert!(preventable > 3 && faults > 3, "{preventable} {faults}");
    assert!(collisions - same <= collisions / 20, "{same} of {collisions}");
    // The plausible pedestrian moves as people do, so what is preventable is a fault unless a collision decides.
    assert!(slow[0] > 2 && slow[2] > 2, "violations that no careful human avoids, and faults: {slow:?}");
}

#[test]
fn a_reward_pays_for_violations_and_robustness() {
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        requirement other = always(gap > 0.5 m)\n\
        requirement slow_pass = always(gap < 1.5 m implies ego_speed < 3 m/s)\n\
        reward paid {\n  potential: -robustness(slow_pass)\n  on lost => 10 - robustness(slow_pass)\n\
        on timeout => 10 - robustness(slow_pass)\n  on violated(slow_pass) => 1000\n  on violated(other) => 0.5\n}\n\
        spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }\n\
        episode until_passed { ticks: 160  hold: 10  end_when: ahead < -6 m }\n\
        method kinds = archive(reward: paid)\n\
        campaign mine {\n  vehicle: model3  body: plausible  spawn: near  episode: until_passed\n\
        requirements: [slow_pass, other]\n\
        search { towns: [harbour]  drivers: [idm]  methods: [kinds]  budget: 6_000  runs: 1 }\n}\n";
    let compiled = |text: &str| {
        let own = text.to_string();
        let read =
            |path: &Path| if path == Path::new("my.scn") { Ok(own.clone()) } else { std::fs::read_to_string(path) };
        compile(&["my.scn".into()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap()
    };
    let found = compiled(text);
    let plan = found.plan.unwrap_or_else(|| panic!("{:?}", found.diagnostics));
    let scenario = &plan.campaigns[0].nth::<compile::Search>(0).scenario;
    let mut env = scenario.simulation();
    let (mut violations, mut ends) = (0, 0);
    for episode in 0..60 {
        env.start(Draw::new(&Seed::root(4), episode));
        let mut last = env.shaping();
        let outcome = loop {
            let world = env.scene().world;
            let (car, walker) = (&world.ego().state.pose, &world.pedestrians[0].state.pose);
            let ahead = car.position() + car.forward() * 6.0;
            env.decide(&[WalkCommand { heading: walker.yaw + walker.bearing_to(ahead), speed: 1.4 }]);
            while env.tick().is_none() {}
            let now = env.shaping();
            assert!(now >= last, "what must always be true becomes no truer: {last} {now}");
            last = now;
            if let Some(outcome) = env.outcome() {
                break *outcome;
            }
        };
        let [slow, other] = env.degrees() else { panic!("two requirements") };
        assert_eq!(last, -slow.robustness.clamp(-100.0, 100.0));
        let end = if outcome.is_touch() { 0.0 } else { 10.0 - slow.robustness.clamp(-100.0, 100.0) };
        let paid = |is: bool, worth: f64| if is { worth } else { 0.0 };
        let wanted = end + (paid(slow.is_violated(), 1000.0) + paid(other.is_violated(), 0.5));
        if outcome.left_out.is_none() {
            assert!((outcome.reward - wanted).abs() < 1e-9, "{wanted} {outcome:?}");
            violations += u32::from(slow.is_violated());
            ends += u32::from(!outcome.is_touch());
        }
    }
    assert!(violations > 2 && ends > 10, "{violations} {ends}");
    // Another requirement of the same name is another task.
    let changed = compiled(&text.replace("gap < 1.5 m", "gap < 1.6 m")).plan.unwrap();
    let fingerprint = |plan: &Plan| plan.campaigns[0].nth::<compile::Search>(0).origin.fingerprint;
    assert_ne!(fingerprint(&plan), fingerprint(&changed));
    let apart = compiled(&text.replace("requirements: [slow_pass, other]\n", "")).plan.unwrap();
    let other = compiled(&text.replace("requirements: [slow_pass, other]\n", "").replace("gap < 1.5 m", "gap < 1.6 m"));
    assert_ne!(fingerprint(&apart), fingerprint(&other.plan.unwrap()), "the reward alone names it");
}

/// Cases of a test and a fixed start are no sample: an equal episode counts once, and one of a driver that draws each time.
#[test]
fn repeated_starts_are_no_sample_and_draws_count() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\nimport \"std/pedestrians.scn\"\nimport \"std/sensors.scn\"\n\
                driver noisy = idm(sensors: poor)\n\
                town road { street r { through: [(-200 m, 0 m), (200 m, 0 m)] } }\n\
                spawn here { ego_poses: [(-60 m, -1.75 m, 0 deg)]  bearing: 0 deg  distance: 40 m  ego_speed: 8 m/s }\n\
                episode brief { ticks: 100  hold: 10 }\n\
                campaign fixed {\n  vehicle: model3  body: plausible  spawn: here  episode: brief\n\
                evaluate { towns: [road]  drivers: [blind, noisy]  pedestrians: [homing]  episodes: 50 }\n}\n\
                campaign cases {\n  vehicle: model3  body: adult_target  spawn: cpna  episode: protocol_test\n\
                evaluate { towns: [test_track]  drivers: [blind]  pedestrians: [intercept]  episodes: 180 }\n}\n";
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    assert!(crate::program::falsify(&["run", "c.scn"], folder.path()).status.success());
    let rows = |name: &str| {
        let text = std::fs::read_to_string(folder.path().join("reports").join(name).join("results.csv")).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
        let head = lines.next().unwrap();
        let place = |name: &str| head.iter().position(|each| each == name).unwrap();
        let places = ["driver", "episodes", "fault_rate_low"].map(place);
        lines.map(|row| places.map(|place| row[place].clone())).collect::<Vec<_>>()
    };
    let fixed = rows("fixed");
    assert_eq!(fixed[0], ["blind", "1", ""], "one start, one end");
    assert_eq!(fixed[1], ["noisy", "50", ""], "one start, each time other noise");
    assert_eq!(rows("cases"), [["blind", "18", ""]], "the cases of the test, ten times each");
}

#[test]
fn a_protocol_is_gated_by_its_score_and_is_no_sample_of_injuries() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\n\
                campaign ncap {\n  vehicle: model3  body: adult_target  spawn: cpna  episode: protocol_test\n\
                evaluate { towns: [test_track]  drivers: [aeb, blind]  pedestrians: [scripted]  episodes: 18 }\n}\n";
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    for (gate, code, said) in [
        ("score < 0.9 and driver == aeb", 0, "passes, false in 1 row"),
        ("passed < 1 and driver == aeb", 0, "passes, false in 1 row"),
        ("score < 0.9", 7, "score is 0 in ncap"),
        ("passed < 1", 7, "passed is 0 in ncap"),
    ] {
        let output = crate::program::falsify(&["run", "c.scn", "--fail-if", gate], folder.path());
        assert_eq!(output.status.code(), Some(code), "{gate}: {output:?}");
        assert!(crate::program::error(&output).contains(said), "{gate}: {output:?}");
        assert!(!String::from_utf8_lossy(&output.stdout).contains("1,000"), "{output:?}");
    }
    let page = std::fs::read_to_string(folder.path().join("reports/ncap/report.html")).unwrap();
    assert!(!page.contains("in 1,000 episodes") && !page.contains("/ 1,000"), "no six cases are a thousand episodes");
}
