use std::io::Cursor;

use polars::prelude::{Column as Values, DataFrame, DataType, NamedFrom, Series};
use polars_io::parquet::write::ParquetWriter;

use super::*;
use episode::{Ending, Outcome, Spawn};
use road::geometry::Pose;
use verdict::{ContactSide, FalseAlarms, Judged, Label, NearMiss, Reference, Sight, Trial, Verdict};
use world::av::{DrivingMode, Fault};

pub(crate) fn key() -> RunKey {
    let cell = CellKey {
        block: 2,
        town: "harbour".into(),
        policy: "idm".into(),
        vehicle: "v".into(),
        adversary: "w".into(),
        world: "here".into(),
        controller: "trained".into(),
        reward: "r1".into(),
        train_town: "village".into(),
        train_policy: "blind".into(),
    };
    RunKey { id: "1a2b3c4d".parse().unwrap(), cell, run: 3 }
}

/// An episode of [`key`] with this end.
pub(crate) fn row(episode: u32, ending: Ending) -> EpisodeRow {
    let hit = matches!(ending, Ending::Touch { .. });
    let spawn = Spawn { ego: Pose::new(1.0, -2.0, 0.0), ego_speed: 7.0, pedestrian: Pose::new(5.0, 6.5, 0.0) };
    let trial = Trial { impact_speed: None, time: 1.0, least_gap: 0.5, moved: true, braked: true, stopped: true };
    EpisodeRow {
        key: key().into(),
        episode,
        judged: Judged {
            outcome: Outcome {
                spawn,
                start: 0xABCD,
                run_up: 12,
                left_out: None,
                ending,
                reward: 0.25,
                ticks: 90,
                duration: 4.5,
                least_gap: if hit { 0.0 } else { 1.5 },
                on_crosswalk: false,
                last_mode: DrivingMode::Cruise,
                digest: 0xfeed_0000_0000_0001,
                state_hashes: Default::default(),
            },
            verdict: hit.then_some(Verdict {
                label: Label::Contested,
                side: ContactSide::Side,
                walked_into: true,
                latest_reaction: Some(0.9),
                rests_on: None,
                follower: None,
                warning: 2.0,
                foreseeable: true,
                fast: false,
                sight: Sight { seen: 1.0 },
                impact_speed: 4.0,
                trials: [trial; Reference::COUNT],
            }),
            degrees: Vec::new(),
        },
        false_alarms: (!hit).then(FalseAlarms::default),
        near_miss: NearMiss { min_ttc: Some(0.75), pet: None },
        lane: None,
    }
}

fn rows() -> Vec<EpisodeRow> {
    let hit = Ending::Touch { pedestrian: 0, front: true, moving: true, impact_speed: 4.0, bearing: 0.0 };
    vec![
        row(0, hit),
        row(1, Ending::Timeout),
        row(2, Ending::Lost),
        row(3, Ending::Error(Fault::Ended(world::av::Exit::Unknown))),
    ]
}

#[test]
fn rows_that_are_read_back_are_those_that_were_written() {
    let (rows, table) = (rows(), episodes(&rows()));
    let read = EpisodeTable::new(&table).unwrap();
    assert_eq!(read.rows(), 0..4);
    assert_eq!(RunKey::read(&table, 0).unwrap(), key());
    for (place, row) in rows.iter().enumerate().take(3) {
        let outcome = &row.judged.outcome;
        assert_eq!((read.spawn(place), read.is_collision(place)), (outcome.spawn, outcome.is_collision()));
        assert_eq!(read.digest(place), format!("{:016x}", outcome.digest));
        assert_eq!((read.episode(place), read.error(place)), (row.episode, None));
        assert_eq!(read.label(place), row.judged.verdict.map(|verdict| verdict.label));
    }
    assert!(read.error(3).is_some_and(|error| !error.is_empty()) && !read.counts(3));
    assert_eq!(read.avoided(Reference::ALL[0]).count(), 1);
}

#[test]
fn files_of_episodes_have_no_columns_of_failures_or_reference_drivers() {
    let episodes: Vec<_> = episode_references().columns.into_iter().map(|column| column.name).collect();
    assert!(
        episodes.contains(&"fault".into()) && !episodes.iter().any(|name| name == "verdict" || name.starts_with("cc_"))
    );
}

#[test]
fn stored_episodes_get_the_key_of_their_run_and_missing_ones_are_in_error() {
    let rows = rows();
    let (first, done) = encode(None, &rows[..2]).unwrap();
    let (all, more) = encode(Some(&first), &rows[2..3]).unwrap();
    assert_eq!((done, more), (2, 3));
    let whole = Chunk { outcomes: decode(&all).unwrap(), error: String::new() };
    assert!(whole.clone().into_episodes(&key(), 0..3).unwrap().equals_missing(&episodes(&rows[..3])));
    let cut = Chunk { error: "too slow".into(), ..whole };
    let table = cut.into_episodes(&key(), 0..5).unwrap();
    let read = EpisodeTable::new(&table).unwrap();
    assert_eq!((read.rows(), read.error(3), read.error(4)), (0..5, Some("too slow"), Some("too slow")));
    assert_eq!((read.episode(4), read.ticks(4), read.is_collision(4)), (4, None, false));
    assert!(decode(b"no table").is_err());
}

#[test]
fn what_is_written_is_read_whatever_its_size_and_its_repetitions() {
    for rows in [0, 1, 8_000, 300_000] {
        let same = Values::from(Series::new("number".into(), vec![7_i64; rows]));
        let text = Values::from(Series::new(
            "text".into(),
            vec!["the same text, which is long enough for a buffer".repeat(20); rows],
        ));
        let none = Values::full_null("none".into(), rows, &DataType::Float64);
        let table = DataFrame::new(rows, vec![same, text, none]).unwrap();
        let mut bytes = Vec::new();
        ParquetWriter::new(&mut bytes).finish(&mut table.clone()).unwrap();
        let read = |most: u64| read_parquet(Cursor::new(&bytes), most, None, None);
        assert!(read(rows as u64).unwrap().equals_missing(&table));
        if rows > 0 {
            let refused = read(rows as u64 - 1).unwrap_err().to_string();
            assert!(refused.contains(&format!("it has {rows} rows")), "{refused}");
        }
    }
}

/// A wrong count in the header of a page made polars ask for more memory than any machine has, which ends the process.
#[test]
fn tables_with_one_wrong_byte_are_read_or_refused() {
    let numbers = Values::from(Series::new("number".into(), [Some(7_i64), None, Some(9)]));
    let names = Values::from(Series::new("name".into(), ["a", "b", "b"]));
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes).finish(&mut DataFrame::new(3, vec![numbers, names]).unwrap()).unwrap();
    let mut refused = 0;
    for place in 0..bytes.len() {
        // As a number of Thrift: -1, -64 and the first byte of a long one.
        for wrong in [0x01, 0x7f, 0xff] {
            let mut damaged = bytes.clone();
            damaged[place] = wrong;
            refused += usize::from(read_parquet(Cursor::new(damaged), 3, None, None).is_err());
        }
    }
    assert!(refused > bytes.len() / 2, "{refused}");
}

#[test]
fn a_key_is_told_in_words() {
    let mut key = key();
    assert_eq!(key.to_string(), "trained r1 (village, blind) in harbour against idm, run 3");
    assert_eq!(key.cell.in_full(), "trained r1 (village, blind) in harbour against idm, v, w, evaluate 3");
    let there = CellKey { world: "metadrive".into(), ..key.cell.clone() };
    assert_eq!(there.to_string(), format!("{} in metadrive", key.cell));
    (key.cell.train_town, key.cell.train_policy) = Default::default();
    assert_eq!(key.cell.to_string(), "trained r1 in harbour against idm");
}
