use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::driver_pairs::{DriverPair, NewDriver, Place, driver_pairs, new_role, places, with_driver};
use super::encounters::{MetAgain, cross};
use super::{RecheckArgs, STARTS};
use crate::cli::external_world::external_world;
use crate::session::{EpisodeName, Error, Event, Input, Session, Source, Stage, WhichPrograms};
use compile::{Campaign, HERE, Misfit, RunId, Staging};
use episode::{ExternalWorld, Scenario};
use process::ProcessOpener;
use results::failure::{Failure, FoundBy};
use results::parallel;
use results::report::{CrossedStarts, Encounters, Recheck, RecheckNote, RecheckedFailures, StoredReport, WalkedBy};
use search::{Goal, crossings};

/// The gap between car and pedestrian below which an episode without a touch is a near miss (m).
const NEAR: f64 = 1.0;

/// Values of a component of a crossing on the fixed list.
const LEVELS: u32 = 2;

/// Failures in a row in which a program fails before the others are not met with the same driver.
const MAX_ERRORS: u32 = 10;
/// Failures that are met at the same time.
const TOGETHER: usize = 32;
/// Who walks in an encounter.
const BOTH: [WalkedBy; 2] = [WalkedBy::Pedestrian, WalkedBy::Commands];

/// What a recheck works with.
struct Sides {
    old: Source,
    /// Whether the scenario of the report can be compiled as it was.
    is_old_there: bool,
    new: Vec<Campaign>,
    /// The other simulator in which the new drivers drive.
    world: Option<Arc<ExternalWorld>>,
}

impl Session {
    /// Lets new drivers meet the failures of an old report again, and old and new ones a fixed list of crossings.
    ///
    /// The start of an encounter and its pedestrian are those of the report. Of the new files, only the car and its driver count.
    ///
    /// # Errors
    /// The report cannot be read or compiled, the new files have errors, or a driver is not there.
    pub(super) fn recheck(&self, options: &RecheckArgs) -> Result<Recheck, Error> {
        let (sides, mut notes) = self.sides(options)?;
        let (pairs, alone) = driver_pairs(&sides.old.campaign, &sides.new, &options.drivers)?;
        notes.extend(alone);
        let changed =
            pairs.iter().filter(|_| sides.is_old_there).filter_map(|pair| sides.old.other_program(&pair.before));
        notes.extend(
            changed.map(|program| RecheckNote::OldDriverGone { reason: format!("{program} since the report") }),
        );
        notes.extend(sides.world.iter().map(|world| RecheckNote::elsewhere(world)));
        let failures = sides.meet_failures(&pairs, options, self, &mut notes)?;
        let setups = sides.crossed_setups(&pairs, options, &mut notes)?;
        let crossings = sides.cross_all(&setups, options.starts.unwrap_or(STARTS), self, &mut notes);
        let report = options.report.clone();
        let files = options.files.clone();
        Ok(Recheck { report, files, notes, failures, crossings })
    }

    fn sides(&self, options: &RecheckArgs) -> Result<(Sides, Vec<RecheckNote>), Error> {
        let report = StoredReport::open(&options.report)?;
        report.check_tables()?;
        self.announce(report.manifest());
        let given = if options.files.is_empty() { None } else { Some(self.new_campaigns(options, &report)?) };
        let (old, reason) =
            match (self.compile_again(report.clone(), &options.repeat.repeat, &[], WhichPrograms::OfReport), &given) {
                (Ok((old, changes)), _) => {
                    (old, changes.first().filter(|_| !options.repeat.repeat.anyway).map(ToString::to_string))
                }
                // The runs of the report may still be known by their keys.
                (Err(error), Some(new)) => {
                    let campaign = new.iter().find(|campaign| campaign.name == report.manifest().campaign);
                    let Some(campaign) = campaign else { return Err(error) };
                    (Source::new(report.clone(), campaign.clone()), Some(error.to_string()))
                }
                (Err(error), None) => return Err(error),
            };
        let new = match given {
            Some(new) => new,
            None if options.settings.is_empty() && old.held_programs.is_empty() => vec![old.campaign.clone()],
            None => {
                let present = WhichPrograms::Present;
                vec![self.compile_again(report, &options.repeat.repeat, &options.settings, present)?.0.campaign]
            }
        };
        let is_old_there = reason.is_none();
        let times = (options.timeout, options.start_timeout);
        let notes = reason.map(|reason| RecheckNote::OldDriverGone { reason }).into_iter().collect();
        let world = options.world.as_deref().map(|name| opened(name, times)).transpose()?;
        Ok((Sides { old, is_old_there, new, world }, notes))
    }

    /// The campaigns of the new files: that of the report's name, or else all.
    fn new_campaigns(&self, options: &RecheckArgs, report: &StoredReport) -> Result<Vec<Campaign>, Error> {
        let files = options.files.clone();
        let settings = options.settings.clone();
        let plan = self.plan(&Input { files, maps: Vec::new(), settings })?.plan;
        if plan.campaigns.is_empty() {
            return Err(Error::NoCampaign { advice: plan.without_campaigns() });
        }
        let named = plan.campaigns.iter().find(|campaign| campaign.name == report.manifest().campaign);
        Ok(named.map_or_else(|| plan.campaigns.clone(), |campaign| vec![campaign.clone()]))
    }
}

/// The other simulator with a name or a command, which the user allows by naming it.
fn opened(name: &str, times: (f64, f64)) -> Result<Arc<ExternalWorld>, Error> {
    let opener = Arc::new(ProcessOpener::of_program());
    let world = external_world(name, opener, times);
    world.map(Arc::new).map_err(|reason| Error::Usage(format!("cannot use the world `{name}`: {reason}")))
}

/// Counts the episodes of a stage, and reports each to the observer of a session.
struct Tally<'a> {
    session: &'a Session,
    stage: Stage,
    done: AtomicU64,
    all: u64,
    /// The failures in a row in which a program failed.
    errors: u32,
}

impl<'a> Tally<'a> {
    fn new(session: &'a Session, stage: Stage, all: u64) -> Self {
        session.tell(Event::Played { stage, done: 0, all });
        Self { session, stage, done: AtomicU64::new(0), all, errors: 0 }
    }

    /// Meets failures, until a program has failed in ten in a row: those that then are under way are met, and the others are walked by these, and not run.
    /// Those left when the user stops are not met.
    fn meet(
        &mut self,
        failures: &[Failure],
        walked_by: &[WalkedBy],
        run: impl Fn(&Failure) -> MetAgain + Sync,
    ) -> Vec<MetAgain> {
        let mut met = Vec::with_capacity(failures.len());
        for part in failures.chunks(TOGETHER) {
            let is_over = self.errors >= MAX_ERRORS;
            let tally = &*self;
            let again = parallel::map(part, |failure| {
                let met = match is_over {
                    _ if tally.goes_on().is_break() => return MetAgain::left(),
                    true => MetAgain::not_run(failure, walked_by),
                    false => run(failure),
                };
                tally.add();
                // A program is not waited for any more.
                if met.error.is_some() && tally.goes_on().is_break() { MetAgain::left() } else { met }
            });
            for each in &again {
                self.errors = match each.error {
                    Some(_) => self.errors + 1,
                    None if self.errors >= MAX_ERRORS => self.errors,
                    None => 0,
                };
            }
            met.extend(again);
        }
        met
    }

    /// Breaks when the user asks to stop.
    fn goes_on(&self) -> ControlFlow<()> {
        if self.session.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn add(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.session.tell(Event::Played { stage: self.stage, done, all: self.all });
    }
}

/// A setup in which a report has a driver.
#[derive(Clone)]
struct Setup<'a> {
    town: &'a str,
    world: &'a str,
    /// Its number in the town, from 0.
    number: u64,
    scenario: Arc<Scenario>,
}

/// The rows that encounters with a pair of drivers belong to.
type Sets = BTreeMap<(String, String, FoundBy, WalkedBy), Encounters>;

impl Sides {
    /// Whether an old driver can be run as it was.
    fn is_there(&self, driver: &str) -> bool {
        self.is_old_there && self.old.other_program(driver).is_none()
    }

    /// A new driver with its car, and where it drives.
    fn new_driver(&self, name: &str, town: &str, vehicle: Option<&str>) -> Option<NewDriver<'_>> {
        let role = new_role(&self.new, name, town, vehicle)?;
        Some(NewDriver { role, world: self.world.as_ref() })
    }

    fn meet_failures(
        &self,
        pairs: &[DriverPair],
        options: &RecheckArgs,
        session: &Session,
        notes: &mut Vec<RecheckNote>,
    ) -> Result<Vec<RecheckedFailures>, Error> {
        let mut rows = Vec::new();
        let [mut other_now, mut other_start, mut damaged, mut commands_alone, mut left] = [0; 5];
        let mut failed: Option<String> = None;
        let mut found: Vec<(&DriverPair, BTreeMap<RunId, Vec<Failure>>)> = Vec::new();
        // A violation of a requirement that is no collision has no verdict to compare.
        let mut all = self.old.report.failures()?;
        all.retain(|failure| failure.violation.is_none() && failure.is_failure());
        if options.sample.is_some() || !options.only.is_empty() {
            all.extend(self.old.report.near_misses(NEAR)?);
        }
        // A failure of another simulator says nothing of what survives there.
        let is_here = |failure: &Failure| !failure.key.cell.is_elsewhere();
        if options.world.is_some() && all.iter().any(is_here) {
            all.retain(is_here);
        }
        if !options.only.is_empty() {
            all.retain(|failure| options.only.contains(&failure.name()));
            if let Some(name) = options.only.iter().find(|name| all.iter().all(|failure| failure.name() != **name)) {
                let report = options.report.display();
                return Err(Error::Usage(format!("`{report}` has no collision and no near miss {name}")));
            }
        }
        if let Some(most) = options.sample {
            all = sample(all, most as usize);
        }
        for pair in pairs {
            let mut runs: BTreeMap<RunId, Vec<Failure>> = BTreeMap::new();
            for failure in all.iter().filter(|failure| failure.key.cell.policy == pair.before) {
                runs.entry(failure.key.id).or_default().push(failure.clone());
            }
            found.push((pair, runs));
        }
        let mut known = BTreeSet::new();
        for (pair, runs) in &found {
            for (run, failures) in runs {
                let cell = &failures[0].key.cell;
                let after = self.met_in(*run, pair)?;
                if known.insert((
                    &pair.after,
                    &cell.town,
                    cell.simulator(),
                    has_cars(&after),
                    after.episode.friction.is_some(),
                )) {
                    self.check(pair, &cell.town, cell.simulator(), &after, notes)?;
                }
            }
        }
        let all = found.iter().flat_map(|(_, runs)| runs.values()).map(Vec::len).sum::<usize>();
        let mut tally = Tally::new(session, Stage::Failures, all as u64);
        for (pair, runs) in found {
            let mut sets = Sets::new();
            tally.errors = 0;
            for (run, failures) in runs {
                for (failure, met) in failures.iter().zip(self.meet_run(run, &failures, pair, &mut tally)?) {
                    other_now += u64::from(met.is_other_now);
                    other_start += u64::from(met.has_other_start);
                    damaged += u64::from(met.is_damaged);
                    left += u64::from(met.is_left);
                    commands_alone += u64::from(met.has_no_controller);
                    if let (None, Some(error)) = (&failed, met.error) {
                        failed = Some(format!("{} against `{}`: {error}", failure.name(), pair.after));
                    }
                    for (walked_by, encounter) in met.encounters {
                        let cell = &failure.key.cell;
                        let place = (cell.town.clone(), self.new_world(cell.simulator()).to_owned());
                        sets.entry((place.0, place.1, failure.found_by, walked_by)).or_default().0.push(encounter);
                    }
                }
            }
            let policies = [pair.before.clone(), pair.after.clone()];
            rows.extend(sets.into_iter().map(|((town, world, found_in, walked_by), encounters)| RecheckedFailures {
                policies: policies.clone(),
                town,
                world,
                found_in,
                walked_by,
                encounters,
            }));
        }
        let counted = [
            (commands_alone, RecheckNote::CommandsAlone { failures: commands_alone }),
            (other_now, RecheckNote::OtherNow { failures: other_now }),
            (other_start, RecheckNote::OtherStart { encounters: other_start }),
            (damaged, RecheckNote::Damaged { failures: damaged }),
            (left, RecheckNote::Left { failures: left }),
        ];
        notes.extend(counted.into_iter().filter(|(count, _)| *count > 0).map(|(_, note)| note));
        notes.extend(failed.map(|first| RecheckNote::Failed { first }));
        Ok(rows)
    }

    /// The name of the simulator in which a new driver drives, of failures that were found in one.
    fn new_world<'a>(&'a self, found_in: &'a str) -> &'a str {
        self.world.as_ref().and_then(|world| world.abilities.as_ref()).map_or(found_in, |abilities| &abilities.name)
    }

    /// The scenario in which failures of a run or a search are met again.
    fn met_in(&self, run: RunId, pair: &DriverPair) -> Result<Arc<Scenario>, Error> {
        let (name, gone) = (EpisodeName { run, number: 0 }, || self.old.run_gone(run));
        let (scenario, town, vehicle) = match self.old.evaluation(name) {
            Some(found) => (&found.scenario, &*found.town, Some(&*found.vehicle)),
            None => self.old.search(name).map(|found| (&found.scenario, &*found.key.town, None)).ok_or_else(gone)?,
        };
        Ok(with_driver(scenario, self.new_driver(&pair.after, town, vehicle).ok_or_else(gone)?))
    }

    /// Checks that the new driver can drive in a scenario; what that lacks is a note.
    fn check(
        &self,
        pair: &DriverPair,
        town: &str,
        found_in: &str,
        after: &Scenario,
        notes: &mut Vec<RecheckNote>,
    ) -> Result<(), Error> {
        let driver = (after.cast.ego().policy)();
        let staging = Staging {
            world: after.external_world.as_deref().map(|world| (self.new_world(found_in), world)),
            driver: (&pair.after, driver.world_driver()),
            towns: vec![(town, &*after.town)],
            has_cars: has_cars(after),
            rule: &after.episode,
        };
        for Misfit { is_error, message, help, .. } in staging.misfits() {
            let said = if help.is_empty() { message } else { format!("{message}; {help}") };
            if is_error {
                return Err(Error::Usage(format!("{said}. `--driver OLD=NEW` chooses drivers, `--only` failures")));
            }
            let note = RecheckNote::Lacks { said };
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
        Ok(())
    }

    /// Meets failures of a run or a search again.
    fn meet_run(
        &self,
        run: RunId,
        failures: &[Failure],
        pair: &DriverPair,
        tally: &mut Tally<'_>,
    ) -> Result<Vec<MetAgain>, Error> {
        let run = EpisodeName { run, number: failures.first().map_or(0, |failure| failure.number as u32) };
        let gone = || self.old.run_gone(run.run);
        let is_old_there = self.is_there(&pair.before);
        if let Some(evaluation) = self.old.evaluation(run) {
            let trained = self.old.trained(evaluation)?;
            let vehicle = Some(&*evaluation.vehicle);
            let new = self.new_driver(&pair.after, &evaluation.town, vehicle).ok_or_else(gone)?;
            let of_run = (evaluation, trained.as_deref());
            let walked_by = if new.world.is_some() { &BOTH[..1] } else { &BOTH[..] };
            let meet = |failure: &Failure| self.old.meet_episode(failure, of_run, new, is_old_there);
            return Ok(tally.meet(failures, walked_by, meet));
        }
        let search = self.old.search(run).ok_or_else(gone)?;
        let new = self.new_driver(&pair.after, &search.key.town, None).ok_or_else(gone)?;
        let walked_by = match (search.falsifier.walk_policy(), &new.world) {
            (None, _) => &BOTH[1..],
            (Some(_), None) => &BOTH[..],
            (Some(_), Some(_)) => &BOTH[..1],
        };
        let meet = |failure: &Failure| self.old.meet_failure(failure, search, new, is_old_there);
        Ok(tally.meet(failures, walked_by, meet))
    }

    /// The setups in which the fixed list is met; in another simulator only if it is asked for, since each episode there takes long.
    fn crossed_setups<'a>(
        &'a self,
        pairs: &'a [DriverPair],
        options: &RecheckArgs,
        notes: &mut Vec<RecheckNote>,
    ) -> Result<Vec<(&'a DriverPair, Setup<'a>)>, Error> {
        let of_pair = |pair: &'a DriverPair| self.setups(&pair.before).into_iter().map(move |setup| (pair, setup));
        let mut setups: Vec<_> = pairs.iter().flat_map(of_pair).collect();
        if options.starts.is_none() {
            let all = setups.len();
            setups.retain(|(_, setup)| self.world.is_none() && setup.world == HERE);
            notes.extend((self.world.is_none() && setups.len() < all).then_some(RecheckNote::NoFixedList));
        }
        for (pair, setup) in setups.iter().filter(|_| options.starts != Some(0)) {
            let new = self.new_driver(&pair.after, setup.town, None).expect("the new driver is in a campaign");
            self.check(pair, setup.town, setup.world, &with_driver(&setup.scenario, new), notes)?;
        }
        Ok(setups)
    }

    fn cross_all(
        &self,
        setups: &[(&DriverPair, Setup<'_>)],
        starts: u32,
        session: &Session,
        notes: &mut Vec<RecheckNote>,
    ) -> Vec<CrossedStarts> {
        if starts == 0 || setups.is_empty() {
            return Vec::new();
        }
        let goals = crossings(LEVELS);
        let mut rows = Vec::new();
        let mut other_start = 0;
        let of_setup = u64::from(starts) * goals.len() as u64;
        let drivers = |pair: &DriverPair| 1 + u64::from(self.is_there(&pair.before));
        let all = setups.iter().map(|(pair, _)| drivers(pair) * of_setup).sum();
        let tally = Tally::new(session, Stage::Crossings, all);
        for (pair, setup) in setups {
            let row = self.cross(pair, setup, &goals, starts, &tally);
            if session.is_stopped() {
                notes.push(RecheckNote::ListLeft);
                break;
            }
            other_start += of_setup - row.encounters.0.len() as u64;
            rows.push(row);
        }
        if other_start > 0 {
            notes.push(RecheckNote::OtherStart { encounters: other_start });
        }
        rows
    }

    fn cross(
        &self,
        pair: &DriverPair,
        setup: &Setup<'_>,
        goals: &[Goal],
        starts: u32,
        tally: &Tally<'_>,
    ) -> CrossedStarts {
        let Setup { town, world, number, scenario } = setup;
        let new = self.new_driver(&pair.after, town, None).expect("the new driver is in a campaign");
        let before = self.is_there(&pair.before).then_some(scenario);
        let seed = self.old.seed.child("recheck").child(town);
        CrossedStarts {
            policies: [pair.before.clone(), pair.after.clone()],
            town: (*town).to_owned(),
            world: self.new_world(world).to_owned(),
            setup: *number,
            crossings: goals.len() as u64,
            encounters: cross(goals, before, &with_driver(scenario, new), starts, seed, &|| {
                tally.add();
                tally.goes_on()
            }),
        }
    }

    /// The different setups in which the report has a driver, numbered in each town.
    fn setups(&self, driver: &str) -> Vec<Setup<'_>> {
        let mut setups: Vec<Setup<'_>> = Vec::new();
        for Place { town, world, scenario, .. } in places(&self.old.campaign).filter(|place| place.policy == driver) {
            let of_town = || setups.iter().filter(|other| (other.town, other.world) == (town, world));
            if !of_town().any(|other| is_alike(&other.scenario, scenario)) {
                let number = of_town().count() as u64;
                // Rewards are not of interest here.
                let oracle = scenario.oracle.clone().filter(|_| scenario.cast.pedestrians.len() > 1);
                let scenario = Arc::new(Scenario { oracle, ..Scenario::clone(scenario) });
                setups.push(Setup { town, world, number, scenario });
            }
        }
        setups
    }
}

/// At most this number of faults and of others of each driver in each town, spread evenly.
fn sample(all: Vec<Failure>, most: usize) -> Vec<Failure> {
    let mut groups: BTreeMap<(String, String, bool), Vec<Failure>> = BTreeMap::new();
    for failure in all {
        let key = (failure.key.cell.policy.clone(), failure.key.cell.place(), failure.fault);
        groups.entry(key).or_default().push(failure);
    }
    let spread = |group: Vec<Failure>| {
        let (count, chosen) = (group.len(), group.len().min(most));
        (0..chosen).map(move |place| group[place * count / chosen].clone())
    };
    groups.into_values().flat_map(spread).collect()
}

/// Whether a cast has further cars.
fn has_cars(scenario: &Scenario) -> bool {
    scenario.cast.vehicles.len() > 1
}

/// Whether encounters in two scenarios of a town are the same.
fn is_alike(one: &Scenario, other: &Scenario) -> bool {
    let pedestrians = |scenario: &Scenario| -> Vec<_> { scenario.cast.pedestrians.to_vec() };
    one.spawn == other.spawn
        && one.episode == other.episode
        && pedestrians(one) == pedestrians(other)
        && one.cast.ego().blueprint == other.cast.ego().blueprint
}
