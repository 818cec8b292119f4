//! Gates: which cells they choose, how they judge them, and what is refused.

use polars::prelude::{DataFrame, df};
use results::report::{Gate, GateError, Judged, comparison_reference, rechecked_reference};

#[test]
fn a_column_of_searches_alone_makes_a_gate_about_searches() {
    let about = |text: &str| Gate::parse(text).map(|gate| gate.is_about_searches());
    assert_eq!(about("faults > 0 and town == village"), Ok(true));
    assert_eq!(about("preventable_rate > 0 and town == village"), Ok(false));
    assert_eq!(about("town == village"), Ok(false), "a column of both");
    assert!(matches!(about("faults > much"), Err(GateError::Kind { .. })));
    let mixed = about("faults > 0 and preventable_rate > 0");
    assert!(matches!(mixed, Err(GateError::Column { name, .. }) if name == "faults"));
}

fn cells() -> DataFrame {
    let rates: Vec<Option<f64>> = vec![Some(0.04), Some(0.06), None];
    let learnt: Vec<Option<&str>> = vec![Some("yes"), Some("no"), None];
    df!(
        "town" => ["harbour", "village", "village"],
        "pedestrian" => ["trained", "trained", "random"],
        "beats_untrained" => learnt,
        "preventable_rate_mean" => rates,
        "errors" => [0_u32, 0, 3]
    )
    .unwrap()
}

fn judged(text: &str) -> String {
    letters(&cells(), text)
}

/// How a gate judges each cell, as letters.
fn letters(cells: &DataFrame, text: &str) -> String {
    of_gate(cells, &gate(text))
}

fn of_gate(cells: &DataFrame, gate: &Gate) -> String {
    let letter = |judged: &Judged| match judged {
        Judged::Passed(_) => 'p',
        Judged::Broken(_) => 'b',
        Judged::Missing(_) => 'm',
        Judged::NoValue(_) => 'v',
        Judged::TooFewRuns(_) => 'f',
        Judged::MissingEverywhere(_) => 'M',
        Judged::NothingEvaluated => 'n',
        Judged::OffRoad(_) => 'r',
        Judged::Thin(_) | Judged::ThinPrice(_) => 't',
        Judged::TooFewStarts(_) => 's',
        Judged::TooFewSearched(_) => 'S',
        Judged::TooFewRechecked(_) => 'R',
        Judged::NotTested(_) => 'N',
        Judged::NotMet { all: true, .. } => 'A',
        Judged::NotMet { .. } => 'u',
        Judged::InError(_) => 'E',
        Judged::Elsewhere => 'e',
    };
    gate.judge(cells).iter().map(letter).collect()
}

/// A gate on cells, searches or a comparison.
fn gate(text: &str) -> Gate {
    Gate::parse(text).or_else(|_| Gate::of_table(text, &comparison_reference(&[]))).unwrap()
}

#[test]
fn a_gate_is_broken_where_all_its_conditions_hold() {
    for (text, wanted) in [
        ("preventable_rate > 0.05", "pbm"),
        ("preventable_rate>=0.04", "bbm"),
        ("preventable_rate < 0.05", "bpm"),
        ("preventable_rate <= 0.04", "bpm"),
        ("preventable_rate == 0.04", "bpm"),
        ("preventable_rate != 0.04", "pbm"),
        ("errors > 0", "ppb"),
        ("preventable_rate > 0.01 and town == village", "ebm"),
        ("preventable_rate > 0.01 and town != \"village\"", "bee"),
        ("preventable_rate > 0.05 and errors > 0", "ppm"),
        ("preventable_rate > 0.05 and errors < 1", "pbp"),
    ] {
        assert_eq!(judged(text), wanted, "{text}");
    }
}

#[test]
fn a_gate_that_passes_says_what_came_nearest() {
    let nearest = |text: &str| gate(text).nearest(&gate(text).judge(&cells()));
    assert_eq!(nearest("preventable_rate > 0.05"), Some((0, "preventable_rate_mean is 0.04".into())));
    assert_eq!(nearest("preventable_rate > 0.01"), None, "none passes");
    assert_eq!(nearest("beats_untrained != yes"), None, "no number");
}

#[test]
fn words_of_the_key_choose_cells_and_other_words_are_judged() {
    for (text, wanted) in [
        ("beats_untrained != yes", "pbe"),
        ("beats_untrained == yes", "bpe"),
        ("beats_untrained != yes and town == harbour", "pee"),
        ("beats_untrained != yes and preventable_rate > 0.05", "pbe"),
        ("pedestrian == random and town == harbour", "eee"),
        ("pedestrian == random", "eeb"),
    ] {
        assert_eq!(judged(text), wanted, "{text}");
    }
    let gate = Gate::parse("beats_untrained != yes").unwrap();
    assert_eq!(gate.judge(&cells())[1], Judged::Broken(vec![("beats_untrained".into(), "no".into())]));
}

#[test]
fn a_gate_on_an_interval_fails_where_too_few_runs_have_one() {
    let cells = df!(
        "town" => ["harbour", "village", "quay"],
        "runs" => [4_u32, 3, 3],
        "fault_rate_student_low" => [Some(0.01), None, None],
        "fault_rate_wilson_low" => [Some(0.01), Some(0.02), None],
        "fault_rate_mean" => [Some(0.02), Some(0.03), Some(0.04)],
        "front_rate_mean" => [Some(0.02), None, Some(0.04)]
    )
    .unwrap();
    assert_eq!(letters(&cells, "fault_rate_student_low > 0.05"), "pff", "it could never be true of three runs");
    assert_eq!(letters(&cells, "fault_rate_student_low > 0.05 and fault_rate_mean > 0.03"), "ppf");
    assert_eq!(letters(&cells, "front_rate_mean > 0.5"), "pvp", "other columns may have no value");
    let said = |row: usize| match &gate("fault_rate_student_low > 0.05").judge(&cells)[row] {
        Judged::TooFewRuns(few) => few.to_string(),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        said(1),
        "there is no `fault_rate_student_low`, since fewer than 4 runs have no interval, and the cases of a test have none at all; write `fault_rate_wilson_low`, or give more `runs`"
    );
    assert!(said(2).contains("write `fault_rate_mean`"), "{}", said(2));
}

#[test]
fn a_row_that_cannot_be_judged_fails_unless_that_is_allowed() {
    let cells = df!(
        "runs" => [1_u64, 2],
        "common_starts" => [200_u64, 200],
        "fault_rate_p_holm" => [Some(0.4), None],
        "fault_rate_difference" => [0.01, 0.1]
    )
    .unwrap();
    let gate = gate("fault_rate_p_holm < 0.05 and fault_rate_difference > 0");
    assert_eq!(of_gate(&cells, &gate), "pm", "two runs have no p");
    assert!(gate.judge(&cells)[1].fails());
    let allowing = gate.allowing_unjudged(true);
    assert_eq!(of_gate(&cells, &allowing), "pv");
    assert!(!allowing.judge(&cells)[1].fails());
}

#[test]
fn a_gate_that_judges_nothing_fails() {
    let cells = df!(
        "town" => ["harbour", "village"],
        "episodes" => [10_u32, 0],
        "errors" => [0_u32, 3],
        "fault_rate_mean" => [Some(0.02), None],
        "front_rate_mean" => [None::<f64>, None],
        "episode_reward_mean" => [None::<f64>, None]
    )
    .unwrap();
    assert_eq!(
        letters(&cells, "fault_rate > 0.05"),
        "tn",
        "one failure in ten episodes would break it; all others were left out"
    );
    assert_eq!(letters(&cells, "fault_rate > 0.1"), "pn");
    assert_eq!(letters(&cells, "max over pedestrians fault_rate > 0.05"), "tn");
    assert_eq!(letters(&cells, "errors > 5"), "pn");
    assert_eq!(letters(&cells, "errors > 0"), "pb", "what is broken is said");
    assert_eq!(letters(&cells, "fault_rate > 0.05 and town == harbour"), "te");
    assert_eq!(letters(&cells.head(Some(1)), "episode_reward > 0"), "M", "no row has it");
    assert_eq!(letters(&cells.head(Some(1)), "front_rate > 0.5"), "v", "nothing was touched");
    let searches = df!(
        "starts_mean" => [0.0, 1.5],
        "faults_mean" => [0.0, 0.0]
    )
    .unwrap();
    assert_eq!(letters(&searches, "faults > 0"), "np", "its budget holds no start");
    let shares = df!("starts_mean" => [1.0, 9.5, 10.0, 1.0], "fault_start_rate_mean" => [0.0, 0.0, 0.0, 1.0]).unwrap();
    assert_eq!(letters(&shares, "fault_start_rate > 0.1"), "SSpb", "one start shows no share");
}

#[test]
fn a_gate_on_a_probability_fails_where_no_number_of_failures_could_break_it() {
    let cells = |starts: [u32; 2], runs: [u32; 2], new: [u64; 2], p: [f64; 2]| {
        df!(
            "runs" => runs,
            "common_starts" => starts,
            "fault_rate_difference" => [0.5, 0.0],
            "fault_rate_p_holm" => p,
            "fault_new" => new
        )
    };
    let gate = "fault_rate_p_holm < 0.05 and fault_rate_difference > 0";
    let judged = |starts, runs, new, p| letters(&cells(starts, runs, new, p).unwrap(), gate);
    let chance = [0.25, 1.0];
    assert_eq!(judged([5, 5], [1, 1], [2, 0], chance), "ss", "5 of 5 starts worse have p = 0.06");
    assert_eq!(judged([6, 6], [1, 1], [2, 2], chance), "ss", "6 of 6 have p = 0.03, and 0.06 in one of two rows");
    assert_eq!(judged([6, 6], [1, 1], [2, 0], chance), "ps", "a row without a pair that differs is in no correction");
    assert_eq!(judged([6, 6], [1, 1], [6, 2], [0.04, 1.0]), "bp", "what is shown costs the others nothing");
    assert_eq!(judged([7, 7], [1, 1], [2, 2], chance), "pp");
    assert_eq!(judged([7, 5], [1, 1], [2, 2], chance), "ps");
    assert_eq!(judged([5, 5], [4, 4], [2, 2], chance), "pp", "Student's test over runs has other limits");
    assert_eq!(judged([0, 7], [1, 1], [0, 2], chance), "np");
    // All untrained controllers together are another family.
    let pooled = df!(
        "pedestrian" => ["random", "intercept", "all untrained"],
        "runs" => [1_u32, 1, 2],
        "common_starts" => [6_u32, 6, 6],
        "fault_rate_difference" => [0.0, 0.0, 0.0],
        "fault_rate_p_holm" => [1.0, 1.0, 1.0],
        "fault_new" => [3_u64, 3, 5]
    );
    assert_eq!(letters(&pooled.unwrap(), gate), "ssp");
}

#[test]
fn shares_of_runs_and_deviations_are_no_shares_of_starts() {
    let searches = df!("runs" => [1_u32], "starts_mean" => [3.0], "falsified_share" => [0.0]).unwrap();
    assert_eq!(letters(&searches, "falsified_share > 0.5"), "p", "the number of runs counts");
    let cells = |runs: u32| {
        let none: [Option<f64>; 1] = [None];
        df!("runs" => [runs], "episodes" => [50_u32], "impact_speed_mps_sd" => none, "fault_rate_sd" => none).unwrap()
    };
    assert_eq!(letters(&cells(5), "impact_speed_mps_sd > 1"), "v", "nothing collided");
    assert_eq!(letters(&cells(5), "fault_rate_sd > 0.1"), "M");
    for column in ["impact_speed_mps_sd", "fault_rate_sd"] {
        let judged = gate(&format!("{column} > 0.1")).judge(&cells(1));
        let reason = judged[0].reason("").unwrap();
        assert_eq!(reason, format!("there is no `{column}`, since a single run has no deviation; give more `runs`"));
    }
}

#[test]
fn a_gate_that_can_never_be_true_is_refused() {
    for text in [
        "preventable_rate > 0.5 and preventable_rate < 0.1",
        "preventable_rate > 0 and preventable_rate <= 0",
        "fault_rate < 0",
        "fault_rate_wilson_high < 0",
        "errors > 0 and errors < 1",
        "errors == 0.5",
        "fault_rate_sd < 0",
        "beats_untrained == yes and beats_untrained != yes",
        "town == village and town == harbour",
        "max over pedestrians fault_rate > 0.5 and fault_rate < 0.4",
    ] {
        assert!(matches!(Gate::parse(text), Err(GateError::Never { .. })), "{text}");
    }
    for text in [
        "preventable_rate > 0.1 and preventable_rate < 0.5",
        "preventable_rate >= 0.1 and preventable_rate <= 0.1",
        "fault_rate <= 0",
        "errors > 0 and errors < 2",
        "fault_rate > 0.1 and preventable_rate < 0.1",
        "town != village and town != harbour",
        "beats_untrained != yes and beats_untrained != no",
    ] {
        assert!(Gate::parse(text).is_ok(), "{text}");
    }
    let comparison = comparison_reference(&[]);
    assert!(Gate::of_table("fault_rate_p_holm < 0", &comparison).is_err());
    assert!(Gate::of_table("fault_rate_difference < 0 and fault_rate_p_holm < 0.05", &comparison).is_ok());
    assert!(Gate::of_table("fault_rate_high < 0", &comparison).is_ok(), "the interval of a difference");
    let typo = Gate::parse("beats_untrained == ja").unwrap_err().to_string();
    assert!(typo.contains("write one of yes, no, unclear"), "{typo}");
}

#[test]
fn a_gate_over_controllers_judges_one_cell_of_each_place() {
    let rates: Vec<Option<f64>> = vec![Some(0.02), Some(0.15), Some(0.15), Some(0.03), None, None];
    let cells = df!(
        "town" => ["harbour", "harbour", "harbour", "village", "village", "quay"],
        "pedestrian" => ["trained", "intercept", "homing", "trained", "random", "random"],
        "preventable_rate_mean" => rates,
        "errors" => [0_u32, 2, 0, 0, 0, 0]
    )
    .unwrap();
    for (text, wanted) in [
        // A trained row that learnt nothing hides nothing.
        ("max over pedestrians preventable_rate > 0.05", "ebepem"),
        ("min over pedestrians preventable_rate < 0.025", "beepem"),
        ("max over pedestrians preventable_rate > 0.05 and pedestrian != intercept", "eebpem"),
        ("max over pedestrians preventable_rate > 0.05 and errors < 1", "epepem"),
        ("max over pedestrians preventable_rate > 0.05 and town == harbour", "ebeeee"),
    ] {
        assert_eq!(letters(&cells, text), wanted, "{text}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_the_column_meant_is_named() {
    let said = |text: &str| Gate::parse(text).unwrap_err().to_string();
    assert!(Gate::parse("preventable_rate_wilson_low > 0.05 and town == village").is_ok());
    let broken = Judged::Broken(vec![("preventable_rate_mean".into(), "0.06".into())]);
    assert_eq!(Gate::parse("preventable_rate > 0.05").unwrap().judge(&cells())[1], broken);
    for typo in ["preventible_rate", "preventable_rat"] {
        assert!(said(&format!("{typo} > 0.05")).contains("did you mean `preventable_rate`?"), "{typo}");
    }
    assert!(said("xyz > 1").contains("reports/README.md lists the metrics"));
    for text in ["", "preventable_rate", "preventable_rate = 1", "> 1", "preventable_rate >", "a > 1 and "] {
        assert!(matches!(Gate::parse(text), Err(GateError::Form { .. } | GateError::Column { .. })), "{text}");
    }
    assert!(said("preventable_rate > 5 %").contains("without a unit"));
    assert!(said("preventable_rate > 5").contains("shares from 0 to 1: write 5 % as 0.05"));
    assert!(said("preventable_rate > 0.5 or errors > 0").contains("for `or` write several gates"));
    assert!(said("preventable_rate > 0.5 && errors > 0").contains("`and` joins conditions"));
    assert!(said("town > a").contains("== or !="));
    assert!(said("max over pedestrians town == a").contains("only numbers"));
    let twice = "max over pedestrians collision_rate > 0 and min over pedestrians collision_rate > 0";
    assert!(matches!(Gate::parse(twice), Err(GateError::Extremes { .. })));
    for text in ["max over towns collision_rate > 0", "max over pedestrians > 0", "maximum collision_rate > 0"] {
        assert!(matches!(Gate::parse(text), Err(GateError::Form { .. })), "{text}");
    }
    assert!(Gate::parse("max over pedestrians preventable_rate_student_low > 0.05 and beats_untrained == yes").is_ok());
}

#[test]
fn old_failures_that_were_not_met_pass_no_gate() {
    let gate = Gate::of_table("still_faults > 0", &rechecked_reference()).unwrap();
    let judged = |still_faults: [u64; 2], not_met: [u64; 2]| {
        let all = [4_u64; 2];
        of_gate(&df!("failures" => all, "still_faults" => still_faults, "not_met" => not_met).unwrap(), &gate)
    };
    assert_eq!(judged([0, 0], [0, 0]), "pp");
    assert_eq!(judged([0, 0], [1, 0]), "up", "a warning");
    assert_eq!(judged([0, 0], [4, 0]), "up", "the other row was met");
    assert_eq!(judged([1, 0], [3, 4]), "bu");
    assert_eq!(judged([0, 0], [4, 4]), "AA", "nothing is known of any");
}

#[test]
fn a_test_with_a_case_that_was_not_run_has_no_score() {
    let score = [Some(0.9), Some(0.5), None];
    let cells = df!("score" => score, "passed" => [1.0, 0.75, 1.0], "not_tested" => [0.0, 0.0, 2.0]).unwrap();
    assert_eq!(letters(&cells, "score < 0.8"), "pbN");
    assert_eq!(letters(&cells, "passed < 1"), "pbN");
    assert_eq!(letters(&cells, "not_tested > 0"), "ppb");
    assert!(matches!(Gate::parse("passed < 5"), Err(GateError::Kind { .. })), "it is a share");
}

#[test]
fn a_rate_of_a_requirement_is_of_the_episodes_in_which_it_applied() {
    let rates = [Some(0.0), Some(0.0), None];
    let cells = df!(
        "episodes" => [60_u32; 3],
        "applied(slow)" => [40.0, 5.0, 0.0],
        "violation_rate(slow)" => rates
    );
    let cells = cells.unwrap();
    assert_eq!(letters(&cells, "violation_rate(slow) > 0.05"), "ptv", "5 of 60 show no rate of 0.05");
    let reason = gate("violation_rate(slow) > 0.05").judge(&cells)[2].reason(" in c").unwrap();
    assert_eq!(reason, "there is no violation_rate(slow), since it never applied in c");
    assert_eq!(letters(&cells, "applied(slow) < 10"), "pbb");
}
