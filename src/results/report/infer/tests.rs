use super::*;
use crate::record::columns::EPISODE_REWARD;
use crate::record::{CellKey, RunKey, episodes};
use crate::tables::metrics::{COLLISION_RATE, FRONT_RATE, inferred};
use episode::Ending;
use polars::prelude::{Column, DataFrame};

/// A run whose episodes collide, with a moving car, where the word says `x`; `e` is an error.
fn run(controller: &str, reward: &str, run: u32, town: &str, word: &str) -> DataFrame {
    against("p", controller, reward, run, town, word)
}

/// A run against this driver.
fn against(policy: &str, controller: &str, reward: &str, run: u32, town: &str, word: &str) -> DataFrame {
    let trained = if controller == "trained" { ("a", "p") } else { ("", "") };
    let cell = CellKey {
        controller: controller.into(),
        reward: reward.into(),
        train_town: trained.0.into(),
        train_policy: trained.1.into(),
        town: town.into(),
        policy: policy.into(),
        vehicle: "v".into(),
        adversary: "w".into(),
        world: "here".into(),
        block: 0,
    };
    let row = |(episode, letter): (usize, char)| {
        let ending = match letter {
            'x' => {
                let impact_speed = 1.0 + episode as f64;
                Ending::Touch { pedestrian: 0, front: true, moving: true, impact_speed, bearing: 0.0 }
            }
            'e' => Ending::Error(world::av::Fault::Ended(world::av::Exit::Unknown)),
            _ => Ending::Timeout,
        };
        let mut row = crate::record::tests::row(episode as u32, ending);
        row.key = RunKey { id: format!("{run:08x}").parse().unwrap(), cell: cell.clone(), run }.into();
        (row.judged.verdict, row.judged.outcome.reward) = (None, 0.0);
        row
    };
    episodes(&word.chars().enumerate().map(row).collect::<Vec<_>>())
}

fn gather(runs: Vec<DataFrame>) -> Evidence {
    gathered(EvidenceBuilder::default(), &runs)
}

fn gathered(mut gathering: EvidenceBuilder, runs: &[DataFrame]) -> Evidence {
    for run in runs {
        gathering.add(&RunKey::read(run, 0).unwrap(), run).unwrap();
    }
    gathering.finish()
}

#[test]
fn every_run_is_listed_and_speeds_are_of_collisions_alone() {
    let found = gather(vec![
        run("trained", "r1", 0, "a", "xx..x"),
        run("trained", "r1", 1, "a", "xe.xx"),
        run("trained", "r1", 2, "a", "....."),
    ]);
    let [cell] = &found.cells[..] else { panic!("{found:?}") };
    let of_three_runs = |count: u64| base::statistics::ClusteredCount::from(count).of_clusters(3.0);
    assert_eq!((cell.episodes, cell.collisions), (of_three_runs(14), of_three_runs(6)));
    let between = cell.between(&COLLISION_RATE).unwrap();
    assert_eq!(between.by_run, [0.6, 0.75, 0.0]);
    assert_eq!(between.interval, None, "of three runs");
    assert_eq!(cell.between(&FRONT_RATE).unwrap().by_run, [1.0, 1.0], "the third has none");
    // Speeds 1, 2, 5 and 1, 4, 5.
    assert_eq!(cell.impact_speed_p90, (Some(5.0), 6));
}

#[test]
fn single_runs_are_compared_by_mcnemar_on_pairs_that_both_finished() {
    let found = gather(vec![
        run("trained", "r1", 0, "a", "xxxxxxxx.xe"),
        run("trained", "r2", 0, "a", "xxxxxxxx.xx"),
        run("intercept", "r1", 0, "a", "..........x"),
        run("random", "r2", 0, "a", "...........x"),
    ]);
    let pairs: Vec<(&str, &str, &str)> = found
        .comparisons
        .iter()
        .filter(|found| *found.figure == COLLISION_RATE)
        .map(|found| (found.first.reward.as_str(), found.second.controller.as_str(), found.second.reward.as_str()))
        .collect();
    assert_eq!(pairs, [("r1", "intercept", "r1"), ("r2", "trained", "r1"), ("r2", "random", "r2")]);
    let first = &found.comparisons[0];
    assert_eq!(first.test, Test::McNemar);
    // Nine pairs disagree, all in the same direction.
    assert!((first.p.unwrap() - 2.0 / 512.0).abs() < 1e-12, "{first:?}");
    assert!((first.difference - (0.9 - 1.0 / 11.0)).abs() < 1e-12);
    // Two tests: in the second pair no episode disagrees, so it is none.
    let collisions: Vec<_> = found.comparisons.iter().filter(|found| *found.figure == COLLISION_RATE).collect();
    assert_eq!((collisions[1].p, collisions[1].holm), (Some(1.0), Some(1.0)));
    assert!((collisions[2].holm.unwrap() - 2.0 * collisions[2].p.unwrap()).abs() < 1e-12);
    assert_eq!(first.holm, collisions[2].holm);
    assert!(found.comparisons.iter().all(|found| found.interval.unwrap().0 <= found.difference));
}

#[test]
fn common_starts_make_differences_surer_than_rates() {
    let hits = |offset: usize| -> String {
        // Every second start is hit by all runs. Of the others each run hits one in ten more.
        (0..400).map(|k| if k % 2 == 0 || (k + offset) % 20 == 1 { 'x' } else { '.' }).collect()
    };
    let plain: String = (0..400).map(|k| if k % 2 == 0 { 'x' } else { '.' }).collect();
    let mut runs: Vec<_> = (0..5).map(|number| run("trained", "r1", number, "a", &hits(2 * number as usize))).collect();
    runs.push(run("intercept", "r1", 0, "a", &plain));
    let found = gather(runs);
    let rate = found.cells[0].between(&COLLISION_RATE).unwrap().interval.unwrap();
    let difference = &found.comparisons[0];
    assert_eq!((difference.test, difference.runs), (Test::Student, [5, 1]));
    assert!((difference.difference - 0.05).abs() < 1e-12);
    let (low, high) = difference.uncertainty.unwrap().interval(difference.difference);
    assert!(low > 0.02 && difference.p.unwrap() < 0.001, "{difference:?}");
    assert!(rate.1 - rate.0 > 2.0 * (high - low), "{rate:?} {difference:?}");
}

#[test]
fn drivers_are_compared_run_by_run_on_the_same_starts() {
    // Against the second driver every training hits one start in eight less, whatever it hits against the first one.
    let word = |share: usize, less: usize| -> String {
        (0..400).map(|k| if k % 10 < share && k % 8 >= less { 'x' } else { '.' }).collect()
    };
    let mut runs = Vec::new();
    for (policy, less) in [("p", 0), ("q", 1)] {
        runs.extend(
            (0..4).map(|number| against(policy, "trained", "r1", number, "a", &word(2 + 2 * number as usize, less))),
        );
        runs.push(against(policy, "intercept", "r1", 0, "a", &word(8, less)));
        runs.push(against(policy, "intercept", "r2", 0, "a", &word(8, less)));
    }
    let found = gather(runs);
    let of_drivers = found.comparisons.iter().filter(|found| found.is_of_drivers());
    let [trained, single] = &of_drivers.filter(|found| *found.figure == COLLISION_RATE).collect::<Vec<_>>()[..] else {
        panic!("{:?}", found.comparisons)
    };
    assert_eq!((trained.first.policy.as_str(), trained.second.policy.as_str(), trained.runs), ("q", "p", [4, 4]));
    assert_eq!((single.first.controller.as_str(), single.test), ("intercept", Test::McNemar));
    // 8 of 10 starts are hit by one driver, of these one in eight not by the other: 40 of 400.
    assert!((single.difference + 0.1).abs() < 1e-12 && single.p.unwrap() < 1e-9, "{single:?}");
    // Rates of the trainings differ by 0.6, their differences between drivers hardly.
    let (low, high) = trained.interval.unwrap();
    assert!(trained.test == Test::Student && low < trained.difference && trained.difference < high, "{trained:?}");
    assert!(high < 0.1 && high - low < 0.3, "{trained:?}");
    assert!(found.comparisons.iter().any(|found| !found.is_of_drivers()), "controllers are compared, too");
}

#[test]
fn two_and_three_runs_have_their_values_and_no_interval() {
    let campaign = |runs: u32| {
        let trained = (0..runs).map(|number| run("trained", "r1", number, "a", &word(20 + number as usize, 100)));
        gather(trained.chain([run("intercept", "r1", 0, "a", &word(10, 100))]).collect())
    };
    for (runs, few) in [(2, true), (3, true), (4, false)] {
        let found = campaign(runs);
        let (cell, compared) = (found.cells[0].between(&COLLISION_RATE).unwrap(), &found.comparisons[0]);
        assert_eq!(cell.interval.is_none(), few, "{runs}");
        assert_eq!((compared.has_few_runs(), compared.interval.is_none()), (few, few), "{runs}");
        assert_eq!((compared.by_run[0].len(), compared.by_run[1].as_slice()), (runs as usize, [0.1].as_slice()));
        assert_eq!(compared.p.is_some(), runs > 2, "{runs}");
    }
    let single = campaign(1);
    assert!(single.comparisons[0].interval.is_some(), "over episodes");
}

#[test]
fn simultaneous_intervals_allow_for_all_comparisons() {
    // Of 40 starts 6 are hit by one driver only: exact p is 0.03, and the interval of this comparison alone does not contain 0.
    let place = |town: &str| {
        vec![
            against("p", "intercept", "r1", 0, town, &word(10, 40)),
            against("q", "intercept", "r1", 0, town, &word(16, 40)),
        ]
    };
    let low = |towns: &[&str]| {
        let found = gather(towns.iter().flat_map(|town| place(town)).collect());
        let first = found.comparisons.iter().find(|found| *found.figure == COLLISION_RATE).unwrap().clone();
        assert!((first.difference - 0.15).abs() < 1e-12 && first.p.unwrap() < 0.05);
        first.interval.unwrap().0
    };
    // Each place has four rates.
    let (one, two) = (low(&["a"]), low(&["a", "b"]));
    assert!(one < 0.0 && two < one, "{one} {two}");
}

#[test]
fn other_cells_change_no_interval() {
    let some = || vec![run("trained", "r1", 0, "a", "xx.x.."), run("trained", "r1", 1, "a", "x..x..")];
    let more = some().into_iter().chain([run("random", "r1", 0, "a", "x.....")]).collect();
    let mut with_more = gather(more).cells.remove(0);
    let alone = gather(some()).cells.remove(0);
    // Whether it beats an untrained one is a comparison with the other cells.
    with_more.learning.clone_from(&alone.learning);
    assert_eq!(alone, with_more);
}

#[test]
fn parts_of_runs_give_the_bits_of_whole_runs() {
    let runs = || {
        vec![
            run("trained", "r1", 0, "a", "xx..xe.x"),
            run("trained", "r1", 1, "a", "xe.xx..."),
            run("random", "r1", 0, "a", ".x......"),
        ]
    };
    let part = |size: usize| {
        let parts = |run: DataFrame| (0..8).step_by(size).map(move |from| run.slice(from as i64, size));
        gather(runs().into_iter().flat_map(parts).collect())
    };
    assert_eq!(format!("{:?}", part(3)), format!("{:?}", gather(runs())));
    assert_eq!(format!("{:?}", part(1)), format!("{:?}", gather(runs())));
}

#[test]
fn what_is_not_kept_counts_in_sums_and_hardly_changes_an_interval() {
    // Both runs collide in half of the episodes, in blocks of 2 and of 3, so a third of what moves one run also moves the other.
    let word = |turn: usize, size: usize| -> String {
        (0..size).map(|k| if (k / turn).is_multiple_of(2) || k % 60 == 7 { 'x' } else { '.' }).collect()
    };
    let runs = || vec![run("trained", "r1", 0, "a", &word(2, 6000)), run("trained", "r1", 1, "a", &word(3, 4800))];
    let some = |kept: usize| gathered(EvidenceBuilder::keeping(kept), &runs()).cells.remove(0);
    let (whole, part) = (some(6000), some(600));
    assert_eq!((whole.episodes, whole.collisions), (part.episodes, part.collisions));
    let of_those_kept = runs().iter().map(|run| run.head(Some(600))).collect();
    assert_eq!(
        (whole.impact_speed_p90.1, part.impact_speed_p90),
        (5500, gather(of_those_kept).cells[0].impact_speed_p90)
    );
    for figure in inferred() {
        let by_run = |cell: &CellEvidence| cell.between(figure).unwrap().by_run.clone();
        assert_eq!(by_run(&whole), by_run(&part), "{figure:?}");
    }
    let error = |cell: &CellEvidence| cell.uncertainty(&COLLISION_RATE).unwrap().error;
    assert!((error(&part) / error(&whole) - 1.0).abs() < 0.02, "{} for {}", error(&part), error(&whole));
}

/// A run whose reward is 1 for each collision.
fn rewarded(controller: &str, number: u32, town: &str, word: &str) -> DataFrame {
    let mut run = run(controller, "r1", number, town, word);
    let rewards: Vec<f64> = word.chars().map(|letter| if letter == 'x' { 1.0 } else { 0.0 }).collect();
    run.with_column(Column::new(EPISODE_REWARD.name.into(), rewards)).unwrap();
    run
}

/// A word of `size` episodes, the first `hits` of which are collisions.
fn word(hits: usize, size: usize) -> String {
    "x".repeat(hits) + &".".repeat(size - hits)
}

/// Whether trainings with these hits of 200 beat untrained ones and disagree, with the reasons to doubt them. `random` hits 10 times and `intercept` 80 times.
fn learning(hits: &[usize]) -> (BeatsUntrained, Option<bool>, Vec<Reason>) {
    let trained = hits.iter().zip(0..).map(|(hits, run)| rewarded("trained", run, "a", &word(*hits, 200)));
    let others = [rewarded("random", 0, "a", &word(10, 200)), rewarded("intercept", 0, "a", &word(80, 200))];
    let found = gather(trained.chain(others).collect());
    let learning = found.cells[0].learning.as_ref().unwrap();
    assert!(found.cells[1].learning.is_none(), "an untrained pedestrian learns nothing");
    (
        learning.beats_untrained(),
        learning.disagree(),
        doubts(&found.cells).into_iter().map(|doubt| doubt.reason).collect(),
    )
}

#[test]
fn trainings_beat_untrained_if_they_are_above_an_untrained_controller_and_below_none() {
    let (beats, disagree, reasons) = learning(&[120, 124, 116]);
    assert_eq!((beats, disagree, reasons.len()), (BeatsUntrained::Yes, Some(false), 0));
    let (beats, _, reasons) = learning(&[40, 44, 36]);
    assert_eq!(beats, BeatsUntrained::No, "above random and below intercept");
    let than = Untrained { controller: "intercept".into(), reward: 0.4 };
    assert_eq!(reasons, [Reason::Below { count: 3, of: 3, than, rewards: vec![0.2, 0.22, 0.18] }]);
    let (beats, disagree, reasons) = learning(&[80]);
    assert_eq!((beats, disagree, reasons.len()), (BeatsUntrained::Yes, None, 0), "as good as intercept");
    let (beats, _, reasons) = learning(&[0]);
    assert_eq!(beats, BeatsUntrained::No);
    assert!(matches!(&reasons[..], [Reason::Below { than, .. }] if than.controller == "intercept"), "{reasons:?}");
    // One bad training of many is found, although their mean is good and they do not disagree by much.
    let (beats, disagree, reasons) = learning(&[120, 120, 120, 120, 120, 120, 120, 120, 120, 20]);
    assert_eq!((beats, disagree), (BeatsUntrained::No, Some(false)));
    assert!(matches!(&reasons[..], [Reason::Below { count: 1, of: 10, .. }]), "{reasons:?}");
}

#[test]
fn trainings_that_differ_by_more_than_their_episodes_and_half_their_gain_disagree() {
    // The first two are the rates of the audit that it calls a wild disagreement.
    for (hits, wanted) in
        [(&[6, 146, 98], true), (&[28, 116, 30], true), (&[120, 140, 100], false), (&[11, 12, 9], false)]
    {
        let (_, disagree, reasons) = learning(hits);
        assert_eq!(disagree, Some(wanted), "{hits:?}");
        let said = reasons.iter().any(|reason| matches!(reason, Reason::Disagree { .. }));
        assert_eq!(said, wanted, "{reasons:?}");
    }
}

#[test]
fn without_an_untrained_controller_learning_is_unclear_and_silent() {
    let found = gather(vec![rewarded("trained", 0, "a", &word(3, 50)), rewarded("trained", 1, "a", &word(2, 50))]);
    assert!(
        found.cells.iter().all(|cell| cell.learning.as_ref().unwrap().beats_untrained() == BeatsUntrained::Unclear)
    );
    assert_eq!(doubts(&found.cells), []);
    let equal = gather(vec![rewarded("trained", 0, "a", &word(0, 50)), rewarded("random", 0, "a", &word(0, 50))]);
    let found = doubts(&equal.cells);
    let [doubt] = &found[..] else { panic!("{found:?}") };
    let than = Untrained { controller: "random".into(), reward: 0.0 };
    assert_eq!(doubt.reason, Reason::NotAbove { count: 1, of: 1, than, rewards: vec![0.0] });
    let text = doubt.to_string();
    assert!(text.contains("no sign of learning") && text.contains("train for more `steps`"), "{text}");
}

#[test]
fn trainings_are_doubted_where_they_were_trained() {
    let place = |town: &str, hits: usize| {
        vec![rewarded("trained", 0, town, &word(hits, 200)), rewarded("random", 0, town, &word(40, 200))]
    };
    let both = gather([place("a", 150), place("b", 5)].concat());
    let beats: Vec<_> = both.cells.iter().filter_map(|cell| Some(cell.learning.as_ref()?.beats_untrained())).collect();
    assert_eq!(
        (beats, doubts(&both.cells).len()),
        (vec![BeatsUntrained::Yes, BeatsUntrained::No], 0),
        "it was trained in a"
    );
    assert_eq!(doubts(&gather(place("b", 5)).cells).len(), 1, "it was evaluated nowhere else");
}

#[test]
fn differences_in_reward_are_adjusted_for_their_number() {
    let place =
        |town: &str| vec![rewarded("trained", 0, town, &word(16, 100)), rewarded("random", 0, town, &word(10, 100))];
    let baseline = gather(place("a")).cells.remove(0).learning.unwrap().baselines.remove(0);
    let (one, (low, high)) = (baseline.trainings[0], baseline.difference.1);
    assert!((one.difference - 0.06).abs() < 1e-12 && (baseline.reward - 0.1).abs() < 1e-12);
    // Six of a hundred pairs differ: the standard error is the root of 0.06 (1 - 0.06) / 100.
    let error = (0.06_f64 * 0.94 / 100.0).sqrt();
    assert!((high - low - 2.0 * 1.959_964 * error).abs() < 1e-4, "{baseline:?}");
    assert!(one.p < 0.02 && one.holm == one.p);
    let two = gather([place("a"), place("b")].concat());
    let holm = |cell: &CellEvidence| Some(cell.learning.as_ref()?.baselines[0].trainings[0].holm);
    let holm: Vec<f64> = two.cells.iter().filter_map(holm).collect();
    assert_eq!(holm, [2.0 * one.p, 2.0 * one.p]);
}
