use rand::RngExt;
use rayon::prelude::*;

use super::estimate::{SOUND, around};
use super::{Estimate, Event, Events, Likelihood, Limits, Lot, TestBed};
use crate::falsifier::SearchOutcome;
use base::keys;
use base::seed::{Seed, Stream, Tape};
use base::signature::DeclarationId;
use base::statistics::normal_quantile;

keys! {
    /// Fresh encounters near those in which a falsifier found failures, each with a weight: exact where some are drawn plainly, and quick where the
    /// falsifier knows all ways to fail.
    pub struct ImportanceKeys = "importance" {
        /// The falsifier that searches first. Its failures say from which starts.
        from: DeclarationId as Reference("falsifier"),
        /// Ticks that it may use.
        search: u64 as ticks(1, 1_000_000_000_000) = "200_000",
        /// Encounters of a round in which the ways to fail are learnt, before those that count.
        learn: u64 as whole(100, 10_000_000) = "1_000",
        /// Share of the encounters that are drawn plainly. It bounds the weights.
        plain: f64 as within(RATIO, 0.01, 1.0) = "0.1",
    }
}

/// Importance sampling: encounters are drawn near failures that are known, and weighted by how much more likely they became.
///
/// The starts from which the falsifier found failures are the first centres. Of encounters drawn near them with the walker in question, those that fail,
/// or come nearest, are the next centres; after a round in which many fail, and one more, the centres are fixed, and fresh encounters count. So all numbers are exact: an
/// encounter weighs 1 / (p + (1 − p) k), where p is the share that is drawn plainly, and k how much likelier its words are
/// near the centres. A way to fail that no centre is near is seen only by the plain share, and then weighs up to 1 / p.
///
/// # Source
/// Zhang, *Nonparametric importance sampling*, Journal of the American Statistical Association 91, 1996; Owen and Zhou, *Safe and effective importance
/// sampling*, the same journal 95, 2000 (the plain share).
#[derive(Debug, Clone)]
pub struct Importance {
    keys: ImportanceKeys,
}

/// The most rounds in which the centres are learnt.
const MOST_ROUNDS: u64 = 12;
/// The most centres, and the share of a round that become ones if fewer fail.
const MOST_CENTRES: usize = 400;
const NEAREST: f64 = 0.1;
/// Words of the start and of the walker that are drawn near a centre.
const WORDS: [usize; 2] = [24, 48];
/// A word whose normal number spreads about 0 as this does in the centres, or wider, says nothing.
const WIDE: (f64, f64) = (0.75, 0.35);
/// Spread of the words of starts about those that are known to fail.
const FIRST_WIDTH: f64 = 0.5;
/// Least width about a centre.
const LEAST_WIDTH: f64 = 0.02;
/// Encounters between two looks at the error, and those that use one test bed.
const BATCH: u64 = 1000;
const ROW: usize = 50;

/// The words of the start and of the walker, as standard normal numbers.
type Point = [Vec<f64>; 2];

/// Where encounters are drawn: about each centre, and about all of them at once.
#[derive(Debug, Clone, Default)]
struct Proposal {
    /// The last one is about all centres, and is chosen as often as all others together.
    clouds: Vec<Cloud>,
}

/// Words that are drawn from normal distributions of their normal numbers: mean and standard deviation of each; none for a fresh word.
type Cloud = [Vec<Option<(f64, f64)>>; 2];

/// An encounter that was drawn.
struct Draw {
    height: f64,
    counts: bool,
    /// Whether it was drawn plainly.
    plain: bool,
    weight: f64,
    point: Point,
    events: Events,
    ticks: u64,
}

impl Importance {
    pub fn from_keys(keys: ImportanceKeys) -> Self {
        Self { keys }
    }

    /// The falsifier that searches first.
    pub fn falsifier(&self) -> DeclarationId {
        self.keys.from
    }

    /// The ticks that it may use.
    pub fn search_budget(&self) -> u64 {
        self.keys.search
    }

    pub(super) fn estimate<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        found: Option<(&SearchOutcome, &Seed)>,
        seed: &Seed,
        limits: Limits<'_>,
    ) -> Estimate {
        let mut ticks = found.map_or(0, |(outcome, _)| outcome.ticks);
        let mut encounters = found.map_or(0, |(outcome, _)| outcome.episodes);
        let mut proposal =
            found.map_or_else(Proposal::default, |(outcome, starts)| self.near_starts(make, outcome, starts));
        let mut stopped = false;
        let mut last = false;
        for round in 0..MOST_ROUNDS {
            stopped |= (limits.stop)();
            if stopped {
                break;
            }
            let draws = self.draw(make, &proposal, &seed.child("learn").index(round), 0..self.keys.learn, false);
            ticks += draws.iter().map(|draw| draw.ticks).sum::<u64>();
            encounters += self.keys.learn;
            // A round in which as many failed as are needed for a centre is followed by one about these.
            let enough = draws.iter().filter(|draw| draw.height >= 0.0).count() as f64 >= NEAREST * draws.len() as f64;
            proposal = Proposal::near_failures(draws);
            (limits.progress)(ticks);
            if last {
                break;
            }
            last = enough;
        }
        let mut sums = [Sum::default(); Event::COUNT];
        let (mut count, mut plain, mut fresh) = (0_u64, 0_u64, 0_u64);
        let mut enough = false;
        while !stopped && !enough && (count == 0 || ticks < limits.budget) {
            stopped = (limits.stop)();
            if stopped {
                break;
            }
            let numbers = count..count + BATCH;
            for draw in self.draw(make, &proposal, &seed.child("draws"), numbers, true) {
                ticks += draw.ticks;
                let is_fresh = draw.plain && draw.counts;
                plain += u64::from(draw.plain);
                fresh += u64::from(is_fresh);
                for (sum, event) in sums.iter_mut().zip(draw.events) {
                    sum.include(if event { draw.weight } else { 0.0 }, is_fresh);
                }
            }
            count += BATCH;
            (limits.progress)(ticks);
            let target = &sums[limits.event as usize];
            enough =
                target.relative_error(count).is_some_and(|error| error <= limits.relative_error) && target.is_sound();
        }
        let counting = fresh as f64 / plain.max(1) as f64;
        let likelihood = |event: &Event| sums[*event as usize].likelihood(*event, count, fresh, counting.max(1e-9));
        Estimate {
            likelihoods: Event::ALL.iter().map(likelihood).collect(),
            encounters: encounters + count,
            ticks,
            counting,
            fresh,
            levels: Vec::new(),
            populations: Vec::new(),
            greatest_weight: sums[limits.event as usize].greatest_share(),
            short: !enough,
            stopped,
        }
    }

    /// Centres at the starts from which failures were found. Nothing is known of the walker's words.
    fn near_starts<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        outcome: &SearchOutcome,
        starts: &Seed,
    ) -> Proposal {
        let mut numbers: Vec<u64> = outcome.failures.iter().map(|failure| failure.start).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut bed = make();
        let centre = |number: u64| {
            let seed = starts.index(number);
            let mut lot = Lot { start: Tape::new(seed.child("spawn")), drivers: seed, ..Lot::new(number, &seed) };
            bed.begin(&mut lot);
            [normals(&mut lot.start, WORDS[0]), Vec::new()]
        };
        let centres: Vec<Point> = numbers.into_iter().take(MOST_CENTRES).map(centre).collect();
        let words = centres.iter().map(|centre| centre[0].len()).max().unwrap_or(0);
        Proposal::about(&centres, &[vec![FIRST_WIDTH; words], Vec::new()])
    }

    /// Draws encounters with these numbers. Failures are judged if that is wanted.
    fn draw<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        proposal: &Proposal,
        seed: &Seed,
        numbers: std::ops::Range<u64>,
        judged: bool,
    ) -> Vec<Draw> {
        let numbers: Vec<u64> = numbers.collect();
        let plain = if proposal.clouds.is_empty() { 1.0 } else { self.keys.plain };
        let rows = numbers.par_chunks(ROW).map(|numbers| {
            let mut bed = make();
            let run = |number: &u64| {
                let (before, seed) = (bed.ticks(), seed.index(*number));
                let mut lot = Lot::new(*number, &seed);
                let mut stream = seed.child("centre").stream();
                let is_plain = stream.random::<f64>() < plain;
                if !is_plain {
                    let cloud = proposal.choose(&mut stream);
                    lot.start = within(&cloud[0], seed.child("start"), &mut stream);
                    lot.walk = within(&cloud[1], seed.child("walk"), &mut stream);
                }
                bed.begin(&mut lot);
                while bed.step(&mut lot) {}
                let trial = bed.trial();
                let point = [normals(&mut lot.start, WORDS[0]), normals(&mut lot.walk, WORDS[1])];
                let weight = 1.0 / (plain + (1.0 - plain) * proposal.likelier(&point));
                let events = if judged && trial.fails() { bed.judge(&mut lot) } else { [false; Event::COUNT] };
                Draw {
                    height: trial.height(),
                    counts: trial.counts,
                    plain: is_plain,
                    weight,
                    point,
                    events,
                    ticks: bed.ticks() - before,
                }
            };
            numbers.iter().map(run).collect::<Vec<_>>()
        });
        rows.collect::<Vec<_>>().into_iter().flatten().collect()
    }
}

impl Proposal {
    /// Centres at the failures of a round, or at the encounters that came nearest.
    fn near_failures(mut draws: Vec<Draw>) -> Self {
        draws.sort_by(|a, b| b.height.total_cmp(&a.height));
        let failures = draws.iter().take_while(|draw| draw.height >= 0.0).count();
        let nearest = (NEAREST * draws.len() as f64) as usize;
        draws.truncate(failures.max(nearest));
        let count = draws.len().min(MOST_CENTRES);
        // The heavier ones stand for more; a systematic sample of their weights.
        let total: f64 = draws.iter().map(|draw| draw.weight).sum();
        let (mut sum, mut centres) = (0.0, Vec::with_capacity(count));
        for draw in draws {
            sum += draw.weight;
            while (centres.len() as f64 + 0.5) * total < sum * count as f64 && centres.len() < count {
                centres.push(draw.point.clone());
            }
        }
        let spreads = [0, 1].map(|part| {
            let words = centres.iter().map(|centre: &Point| centre[part].len()).max().unwrap_or(0);
            (0..words).map(|word| spread(&centres, part, word)).collect::<Vec<f64>>()
        });
        Self::about(&centres, &spreads)
    }

    /// Clouds about centres, whose words have these standard deviations; 1 for a word of which nothing is known.
    fn about(centres: &[Point], spreads: &[Vec<f64>; 2]) -> Self {
        // The width of normal kernels that estimate a normal density best (Silverman, *Density estimation*, 1986, equation 4.14).
        let narrow = spreads.iter().flatten().filter(|spread| **spread < 1.0).count() as f64;
        let factor = libm::pow(4.0 / (centres.len() as f64 * (narrow + 2.0)), 1.0 / (narrow + 4.0)).min(1.0);
        let cloud = |of: &dyn Fn(usize, usize, f64) -> Option<(f64, f64)>| -> Cloud {
            [0, 1].map(|part| {
                let words = spreads[part].iter().enumerate();
                words.map(|(word, spread)| (*spread < 1.0).then(|| of(part, word, *spread)).flatten()).collect()
            })
        };
        let near = |centre: &Point| {
            cloud(&|part, word, spread| {
                let width = (spread * factor).max(LEAST_WIDTH);
                centre[part].get(word).map(|middle| ((1.0 - width * width).sqrt() * middle, width))
            })
        };
        let all = cloud(&|part, word, spread| {
            let known = centres.iter().filter_map(|centre| centre[part].get(word));
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), middle| (sum + middle, count + 1.0));
            Some((sum / count, spread.max(LEAST_WIDTH)))
        });
        let clouds = centres.iter().map(near).chain((!centres.is_empty()).then_some(all)).collect();
        Self { clouds }
    }

    fn choose(&self, stream: &mut Stream) -> &Cloud {
        let last = self.clouds.len() - 1;
        let place = if stream.random::<bool>() { last } else { stream.random_range(0..last) };
        &self.clouds[place]
    }

    /// How much likelier a point is among the draws than among all: the ratio of the densities of its words.
    fn likelier(&self, point: &Point) -> f64 {
        let ratio = |cloud: &Cloud| {
            let mut logarithm = 0.0;
            for (words, values) in cloud.iter().zip(point) {
                for (word, value) in words.iter().zip(values) {
                    let Some((mean, deviation)) = word else { continue };
                    let apart = (value - mean) / deviation;
                    logarithm += 0.5 * (value * value - apart * apart) - libm::log(*deviation);
                }
            }
            libm::exp(logarithm)
        };
        let Some((all, each)) = self.clouds.split_last() else { return 0.0 };
        0.5 * ratio(all) + 0.5 * each.iter().map(ratio).sum::<f64>() / each.len() as f64
    }
}

/// A tape that is drawn from a cloud.
fn within(cloud: &[Option<(f64, f64)>], seed: Seed, stream: &mut Stream) -> Tape {
    let words = cloud.iter().map(|word| {
        let fresh = normal_quantile(stream.random::<f64>().clamp(1e-16, 1.0 - 1e-16));
        word.map_or(fresh, |(mean, deviation)| mean + deviation * fresh)
    });
    Tape::of_normals(words, seed)
}

/// The standard deviation of a word among the centres, below 1; 1 where they say nothing about it.
fn spread(centres: &[Point], part: usize, word: usize) -> f64 {
    let values = || centres.iter().filter_map(|centre| centre[part].get(word));
    let count = values().count() as f64;
    let mean = values().sum::<f64>() / count;
    let deviation = (values().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count).sqrt();
    let says_nothing = count < centres.len() as f64 || deviation > WIDE.0 && mean.abs() < WIDE.1;
    if says_nothing { 1.0 } else { deviation.min(0.95) }
}

/// The first words that were drawn, as standard normal numbers.
fn normals(tape: &mut Tape, most: usize) -> Vec<f64> {
    tape.normals().take(most).collect()
}

/// The sum of weights.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    sum: f64,
    squares: f64,
    greatest: f64,
    seen: u64,
    /// Those of plain encounters.
    plainly: u64,
}

impl Sum {
    fn include(&mut self, weight: f64, plain: bool) {
        self.sum += weight;
        self.squares += weight * weight;
        self.greatest = self.greatest.max(weight);
        self.seen += u64::from(weight > 0.0);
        self.plainly += u64::from(weight > 0.0 && plain);
    }

    fn effective(&self) -> f64 {
        if self.squares > 0.0 { self.sum * self.sum / self.squares } else { 0.0 }
    }

    fn greatest_share(&self) -> f64 {
        if self.sum > 0.0 { self.greatest / self.sum } else { 0.0 }
    }

    /// Whether the weights are not degenerate.
    fn is_sound(&self) -> bool {
        self.effective() >= SOUND.0 && self.greatest_share() <= SOUND.1
    }

    fn relative_error(&self, count: u64) -> Option<f64> {
        let mean = self.sum / count as f64;
        (self.seen > 1).then(|| ((self.squares / count as f64 - mean * mean).max(0.0) / count as f64).sqrt() / mean)
    }

    /// Of encounters of which a share counts. Weights that are degenerate have no interval; then it is that of the plain encounters alone.
    fn likelihood(&self, event: Event, count: u64, fresh: u64, counting: f64) -> Likelihood {
        let plain = Likelihood::of_share(event, self.plainly, fresh);
        let Some(error) = self.relative_error(count) else { return Likelihood { seen: self.seen, ..plain } };
        let probability = self.sum / count as f64 / counting;
        let (low, high) = if self.is_sound() { around(probability, error, 1.96) } else { (plain.low, plain.high) };
        let (relative_error, effective) = (Some(error), self.effective());
        Likelihood { event, probability, low, high, relative_error, effective, seen: self.seen }
    }
}
