use base::diagnostic::Diagnostic;
use base::signature::Distribution;
use base::{choice, keys};
use episode::{
    EgoSpeed, EgoStart, Measure, RoadShape, SpawnRule, TargetBox, TargetSide, TargetWalk, TestCase, TestCriterion,
    euro_ncap_bands,
};
use lang::diagnostics;
use lang::hir::{Block, Declaration};

/// Half the length of the longest car of the catalogue (m), for checks that do not know the car.
const MAX_HALF_LENGTH: f64 = 2.5;
choice! {
    /// The target of a test.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Target {
        Adult = "adult",
        Child = "child",
    }
}

keys! {
    /// What all tests take.
    pub struct TestKeys {
        /// The middle of the car's front when the car meets the target: on the middle of a straight lane and along it.
        meeting: [f64; 3],
        /// Speeds that the driver holds before the start. The cases are all pairs of a speed and an overlap, in this order;
        /// episodes take them in turn.
        test_speeds: Vec<f64> as positive(SPEED),
        /// Places on the car's front that meet the target's impact point, as shares of its width: from the side of the target,
        /// or from the right along the path.
        overlaps: Vec<f64> as share(),
        /// Speed of the `scripted` target. Other pedestrians choose speed and heading of the line by their first command.
        walking_speed: f64 as non_negative(SPEED) = "5 km/h",
        /// Way within which the target reaches its speed, at a constant acceleration. The body must be able
        /// to: `ramp: 0 s`.
        reach: f64 as non_negative(LENGTH) = "1 m",
        /// Time from the start to the meeting if the car keeps its speed. A target whose way takes longer starts nearer.
        headway: f64 as positive(TIME) = "6 s",
        /// The box of the target with its impact point: 0.6 m by 0.5 m and 0.36 m behind its front, or 0.711 m by 0.298 m and
        /// 0.396 m.
        target: Target = "adult",
        /// How reports judge an impact speed: passed without contact, the colours of Euro NCAP 2026, or the limits of UN R152 for M1
        /// and N1.
        criterion: TestCriterion = "no_collision",
    }
}

keys! {
    /// A test in which a target crosses the path of the car on a straight line. The target is released once, so that it would
    /// meet the stated share of the car's width if the car kept its speed.
    pub struct CrossingTestKeys = "crossing_test" {
        ..test: TestKeys,
        /// Side of the car from which the target comes.
        from: TargetSide as Choice(&["right", "left"]) = "right",
        /// Distance of the target's start from the line on which the middle of the car drives.
        distance: f64 as positive(LENGTH) = "4 m",
        /// Share of its way that the target starts from, drawn for each episode.
        approach: Distribution as drawn(RATIO, 0.05, 2.0) = "100 percent",
        /// Whether parked cars hide the target's start from the car. A town without such cars is refused.
        hidden: bool = "false",
    }
}

keys! {
    /// A test in which a target walks ahead in the path of the car, or stands there at a `walking_speed` of 0.
    pub struct AlongTestKeys = "along_test" {
        ..test: TestKeys,
    }
}

/// The rule of a test in which the target crosses; `None` after reporting what is wrong.
pub fn crossing(declaration: &Declaration, said: &mut Vec<Diagnostic>) -> Option<SpawnRule> {
    let CrossingTestKeys { test, from, distance, approach, hidden } = declaration.block.keys();
    let rule = lower(declaration, test, from, distance, approach, said)?;
    Some(SpawnRule { target_walk: rule.target_walk.map(|walk| TargetWalk { hidden, ..walk }), ..rule })
}

/// The rule of a test in which the target walks ahead; `None` after reporting what is wrong.
pub fn along(declaration: &Declaration, said: &mut Vec<Diagnostic>) -> Option<SpawnRule> {
    let AlongTestKeys { test } = declaration.block.keys();
    lower(declaration, test, TargetSide::Along, 0.0, Distribution::Constant(1.0), said)
}

fn lower(
    declaration: &Declaration,
    test: TestKeys,
    from: TargetSide,
    distance: f64,
    approach: Distribution,
    said: &mut Vec<Diagnostic>,
) -> Option<SpawnRule> {
    let block = &declaration.block;
    let case = |test_speed: &f64| {
        let test_speed = *test_speed;
        test.overlaps.iter().map(move |overlap| TestCase { test_speed, overlap: *overlap })
    };
    let walk = TargetWalk {
        meeting: test.meeting.into(),
        from,
        cases: test.test_speeds.iter().flat_map(case).collect(),
        speed: test.walking_speed,
        distance,
        approach,
        reach: test.reach,
        headway: test.headway,
        target: match test.target {
            Target::Adult => TargetBox::ADULT,
            Target::Child => TargetBox::CHILD,
        },
        hidden: false,
        criterion: test.criterion,
    };
    let slow = walk.cases.iter().map(|case| case.test_speed).fold(f64::INFINITY, f64::min);
    if let Some(fault) = fault(block, &walk, slow) {
        said.push(fault);
        return None;
    }
    let starts = walk.cases.iter().map(|case| walk.car(case, MAX_HALF_LENGTH)).chain([walk.meeting]).collect();
    Some(SpawnRule {
        name: declaration.name.clone(),
        bearing: Distribution::Constant(0.0),
        distance: Distribution::Constant((slow * walk.headway).max(8.0)),
        measure: Measure::Range,
        ego_start: EgoStart::Poses(starts),
        test_speed: None,
        ego_route: Vec::new(),
        road_shape: RoadShape::Any,
        lane_width: 0.0,
        ego_speed: EgoSpeed::Steady,
        heading: None,
        constraints: Vec::new(),
        target_walk: Some(walk),
        given_path: None,
    })
}

/// Why a test cannot take place, if it cannot; `slow` is the lowest of its speeds.
fn fault(block: &Block, walk: &TargetWalk, slow: f64) -> Option<Diagnostic> {
    let crossing = walk.from != TargetSide::Along;
    if !crossing && walk.speed >= slow {
        let message = format!(
            "a target that walks at {:.1} km/h is not reached by a car at {:.1} km/h",
            walk.speed * 3.6,
            slow * 3.6
        );
        let slow = diagnostics::contradiction(block.place("test_speeds"), message);
        return Some(slow.label(block.place("walking_speed"), "its speed is this"));
    }
    let mut speeds = walk.cases.iter().map(|case| case.test_speed);
    if let Some(speed) = speeds.find(|speed| euro_ncap_bands(*speed).is_none())
        && walk.criterion == TestCriterion::EuroNcap
    {
        let message = format!("Euro NCAP has no colours at {:.1} km/h", speed * 3.6);
        let help = "give 10, 20, 30, 40 km/h, or 50 km/h and more; or another `criterion`, such as `no_collision`";
        return Some(diagnostics::contradiction(block.place("test_speeds"), message).help(help));
    }
    let needed = (walk.distance + walk.reach) / walk.speed.max(1e-9);
    if crossing && (walk.speed == 0.0 || needed > walk.headway) {
        let message = if walk.speed == 0.0 {
            "a target that crosses must walk: `walking_speed` is 0".to_string()
        } else {
            format!(
                "the target needs about {needed:.1} s to the middle of the path, and the car comes after {:.1} s",
                walk.headway
            )
        };
        let help = format!(
            "make `headway` at least {:.1} s, or use `along_test` for a target that stands",
            needed.min(60.0) + 0.1
        );
        return Some(diagnostics::contradiction(block.place("headway"), message).help(help));
    }
    None
}
