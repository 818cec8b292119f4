use base::diagnostic::Diagnostic;
use base::signature::{Arguments, Distribution, Param, Signature, Type, Value};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::Declaration;
use world::env::{
    EgoSpeed, EgoStart, Measure, RoadShape, SpawnRule, TargetBox, TargetSide, TargetWalk, TestCase, TestCriterion,
};
use world::geometry::Pose;

/// Half the length of the longest car of the catalogue (m), for checks that do not know the car.
const LONGEST_HALF: f64 = 2.5;
/// The word of a test in which the target crosses the path of the car.
const CROSSING: &str = "crossing_test";

/// The kinds of `spawn` that are tests with a pedestrian target.
pub fn signatures() -> Vec<Signature> {
    let common = |speed: &'static str, headway: &'static str| {
        vec![
            Param::required(
                "meeting",
                Type::Pose,
                "The middle of the car's front when the car meets the target: on the middle of a straight lane and along it.",
            ),
            Param::required(
                "test_speeds",
                Type::List(Box::new(Type::positive(Dimension::SPEED))),
                "Speeds that the driver holds before the start. The cases are all pairs of a speed and an overlap, in this order; episodes take them in turn.",
            ),
            Param::required(
                "overlaps",
                Type::List(Box::new(Type::share())),
                "Places on the car's front that meet the target's impact point, as shares of its width: from the side of the target, or from the right along the path.",
            ),
            Param::with_default(
                "walking_speed",
                Type::non_negative(Dimension::SPEED),
                speed,
                "Speed of the `scripted` target. Other controllers choose speed and heading of the line by their first command.",
            ),
            Param::with_default(
                "reach",
                Type::non_negative(Dimension::LENGTH),
                "1 m",
                "Way within which the target reaches its speed, at a constant acceleration. The body of the adversary must be able to: `ramp: 0 s`.",
            ),
            Param::with_default(
                "headway",
                Type::positive(Dimension::TIME),
                headway,
                "Time from the start to the meeting if the car keeps its speed. A target whose way takes longer starts nearer.",
            ),
            Param::with_default(
                "target",
                Type::Choice(&["adult", "child"]),
                "adult",
                "The box of the target with its impact point: 0.6 m by 0.5 m and 0.36 m behind its front, or 0.711 m by 0.298 m and 0.396 m.",
            ),
            Param::with_default(
                "criterion",
                Type::Choice(&["no_contact", "euro_ncap", "un_r152"]),
                "no_contact",
                "How reports judge an impact speed: passed without contact, the colours of Euro NCAP, or the limits of UN R152 for M1 and N1.",
            ),
        ]
    };
    let mut crossing = common("5 km/h", "6 s");
    crossing.extend([
        Param::with_default(
            "from",
            Type::Choice(&["right", "left"]),
            "right",
            "Side of the car from which the target comes.",
        ),
        Param::with_default(
            "distance",
            Type::positive(Dimension::LENGTH),
            "4 m",
            "Distance of the target's start from the line on which the middle of the car drives.",
        ),
        Param::with_default(
            "approach",
            Type::Distribution { dimension: Dimension::RATIO, min: 0.05, max: 2.0 },
            "100 percent",
            "Share of its way that the target starts from, drawn for each episode.",
        ),
    ]);
    vec![
        Signature::new(
            CROSSING,
            "A test in which a target crosses the path of the car on a straight line. The target is released once, so that it would meet the stated share of the car's width if the car kept its speed.",
            crossing,
        ),
        Signature::new(
            "along_test",
            "A test in which a target walks ahead in the path of the car, or stands there at a `walking_speed` of 0.",
            common("5 km/h", "6 s"),
        ),
    ]
}

/// The rule for a declaration of one of these kinds; none after reporting what is wrong.
pub fn lower(declaration: &Declaration, said: &mut Vec<Diagnostic>) -> Option<SpawnRule> {
    let (block, arguments) = (&declaration.block, &declaration.block.arguments);
    let crossing = declaration.kind == CROSSING;
    let overlaps = numbers(arguments, "overlaps");
    let case = |test_speed: f64| overlaps.iter().map(move |overlap| TestCase { test_speed, overlap: *overlap });
    let cases: Vec<TestCase> = numbers(arguments, "test_speeds").into_iter().flat_map(case).collect();
    let Value::Pose(x, y, yaw) = *arguments.value("meeting") else { panic!("checked: a pose") };
    let (distance, approach, from) = if crossing {
        let from = if arguments.choice("from") == "left" { TargetSide::Left } else { TargetSide::Right };
        (arguments.number("distance"), arguments.distribution("approach").clone(), from)
    } else {
        (0.0, Distribution::Constant(1.0), TargetSide::Along)
    };
    let walk = TargetWalk {
        meeting: Pose::new(x, y, yaw),
        from,
        cases,
        speed: arguments.number("walking_speed"),
        distance,
        approach,
        reach: arguments.number("reach"),
        headway: arguments.number("headway"),
        target: if arguments.choice("target") == "child" { TargetBox::CHILD } else { TargetBox::ADULT },
        criterion: match arguments.choice("criterion") {
            "euro_ncap" => TestCriterion::EuroNcap,
            "un_r152" => TestCriterion::UnR152,
            _ => TestCriterion::NoContact,
        },
    };
    let slow = walk.cases.iter().map(|case| case.test_speed).fold(f64::INFINITY, f64::min);
    if !crossing && walk.speed >= slow {
        let message = format!(
            "a target that walks at {:.1} km/h is not reached by a car at {:.1} km/h",
            walk.speed * 3.6,
            slow * 3.6
        );
        said.push(
            diagnostics::contradiction(block.place("test_speeds"), message)
                .label(block.place("walking_speed"), "its speed is this"),
        );
        return None;
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
        said.push(diagnostics::contradiction(block.place("headway"), message).help(help));
        return None;
    }
    let starts = walk.cases.iter().map(|case| walk.car(case, LONGEST_HALF)).chain([walk.meeting]).collect();
    Some(SpawnRule {
        name: declaration.name.clone(),
        bearing: Distribution::Constant(0.0),
        distance: Distribution::Constant((slow * walk.headway).max(8.0)),
        measure: Measure::Range,
        ego_start: EgoStart::Poses(starts),
        test_speed: None,
        ego_route: Vec::new(),
        road_shape: RoadShape::Any,
        ego_speed: EgoSpeed::Steady,
        heading: None,
        constraints: Vec::new(),
        target_walk: Some(walk),
        given_path: None,
    })
}

/// The quantities of a list.
pub(super) fn numbers(arguments: &Arguments, key: &str) -> Vec<f64> {
    let number = |value: &Value| match value {
        Value::Number(number) => *number,
        other => panic!("checked: a quantity, not {other:?}"),
    };
    arguments.list(key).iter().map(number).collect()
}
