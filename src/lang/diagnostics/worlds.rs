//! Errors of the described world: maps, towns, starts, external drivers, values that contradict each other.

use base::diagnostic::{Diagnostic, Span};
use base::signature::short;

diagnostics! {
    unusable_map(path: &str, reason: &str) = error("unusable-map", "cannot use the map `{path}`: {reason}");
    unbuildable_town(reason: &str) = error("unbuildable-town", "this town cannot be built: {reason}");
    nothing_to_compare() = warning("unused", "these figures are compared with nothing")
        .here("they belong to rewards, and this campaign trains no pedestrian for a reward");
    sensors_without_effect(kind: &str) = warning("unused", "these sensors have no effect")
        .here(format!("`{kind}` perceives no actors"))
        .help("remove the key, or use a driver that perceives actors, such as `idm`");
    other_tick(policy: &str, made_for: f64, tick: f64, episode: Span) = warning("other-tick", "`{policy}` is made for ticks of {made_for} s")
        .label(episode, format!("ticks here are {tick} s long"))
        .help("it counts its delays in ticks, so it reacts faster or slower than its original");
    unplaceable(town: &str, reason: &str) = error("unplaceable", "no episode can start in `{town}`: {reason}")
        .help("`falsify check --sample 1000` shows what each constraint leaves");
    goalless_search(requirement: &str) = warning("goalless-search", "this search looks for collisions alone, whatever the campaign requires")
        .help(format!("write `goal: {requirement}` to look for its violations"));
    paid_waiting(reward: &str, waiting: f64, hit: f64) = warning("paid-waiting", "`{reward}` pays more for an episode without a touch than for any touch")
        .here(format!("at least {} in a whole episode; a touch earns at most {}", short(waiting), short(hit)))
        .help("a learner will keep away from the car; pay less for a step, or more for a touch");
    never_positive(reward: &str) = warning("never-positive", "no episode can earn more than 0 with `{reward}`")
        .here("every clause pays 0 or less")
        .help("a learner or a search then looks for the episode that costs least: pay for what the pedestrian is to reach");
    small_budget(budget: u64, ticks: u32) = warning("small-budget", "a budget of {budget} ticks does not hold one whole episode")
        .here(format!("an episode may last {ticks} ticks"))
        .help("what a search does not find with so few ticks says nothing about the driver");
    rare_starts(town: &str, found: &str) = warning("rare-starts", "few starts in `{town}` satisfy all constraints: {found}")
        .help("a condition that bounds `bearing`, `distance` or `ego_speed` alone, such as `distance > 10 m`, costs nothing")
        .help("drawing a start takes long; `falsify check --sample 1000` shows what each constraint leaves");
    unreachable(town: &str, speed: f64, time: f64) = warning("unreachable", "no pedestrian can meet the car in `{town}` before the episode ends")
        .here(format!("the episode lasts {} s, and the pedestrian walks at most {speed:.1} m/s", short(time)))
        .help("give a shorter `distance`, more `ticks` of the `episode`, or a higher `speed` of the `body`");
    partial_test(episodes: u32, cases: u32) = warning("partial-test", "this is not a multiple of the cases of the test")
        .here(format!("{episodes} episode{} for {cases} cases", if episodes == 1 { "" } else { "s" }))
        .help(format!("leave `episodes` out: one for each case is the default; or give a multiple of {cases}"));
    untested(test: &str) = warning("untested", "nobody walks the test `{test}` as it states")
        .here("so it has no row in the table `protocol`")
        .help("name `scripted` here, too");
    sees_through(driver: &str, test: &str) = warning("sees-through", "`{driver}` sees the target of `{test}` through the parked cars")
        .here("its sensors are `perfect`, or have no `least_visible`")
        .help("give the driver sensors that obstacles hide actors from: `sensors: sight` of `std/sensors.scn`");
    far_from_streets(far: f64) = warning("out-of-reach", "this is more than {far} m from every street").here("no car passes it or sees it there");
    sign_off_lanes() = warning("out-of-reach", "this sign is on no driving lane")
        .here("no car passes it")
        .help("`at` is the middle of the lane where the limit begins");
    unusable_command(command: &str, reason: &str) = error("unusable-command", "cannot use the command `{command}`: {reason}")
        .help("the command is split at blanks; single quotes keep blanks together; no shell runs it");
    other_weights(path: &str) = warning("other-weights", "`{path}` does not hold the published weights");
    slow_model(path: &str, seconds: f64) = warning("slow-model", "the model `{path}` takes {seconds:.1} s for a decision")
        .here(format!("an episode with 600 of them takes {:.0} minutes", seconds * 10.0))
        .help("use a smaller network, or one without loops and wide layers");
    untrusted_model(path: &str, reason: &str) = error("unusable-model", "cannot use the model `{path}`: {reason}")
        .help("use a smaller network, or run it in a program of your own (`external`)");
    contradiction(message: String) = error("contradiction", "{message}");
    two_speeds() = error("contradiction", "the ego has either an `ego_speed` or a `test_speed`").help("remove one of them");
    own_speed() = error("contradiction", "`ego_speed` is not drawn here: the driver comes at its own speed")
        .help("draw it, as in `ego_speed: 5 m/s .. 8 m/s`");
    two_starts(lane: Span) = error("contradiction", "the ego begins either on `ego_poses` or on an `ego_lane`, not on both").label(lane, "the lane is here");
    no_area(distance: Span) = error("contradiction", "places are uniform over the ground only when the distance is a range `low .. high`")
        .label(distance, "this is not a range");
    unfit_training(needed: &str) = error("contradiction", "a driver sees one state at a time and scales it itself, so its training needs {needed}");
    scripted_attack() = error("contradiction", "a target walks as its test states, so nothing can attack a driver from these starts")
        .help("use a `spawn` with ranges");
    test_of_repair() = error("contradiction", "the driver is repaired in this town, so a test in it shows less than it seems to")
        .help("name a town that is not among `towns`");
    trained_without_training() = error("contradiction", "this campaign has no `train` block, so it has no trained pedestrians to evaluate")
        .help("use `random`, `homing` or `intercept` instead: `pedestrians: [random]`");
    unshared_policy() = error("contradiction", "`policies: shared` of the training needs pedestrians that see and choose the same")
        .help("give the trained roles of the cast one `body`, or write `policies: each`");
    removal_search() = error("contradiction", "`credit: removal` runs episodes again, in ticks that the budget of a search does not have")
        .help("give the `method` a `training` with `credit: team` or `credit: own`");
    uncopied_removal() = error("contradiction", "`credit: removal` runs an episode again from its start, and a driver that is a program cannot be copied")
        .help("`credit: team` and `credit: own` need no copy");
    bound_too_long(formula: Span, name: &str, end: f64, length: f64) = error("contradiction",
        "a bound of `{name}` ends {} s after the start, and the episode lasts {} s", short(end), short(length))
        .label(formula, "the formula is here")
        .help("samples after the end do not exist: shorten the bound, or give the `episode` more `ticks`");
    bound_between_ticks(formula: Span, name: &str, bound: &str, tick: f64) = error("contradiction", "no tick lies in the bound `{bound}` of `{name}`")
        .label(formula, "the formula is here")
        .help(format!("ticks are {} s apart; the present sample is at 0 s", short(tick)));
    never_applies(name: &str, part: &str, towns: &[&str], here: &str) = warning("never-applies",
        "`{name}` is about {part}, and there are none in `{}`", towns.join("`, `"))
        .here(here)
        .help(format!("use a town with {part}"));
    unreachable_speed(name: &str, comparison: &str, limit: f64) = warning("unreachable-speed",
        "`{comparison}` of `{name}` is the same in every episode: no car here drives so fast")
        .here(format!("the highest speed limit is {} km/h", short((limit * 3.6).round())))
        .help("see whether the unit is the one that you mean: 20 m/s are 72 km/h");
    unfit_pedestrian(controller: &str, adversary: &str, reason: &str) = error("unfit-pedestrian",
        "`{controller}` cannot walk as the `body` `{adversary}`: {reason}")
        .help("give the campaign, or `bodies` of this block, the `body` of its training");
}

/// A value lies above one that it must not exceed.
pub fn not_rising(span: Span, low: &str, high: &str, other: Option<Span>) -> Diagnostic {
    let diagnostic = contradiction(span, format!("`{low}` is more than `{high}`"));
    match other {
        Some(other) => diagnostic.label(other, format!("`{low}` is given here")),
        None => diagnostic,
    }
}

/// Parts of a map were skipped or guessed.
pub fn map_warning(span: Span, path: &str, warnings: &[String]) -> Diagnostic {
    let parts = if warnings.len() == 1 { "one part was".to_string() } else { format!("{} parts were", warnings.len()) };
    let mut diagnostic =
        Diagnostic::warning("map-warning", span, format!("{parts} skipped or guessed in the map `{path}`"));
    for warning in warnings.iter().take(3) {
        diagnostic = diagnostic.help(warning.clone());
    }
    diagnostic.help(format!("`falsify preview {path}` lists them all"))
}

/// A bend, or a turn in a junction, asks a car at a speed limit (m/s) for more lateral acceleration than drivers allow: radius of the lane (m), and
/// both accelerations (m/s²).
pub fn fast_bend(span: Span, in_junction: bool, limit: f64, radius: f64, [lateral, most]: [f64; 2]) -> Diagnostic {
    let (place, key) = if in_junction { ("turn in a junction", "corner_radius") } else { ("bend", "bend_radius") };
    let (limit, most) = (short((limit * 3.6).round()), short(most));
    Diagnostic::warning("fast-bend", span, format!("the speed limit, {limit} km/h, is too high for a {place} of the street"))
        .here(format!("{lateral:.1} m/s^2 sideways on a lane with a radius of {radius:.1} m; {most} is the most"))
        .help(format!("a driver that does not slow down there leaves the road: state a lower `speed_limit`, or give the town a larger `{key}`"))
}

/// A car that brakes for nobody passes cases of a test: their number, and that of all cases.
pub fn idle_test(span: Span, test: &str, passed: usize, cases: usize) -> Diagnostic {
    let message = format!("a car that never brakes passes {passed} of the {cases} cases of `{test}`");
    let idle = if passed == cases {
        Diagnostic::error("idle-test", span, message).here("so it tests nothing")
    } else {
        Diagnostic::warning("idle-test", span, message).here("they count as not run, so there is no score")
    };
    idle.help("car and target do not meet: give the `episode` more `ticks` than the `headway` takes, and a longer road")
}

/// Whether a diagnostic reports that no start is possible.
pub fn is_unplaceable(diagnostic: &Diagnostic) -> bool {
    diagnostic.code == "unplaceable"
}

/// A scenario names a program to be started, and the user has not allowed that: one error for all programs, or one warning where nothing is run.
pub fn external_not_allowed(said: &mut Vec<Diagnostic>, span: Span, command: &str, is_error: bool) {
    if let Some(known) = said.iter_mut().find(|each| each.code == "external-not-allowed") {
        if known.primary.span != span && known.labels.iter().all(|label| label.span != span) {
            *known = known.clone().label(span, "and this one");
        }
        return;
    }
    let text = format!("this scenario wants to start the program `{command}`");
    let first = match is_error {
        true => Diagnostic::error("external-not-allowed", span, text),
        false => Diagnostic::warning("external-not-allowed", span, text),
    };
    let first = first
        .help("`--allow-external` (in Python `allow_external=True`) lets scenarios start programs; give it only with files that you trust");
    said.push(first);
}

/// A model of a learnt driver cannot be used. Without a file, the help says where it is looked for.
pub fn unusable_model(span: Span, path: &str, reason: &str, is_missing: bool) -> Diagnostic {
    let unusable = Diagnostic::error("unusable-model", span, format!("cannot use the model `{path}`: {reason}"));
    if is_missing { unusable.help("paths are relative to the folder of the file that names them") } else { unusable }
}
