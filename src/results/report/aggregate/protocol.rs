use crate::jobs::SearchResult;
use crate::record::columns::{DRIVER, RUN_ID, TOWN};
use crate::record::{EpisodeTable, Table, entries};
use base::choice;
use base::statistics::{clopper_pearson, mean};
use compile::{Campaign, Evaluation};
use episode::{TargetWalk, TestCriterion, euro_ncap_bands};

/// The result of a driver in one case of a protocol's test.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolCell {
    /// The run: the evaluation, or empty for the searches within a layer.
    pub run_id: String,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    pub test: String,
    /// Name of the search that looked for the worst result; `None` for the nominal test.
    pub falsifier: Option<String>,
    /// The test speed (m/s).
    pub test_speed: f64,
    /// The overlap as a share of the car's width.
    pub overlap: f64,
    /// The speed at the start of the worst episode (m/s); `None` for searches.
    pub driven_speed: Option<f64>,
    /// Number of different episodes, or of searches.
    pub episodes: u32,
    /// How many of them the protocol does not pass.
    pub not_passed: u32,
    /// The greatest impact speed (m/s), along the path without the target's own speed; 0 without contact. `None` if no episode ended.
    pub impact_speed: Option<f64>,
    /// Whether an episode has no result: an error, of its driver for example, or it is left out.
    pub failed: bool,
    /// The friction of the road; `None` if the car's own figures hold.
    pub friction: Option<f64>,
    /// How the protocol judges.
    pub criterion: TestCriterion,
    /// The name of the worst collision, for `replay`; `None` without one.
    pub worst: Option<String>,
    /// Where it is tested, to compare the nominal test with its layer.
    meeting: [i64; 5],
    /// The car, the pedestrian and the world.
    setup: [String; 3],
}

choice! {
    /// The colour of a result.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Colour {
        /// Avoided.
        Green = "green",
        /// Up to 10 km/h at 50 km/h or more.
        Yellow = "yellow",
        /// Up to 20 km/h there, 10 at 40 km/h.
        Orange = "orange",
        /// Up to 30 km/h there, 20 at 40 km/h, 10 at 30 km/h.
        Brown = "brown",
        /// More.
        Red = "red",
    }
}

/// The tolerance of the test speed (m/s): 1 km/h.
const HELD: f64 = 1.0 / 3.6;

/// The number of test speeds of Euro NCAP's tests, and the friction of the library's track.
const SPEEDS: usize = 6;
const FRICTION: f64 = 0.9;

impl Colour {
    /// The share of the points of a cell.
    pub fn score(self) -> f64 {
        match self {
            Self::Green => 1.0,
            Self::Yellow => 0.75,
            Self::Orange => 0.5,
            Self::Brown => 0.25,
            Self::Red => 0.0,
        }
    }
}

impl ProtocolCell {
    /// The colour of Euro NCAP ([`euro_ncap_bands`]); `None` for other protocols, and at a test speed without colours.
    pub fn colour(&self) -> Option<Colour> {
        let impact = self.impact_speed.filter(|_| self.criterion == TestCriterion::EuroNcap)?;
        let [yellow, orange, brown] = euro_ncap_bands(self.test_speed)?;
        Some(match impact {
            impact if impact <= 0.0 => Colour::Green,
            impact if impact <= yellow => Colour::Yellow,
            impact if impact <= orange => Colour::Orange,
            impact if impact <= brown => Colour::Brown,
            _ => Colour::Red,
        })
    }

    /// Whether the driver held the test speed within 1 km/h; `None` for searches.
    pub fn is_held(&self) -> Option<bool> {
        self.driven_speed.map(|driven| (driven - self.test_speed).abs() <= HELD)
    }

    /// Whether it has a result at the test speed, which counts.
    pub fn is_tested(&self) -> bool {
        self.is_run() && self.is_held() != Some(false)
    }

    /// What differs from the protocols' tests in these cells of a row, whose result is not comparable then: `3 of 6 speeds, no friction`.
    pub fn caveats(row: &[&Self]) -> String {
        let is_euro_ncap = row.iter().any(|cell| cell.criterion == TestCriterion::EuroNcap);
        let speeds = (is_euro_ncap && row.len() < SPEEDS).then(|| format!("{} of {SPEEDS} speeds", row.len()));
        let friction = match row.first().and_then(|cell| cell.friction) {
            None => Some("no friction".to_string()),
            Some(friction) => (friction != FRICTION).then(|| format!("friction {friction}")),
        };
        [speeds, friction].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// The greatest impact speed that passes (m/s).
    pub fn limit(&self) -> f64 {
        self.criterion.limit(self.test_speed)
    }

    /// Whether the protocol passes the result.
    pub fn passes(&self) -> Option<bool> {
        self.impact_speed.map(|impact| impact <= self.limit())
    }

    /// Whether it has a result.
    pub fn is_run(&self) -> bool {
        self.impact_speed.is_some()
    }

    /// The one-sided 95 % upper bound of the share of repetitions that are not passed; `None` for searches, which choose what they run, and for a single
    /// episode, also if it was repeated: it says nothing about others.
    pub fn not_passed_at_most(&self) -> Option<f64> {
        let is_sample = self.falsifier.is_none() && self.episodes > 1;
        is_sample.then(|| clopper_pearson(self.not_passed.into(), self.episodes.into(), 0.1).1)
    }

    /// Whether two results belong to the same cell of the same test.
    pub fn is_same_case(&self, other: &Self) -> bool {
        (&self.policy, self.meeting) == (&other.policy, other.meeting)
            && (self.test_speed, self.overlap) == (other.test_speed, other.overlap)
    }

    /// Whether another result of the nominal test is of the same case in the same setup, and stands for this one, which was not run.
    pub(super) fn stands_for(&self, other: &Self) -> bool {
        let is_same = (&self.town, &self.test, &self.setup) == (&other.town, &other.test, &other.setup);
        is_same && self.is_same_case(other) && self.is_run() && !other.is_run() && !other.failed
    }

    /// Whether another result is the same one under the name of another run.
    pub(super) fn repeats(&self, other: &Self) -> bool {
        let (run_id, worst, setup) = (self.run_id.clone(), self.worst.clone(), self.setup.clone());
        let named = Self { run_id, worst, setup, ..other.clone() };
        *self == named
    }

    fn new(names: (&str, &str, &str, &str), walk: &TargetWalk, case: usize) -> Self {
        let (run_id, town, policy, test) = names;
        let case = &walk.cases[case];
        let millimetres = |metres: f64| (metres * 1e3).round() as i64;
        let meeting = &walk.meeting;
        Self {
            run_id: run_id.into(),
            town: town.into(),
            policy: policy.into(),
            test: test.into(),
            falsifier: None,
            test_speed: case.test_speed,
            overlap: case.overlap,
            driven_speed: None,
            episodes: 0,
            not_passed: 0,
            impact_speed: None,
            failed: false,
            friction: None,
            criterion: walk.criterion,
            worst: None,
            setup: Default::default(),
            meeting: [
                millimetres(meeting.x),
                millimetres(meeting.y),
                walk.from as i64,
                millimetres(walk.target.half_length),
                millimetres(walk.speed),
            ],
        }
    }

    /// Takes the result of an episode, or of a search.
    fn note(&mut self, impact: f64, driven: Option<f64>, name: impl FnOnce() -> Option<String>) {
        self.episodes += 1;
        self.not_passed += u32::from(impact > self.limit());
        if self.impact_speed.is_none_or(|worst| impact > worst) {
            (self.impact_speed, self.driven_speed) = (Some(impact), driven);
            self.worst = name().filter(|_| impact > 0.0);
        }
    }
}

/// The mean of the scores of cells; `None` if one of them was not run at the test speed, or has no colour.
pub fn score<'a>(cells: impl Iterator<Item = &'a ProtocolCell>) -> Option<f64> {
    let score = |cell: &ProtocolCell| cell.colour().filter(|_| cell.is_tested()).map(Colour::score);
    mean(cells.map(score).collect::<Option<Vec<f64>>>()?)
}

/// The share of the cells with a result at the test speed that the protocol passes; `None` without any.
pub fn passed_share(cells: &[ProtocolCell]) -> Option<f64> {
    let passed = cells.iter().filter(|cell| cell.is_tested()).filter_map(ProtocolCell::passes);
    mean(passed.map(|passed| f64::from(u8::from(passed))))
}

/// The results of an evaluation of scripted targets, a cell for each case of its test, while its episodes are added.
pub(super) struct ProtocolRun<'a> {
    id: String,
    walk: &'a TargetWalk,
    /// Which cases can fail ([`episode::Scenario::decisive_cases`]). The others count as not run.
    decisive: Vec<bool>,
    cells: Vec<ProtocolCell>,
}

impl<'a> ProtocolRun<'a> {
    /// Starts without any episode; `None` for other evaluations.
    pub fn new(evaluation: &'a Evaluation) -> Option<Self> {
        let spawn = &evaluation.scenario.spawn;
        let walk = spawn.target_walk.as_ref().filter(|_| evaluation.controller.name() == "scripted")?;
        let id = evaluation.origin.id.to_string();
        let names = (id.as_str(), &*evaluation.town, &*evaluation.policy, spawn.name.as_str());
        let setup = [&evaluation.vehicle, &evaluation.adversary, &evaluation.world].map(ToString::to_string);
        let friction = evaluation.scenario.episode.friction;
        let cell = |case| ProtocolCell { setup: setup.clone(), friction, ..ProtocolCell::new(names, walk, case) };
        let cells = (0..walk.cases.len()).map(cell).collect();
        Some(Self { id, walk, decisive: evaluation.scenario.decisive_cases(), cells })
    }

    /// Adds episodes: a part of the table of the run, and which of its rows repeat none before.
    pub fn add(&mut self, table: &EpisodeTable<'_>, new: &[bool]) {
        for row in table.rows() {
            let episode = table.episode(row);
            let case = episode as usize % self.cells.len();
            if !table.counts(row) {
                self.cells[case].failed = true;
                continue;
            }
            // Repeating an episode to the bit says nothing.
            if !new[row] || !self.decisive[case] {
                continue;
            }
            let impact =
                table.impact_speed(row).map_or(0.0, |speed| self.walk.judged_speed(speed, self.walk.command()));
            let name = || Some(format!("{}:{episode}", self.id));
            self.cells[case].note(impact, Some(table.spawn(row).ego_speed), name);
        }
    }

    pub fn cells(self) -> Vec<ProtocolCell> {
        self.cells
    }
}

/// The worst results that searches found within the layers of tests: a cell for each driver, search and case.
pub fn layer_cells(campaign: &Campaign, searches: &[SearchResult]) -> Vec<ProtocolCell> {
    let mut all: Vec<ProtocolCell> = Vec::new();
    for result in searches {
        let Some(search) = campaign.all::<compile::Search>().find(|search| search.key == result.key) else { continue };
        let spawn = &search.scenario.spawn;
        let Some(walk) = &spawn.target_walk else { continue };
        let names = ("", search.key.town.as_str(), search.key.policy.as_str(), spawn.name.as_str());
        let decisive = search.scenario.decisive_cases();
        for (case, is_decisive) in decisive.into_iter().enumerate() {
            let mut cell = ProtocolCell::new(names, walk, case);
            cell.falsifier = Some(search.key.falsifier.clone());
            let here = |start: u64| (start % walk.cases.len() as u64) as usize == case;
            let failures = result.spent.failures.iter().enumerate().filter(|(_, failure)| here(failure.start));
            let judged = failures.filter_map(|(number, failure)| {
                let target = failure.commands.first().copied().unwrap_or_default();
                Some((walk.judged_speed(failure.outcome.impact_speed()?, target), Some(number)))
            });
            let (worst, number) = judged.fold((0.0, None), |worst, each| if each.0 > worst.0 { each } else { worst });
            let name = || number.map(|number| format!("{}:{number}", search.origin.id));
            if !result.spent.starts.iter().any(here) || worst == 0.0 && !is_decisive {
                continue;
            }
            match all.iter_mut().find(|known| known.falsifier == cell.falsifier && known.is_same_case(&cell)) {
                Some(known) => known.note(worst, None, name),
                None => {
                    cell.note(worst, None, name);
                    all.push(cell);
                }
            }
        }
    }
    all
}

/// The name of the table of protocols.
pub const PROTOCOL: &str = "protocol";

/// The cells as a table, one row each.
pub fn protocol_table() -> Table<'static, ProtocolCell> {
    let doc = "One row for each case of a test protocol and driver: the worst result of the nominal test, and the worst that each search found within its layers.";
    Table::new(PROTOCOL, doc).columns(entries! { row: &ProtocolCell;
        RUN_ID = row.run_id.clone();
        TOWN = row.town.clone();
        DRIVER = row.policy.clone();
        /// name of the spawn rule
        test: String = row.test.clone();
        /// name of the search within the layers; empty for the nominal test
        method: String = row.falsifier.clone().unwrap_or_default();
        /// speed that the driver is to hold
        test_speed_mps: f64 ["m/s"] = row.test_speed;
        /// share of the car's width that meets the target's impact point
        overlap: f64 = row.overlap;
        /// speed at the start; empty for searches
        driven_speed_mps: f64 ["m/s"] = row.driven_speed;
        /// number of different episodes, or of searches; 0 for a case that was not run, or that a car passes that never brakes
        tested: u32 = row.episodes;
        /// how many of these the protocol does not pass
        not_passed: u32 = row.not_passed;
        /// Clopper and Pearson's one-sided 95 % upper bound of their share; missing for searches, which choose what they run, and for one episode
        not_passed_at_most: f64 = row.not_passed_at_most();
        /// greatest impact speed, along the path without the target's own speed; 0 without a collision
        worst_impact_speed_mps: f64 ["m/s"] = row.impact_speed;
        /// Euro NCAP's colour of that speed; empty for other protocols
        colour: String = row.colour().map_or("", Colour::name).to_string();
        /// name of the worst collision, for `falsify replay`; empty without one
        worst_failure: String = row.worst.clone().unwrap_or_default();
        /// whether the protocol passes it; for Euro NCAP, whether it has points; missing if the car did not hold the test speed
        passes: bool = row.passes().filter(|_| row.is_tested());
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::signature::Distribution;
    use episode::{TargetBox, TargetSide, TestCase};
    use road::geometry::Pose;

    fn cell(test: f64, impact: f64, criterion: TestCriterion) -> ProtocolCell {
        let walk = TargetWalk {
            meeting: Pose::default(),
            from: TargetSide::Right,
            cases: vec![TestCase { test_speed: test / 3.6, overlap: 0.5 }],
            speed: 1.0,
            distance: 4.0,
            approach: Distribution::Constant(1.0),
            reach: 1.0,
            headway: 6.0,
            hidden: false,
            target: TargetBox::ADULT,
            criterion,
        };
        let mut cell = ProtocolCell::new(("", "", "", ""), &walk, 0);
        cell.note(walk.judged_speed(impact / 3.6, walk.command()), Some((test + 0.5) / 3.6), || None);
        cell
    }

    #[test]
    fn colours_follow_the_published_bands() {
        use Colour::{Brown, Green, Orange, Red, Yellow};
        let impacts = [0.0, 0.3, 9.9, 10.1, 19.9, 20.1, 29.9, 30.1, 60.0];
        for (speed, colours) in [
            (60.0, [Green, Green, Yellow, Orange, Orange, Brown, Brown, Red, Red]),
            (50.0, [Green, Green, Yellow, Orange, Orange, Brown, Brown, Red, Red]),
            (40.0, [Green, Green, Orange, Brown, Brown, Red, Red, Red, Red]),
            (30.0, [Green, Green, Brown, Red, Red, Red, Red, Red, Red]),
            (20.0, [Green, Green, Red, Red, Red, Red, Red, Red, Red]),
        ] {
            let of = |impact| cell(speed, impact, TestCriterion::EuroNcap);
            assert_eq!(impacts.map(|impact| of(impact).colour().unwrap()), colours, "{speed} km/h");
            let passes = impacts.map(|impact| of(impact).passes().unwrap());
            assert_eq!(passes, colours.map(|colour| colour != Red), "a cell with points passes, at {speed} km/h");
        }
        assert_eq!(cell(35.0, 9.0, TestCriterion::EuroNcap).colour(), None, "no colours are published there");
    }

    #[test]
    fn few_cells_and_another_friction_are_said_beside_a_score() {
        let of = |speeds: &[f64], friction, criterion| {
            let cell = |speed: &f64| ProtocolCell { friction, ..cell(*speed, 0.0, criterion) };
            let cells: Vec<ProtocolCell> = speeds.iter().map(cell).collect();
            ProtocolCell::caveats(&cells.iter().collect::<Vec<_>>())
        };
        let all = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
        assert_eq!(of(&all, Some(0.9), TestCriterion::EuroNcap), "");
        assert_eq!(of(&all[..3], None, TestCriterion::EuroNcap), "3 of 6 speeds, no friction");
        assert_eq!(of(&all[..3], Some(0.5), TestCriterion::NoCollision), "friction 0.5");
    }

    #[test]
    fn a_cell_of_another_run_is_the_same_only_with_the_same_result() {
        let one = cell(60.0, 12.0, TestCriterion::EuroNcap);
        let again = ProtocolCell { run_id: "1a2b3c4d".into(), worst: Some("1a2b3c4d:0".into()), ..one.clone() };
        assert!(one.repeats(&again));
        assert!(!one.repeats(&cell(60.0, 13.0, TestCriterion::EuroNcap)));
        assert!(!one.repeats(&ProtocolCell { policy: "other".into(), ..again }));
    }

    #[test]
    fn a_cell_says_how_sure_it_is() {
        let mut sure = cell(50.0, 0.0, TestCriterion::NoCollision);
        (1..20).for_each(|_| sure.note(0.0, None, || None));
        // 1 - 0.05^(1/20).
        assert_eq!((sure.not_passed, sure.episodes), (0, 20));
        assert!((sure.not_passed_at_most().unwrap() - 0.139_108_3).abs() < 1e-6);
        sure.note(3.0, None, || None);
        assert_eq!(sure.not_passed, 1);
        assert_eq!(ProtocolCell { falsifier: Some("meet".into()), ..sure }.not_passed_at_most(), None);
        assert_eq!(cell(50.0, 0.0, TestCriterion::NoCollision).not_passed_at_most(), None, "one run decides");
    }

    #[test]
    fn limits_of_un_r152_depend_on_the_test_speed() {
        let passes = |test, impact| cell(test, impact, TestCriterion::UnR152).passes().unwrap();
        assert!(passes(42.0, 0.0) && !passes(42.0, 1.0));
        assert!(passes(45.0, 14.9) && !passes(45.0, 15.1));
        assert!(passes(60.0, 34.9) && !passes(60.0, 35.1));
        assert!(!cell(50.0, 1.0, TestCriterion::NoCollision).passes().unwrap());
        assert_eq!(cell(50.0, 1.0, TestCriterion::NoCollision).colour(), None, "colours are those of Euro NCAP");
    }

    #[test]
    fn a_cell_keeps_its_worst_result_and_reports_a_speed_that_was_not_held() {
        let mut cell = cell(50.0, 10.0, TestCriterion::EuroNcap);
        assert_eq!(cell.is_held(), Some(true));
        cell.note(5.0, Some(40.0 / 3.6), || Some("a:1".into()));
        cell.note(3.0, Some(50.0 / 3.6), || Some("a:2".into()));
        assert_eq!(cell.worst.as_deref(), Some("a:1"));
        assert_eq!((cell.impact_speed, cell.episodes, cell.is_held()), (Some(5.0), 3, Some(false)));
    }
}
