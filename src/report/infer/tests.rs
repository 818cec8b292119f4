use super::*;
use crate::av::DrivingMode;
use crate::env::{Ending, Outcome, Spawn};
use crate::geometry::Pose;
use crate::judge::NearMiss;
use crate::record::columns::WEIGHT;
use crate::record::{CellKey, EpisodeRow, RunKey, episodes};
use crate::seed::Seed;
use polars::prelude::{Column, DataFrame};

/// A run whose episodes collide, with a moving car, where the word says `x`; `e` is an error.
fn run(controller: &str, reward: &str, run: u32, town: &str, word: &str) -> DataFrame {
    let trained = if controller == "trained" { ("a", "p") } else { ("", "") };
    let cell = CellKey {
        controller: controller.into(),
        reward: reward.into(),
        train_town: trained.0.into(),
        train_policy: trained.1.into(),
        town: town.into(),
        policy: "p".into(),
        vehicle: "v".into(),
        adversary: "w".into(),
        block: 0,
    };
    let row = |(episode, letter): (usize, char)| {
        let ending = match letter {
            'x' => {
                let impact_speed = 1.0 + episode as f64;
                Ending::Collision { front: true, moving: true, impact_speed, bearing: 0.0 }
            }
            'e' => Ending::Error(crate::av::Fault::Ended),
            _ => Ending::Timeout,
        };
        let spawn = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let last_mode = DrivingMode::Cruise;
        EpisodeRow {
            key: RunKey { id: format!("{run:08x}").parse().unwrap(), cell: cell.clone(), run }.into(),
            episode: episode as u32,
            outcome: Outcome {
                spawn,
                ending,
                reward: 0.0,
                ticks: 1,
                duration: 0.05,
                least_gap: 1.0,
                last_mode,
                digest: 7,
                state_hashes: Default::default(),
            },
            verdict: None,
            false_alarms: None,
            near_miss: NearMiss { min_ttc: Some(episode as f64), pet: None },
            motion: Default::default(),
            weight: 1.0,
        }
    };
    episodes(&word.chars().enumerate().map(row).collect::<Vec<_>>())
}

fn gather(runs: Vec<DataFrame>) -> Evidence {
    let mut gathering = Gathering::new(Seed::root(1));
    runs.iter().for_each(|run| gathering.add(run).unwrap());
    gathering.finish()
}

#[test]
fn every_run_is_listed_and_quantiles_leave_collisions_apart() {
    let found = gather(vec![
        run("trained", "r1", 0, "a", "xx..x"),
        run("trained", "r1", 1, "a", "xe.xx"),
        run("trained", "r1", 2, "a", "....."),
    ]);
    let [cell] = &found.cells[..] else { panic!("{found:?}") };
    assert_eq!((cell.episodes, cell.collisions), (14.into(), 6.into()));
    let between = cell.between(Figure::Collision);
    assert_eq!(between.by_run, [Some(0.6), Some(0.75), Some(0.0)]);
    assert!((between.iqm.unwrap() - 0.45).abs() < 1e-12);
    let (low, high) = between.bootstrap.unwrap();
    assert!(low < 0.2 && (0.65..=1.0).contains(&high), "{low}..{high}");
    assert_eq!(cell.between(Figure::Front).by_run, [Some(1.0), Some(1.0), None]);
    // Speeds 1, 2, 5 and 1, 4, 5.
    assert_eq!((cell.impact_speed.n, cell.impact_speed.at[0]), (6, Some(3.0)));
    // Without collisions: 2, 3 and 2 and all of 0 to 4.
    assert_eq!((cell.min_ttc.n, cell.min_ttc.at[2], cell.pet.n), (8, Some(2.0), 0));
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
        .filter(|found| found.figure == Figure::Collision)
        .map(|found| (found.first.reward.as_str(), found.second.controller.as_str(), found.second.reward.as_str()))
        .collect();
    assert_eq!(pairs, [("r1", "intercept", "r1"), ("r2", "trained", "r1"), ("r2", "random", "r2")]);
    let first = &found.comparisons[0];
    assert_eq!(first.test, Test::McNemar);
    // Nine pairs disagree, all in the same direction.
    assert!((first.p.unwrap() - 2.0 / 512.0).abs() < 1e-12, "{first:?}");
    assert!((first.difference - (0.9 - 1.0 / 11.0)).abs() < 1e-12);
    assert!(first.holm.unwrap() >= first.benjamini_hochberg.unwrap() && first.holm.unwrap() > first.p.unwrap());
    assert!(found.comparisons.iter().all(|found| found.bootstrap.0 <= found.difference));
}

#[test]
fn common_beginnings_make_differences_surer_than_rates() {
    let hits = |offset: usize| -> String {
        // Every second start is hit by all runs. Of the others each run hits one in ten more.
        (0..400).map(|k| if k % 2 == 0 || (k + offset) % 20 == 1 { 'x' } else { '.' }).collect()
    };
    let plain: String = (0..400).map(|k| if k % 2 == 0 { 'x' } else { '.' }).collect();
    let mut runs: Vec<_> = (0..5).map(|number| run("trained", "r1", number, "a", &hits(2 * number as usize))).collect();
    runs.push(run("intercept", "r1", 0, "a", &plain));
    let found = gather(runs);
    let rate = found.cells[0].between(Figure::Collision).bootstrap.unwrap();
    let difference = &found.comparisons[0];
    assert_eq!((difference.test, difference.runs), (Test::Student, [5, 1]));
    assert!((difference.difference - 0.05).abs() < 1e-12);
    assert!(difference.bootstrap.0 > 0.02 && difference.p.unwrap() < 0.001, "{difference:?}");
    assert!(rate.1 - rate.0 > 2.0 * (difference.bootstrap.1 - difference.bootstrap.0), "{rate:?} {difference:?}");
}

#[test]
fn transfer_is_home_less_away_for_the_same_trainings() {
    let found = gather(vec![
        run("trained", "r1", 0, "a", "xxxx"),
        run("trained", "r1", 1, "a", "xxx."),
        run("random", "r1", 0, "a", "...."),
        run("trained", "r1", 1, "b", "x..."),
        run("trained", "r1", 0, "b", "xx.."),
        run("random", "r1", 0, "b", "...."),
    ]);
    let [gap, ..] = &found.transfers[..] else { panic!("{found:?}") };
    assert_eq!((gap.change, gap.figure, gap.runs), (Change::Town, Figure::Collision, 2));
    assert_eq!((gap.home.town.as_str(), gap.away.town.as_str()), ("a", "b"));
    assert_eq!((gap.values, gap.gap), ([0.875, 0.375], 0.5));
    // Both gaps are 0.5, with no spread between trainings, so the interval is that of the episodes.
    assert_eq!(gap.student, Some((0.5, 0.5)));
    assert!(gap.bootstrap.0 < 0.4 && gap.bootstrap.1 > 0.6, "{gap:?}");
    assert_eq!(found.transfers.len(), 3, "collision, moving, preventable; the random one is at home nowhere");
}

#[test]
fn other_cells_change_no_interval() {
    let some = || vec![run("trained", "r1", 0, "a", "xx.x.."), run("trained", "r1", 1, "a", "x..x..")];
    let more = some().into_iter().chain([run("random", "r1", 0, "a", "x.....")]).collect();
    assert_eq!(gather(some()).cells[0], gather(more).cells[0]);
}

#[test]
fn what_is_not_kept_counts_in_sums_and_hardly_changes_an_interval() {
    // Both runs collide in half of the episodes, in blocks of 2 and of 3, so a third of what moves one run also moves the other.
    let word = |turn: usize, size: usize| -> String {
        (0..size).map(|k| if (k / turn).is_multiple_of(2) || k % 60 == 7 { 'x' } else { '.' }).collect()
    };
    let runs = || vec![run("trained", "r1", 0, "a", &word(2, 6000)), run("trained", "r1", 1, "a", &word(3, 4800))];
    let some = |kept: usize| {
        let mut gathering = Gathering::keeping(kept, Seed::root(1));
        runs().iter().for_each(|run| gathering.add(run).unwrap());
        gathering.finish().cells.remove(0)
    };
    let (whole, part) = (some(6000), some(600));
    assert_eq!((whole.episodes, whole.collisions), (part.episodes, part.collisions));
    let of_those_kept = runs().iter().map(|run| run.head(Some(600))).collect();
    assert_eq!((whole.impact_speed.n, part.impact_speed), (5500, gather(of_those_kept).cells[0].impact_speed));
    for figure in Figure::ALL {
        assert_eq!(whole.between(figure).by_run, part.between(figure).by_run, "{figure:?}");
    }
    let (_, exact) = whole.samples[0].as_ref().unwrap();
    let (_, near) = part.samples[0].as_ref().unwrap();
    for (exact, near) in exact.covariance.iter().zip(&near.covariance) {
        assert!((near / exact - 1.0).abs() < 0.02 || (near - exact).abs() < 1e-6, "{near} for {exact}");
    }
}

#[test]
fn episodes_count_by_their_weights() {
    let word = "xx..x.....";
    let with = |weight: fn(usize) -> f64| {
        let weights: Vec<f64> = (0..word.len()).map(weight).collect();
        let mut run = run("trained", "r1", 0, "a", word);
        run.with_column(Column::new(WEIGHT.name.into(), weights)).unwrap();
        gather(vec![run]).cells.remove(0)
    };
    let plain = gather(vec![run("trained", "r1", 0, "a", word)]).cells.remove(0);
    let rate = |cell: &CellEvidence| cell.between(Figure::Collision).by_run[0].unwrap();
    assert_eq!(with(|_| 1.0), plain, "weights of 1 are none");
    assert!((rate(&with(|_| 0.25)) - rate(&plain)).abs() < 1e-12, "equal weights change no rate");
    // The first three, of which two collide, have weight 10: 21 of 37.
    let heavy = with(|episode| if episode < 3 { 10.0 } else { 1.0 });
    assert!((rate(&heavy) - 21.0 / 37.0).abs() < 1e-12);
    assert_eq!((heavy.collisions.count(), heavy.collisions.sum()), (3, 21.0));
    let width = |cell: &CellEvidence| cell.between(Figure::Collision).bootstrap.map(|(low, high)| high - low).unwrap();
    assert!(width(&heavy) > width(&plain), "unequal weights say less");
    // The mean of a reward is weighted too, and other figures follow.
    assert_eq!(heavy.between(Figure::Reward).by_run, [Some(0.0)]);
}
