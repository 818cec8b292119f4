use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand::Rng;

use super::stream::Played;
use super::{Seed, Stream};
use crate::statistics::{normal_below, normal_quantile};

/// The random words that something draws, as a point that can be moved.
///
/// Each word is uniform over all of its 2⁶⁴ values. Whatever is drawn from the tape is a function of its words, so a walk over tapes that leaves the uniform
/// law as it is leaves the law of everything drawn as it is: *primary sample space* (Kelemen et al., *A simple and robust mutation strategy for the
/// Metropolis light transport algorithm*, Eurographics 2002). No density of what is drawn is needed.
///
/// The words that were never drawn are those of the stream of a seed.
#[derive(Debug, Clone)]
pub struct Tape {
    words: Vec<u64>,
    rest: Seed,
    drawn: Arc<AtomicUsize>,
}

/// The lower bits of a word that a shift keeps: no draw of a number in [0, 1) reads them.
const KEPT: u64 = 0x7ff;
/// The step between two numbers in [0, 1) that words give.
const SHARE: f64 = 1.0 / (1u64 << 53) as f64;

impl Tape {
    /// Fresh words.
    pub fn new(seed: Seed) -> Self {
        Self { words: Vec::new(), rest: seed, drawn: Arc::default() }
    }

    /// A stream that draws the words from number `from` on. The tape notes how many it draws; only the stream that was made last counts.
    pub fn stream(&mut self, from: usize) -> Stream {
        self.settle();
        self.drawn = Arc::new(AtomicUsize::new(from));
        let played = Played { words: self.words.as_slice().into(), drawn: self.drawn.clone(), next: from };
        self.rest.stream().playing(played)
    }

    /// The number of words that its last stream has drawn.
    pub fn drawn(&self) -> usize {
        self.drawn.load(Ordering::Relaxed)
    }

    /// The words that its last stream has drawn.
    pub fn words(&mut self) -> &[u64] {
        self.settle();
        &self.words[..self.drawn()]
    }

    /// Takes the words that were drawn beyond its own.
    fn settle(&mut self) {
        let (drawn, before) = (self.drawn(), self.words.len());
        if drawn > before {
            let mut stream = self.rest.stream();
            self.words.extend((before..drawn).map(|_| stream.next_u64()));
            self.rest = self.rest.child("rest");
        }
    }

    /// The same words up to number `from`, and fresh ones from there on. It has to be called after its last stream has drawn.
    pub fn redrawn(&self, from: usize, seed: Seed) -> Self {
        let mut tape = self.clone();
        tape.settle();
        tape.words.truncate(from);
        Self { words: tape.words, rest: seed, drawn: Arc::new(AtomicUsize::new(from)) }
    }

    /// The words that were drawn, each moved by a step of this size (0 for none, 1 for a fresh word), and fresh ones beyond. The bits that no number in
    /// [0, 1) reads stay.
    ///
    /// A word is moved as the share of a standard normal number `z` below it, which becomes √(1 − s²) z + s ξ: the uniform law stays as it is,
    /// and a step there and back are equally likely (Papaioannou et al., *MCMC algorithms for subset simulation*, Probabilistic Engineering
    /// Mechanics 41, 2015).
    pub fn varied(&self, seed: Seed, mut step: impl FnMut(usize) -> f64) -> Self {
        let mut tape = self.redrawn(self.drawn(), seed.child("rest"));
        let mut stream = seed.stream();
        for (number, word) in tape.words.iter_mut().enumerate() {
            let step = step(number);
            if step > 0.0 {
                let moved = (1.0 - step * step).max(0.0).sqrt() * normal_quantile(share(*word))
                    + step * normal_quantile(share(stream.next_u64()));
                *word = word_of(normal_below(moved)) | (*word & KEPT);
            }
        }
        tape
    }

    /// A tape whose words give these numbers of the standard normal distribution, then fresh ones.
    pub fn of_normals(normals: impl Iterator<Item = f64>, seed: Seed) -> Self {
        let mut stream = seed.stream();
        let words = normals.map(|normal| word_of(normal_below(normal)) | (stream.next_u64() & KEPT)).collect();
        Self { words, rest: seed.child("rest"), drawn: Arc::default() }
    }

    /// The words that its last stream has drawn, as numbers of the standard normal distribution.
    pub fn normals(&mut self) -> impl Iterator<Item = f64> {
        self.words().iter().map(|word| normal_quantile(share(*word)))
    }
}

/// The middle of the number in [0, 1) that a word gives.
fn share(word: u64) -> f64 {
    ((word >> 11) as f64 + 0.5) * SHARE
}

/// The word that gives a number in [0, 1).
fn word_of(share: f64) -> u64 {
    ((share / SHARE) as u64).min((1 << 53) - 1) << 11
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    fn draw(tape: &mut Tape, count: usize) -> Vec<f64> {
        let mut stream = tape.stream(0);
        (0..count).map(|_| stream.random()).collect()
    }

    #[test]
    fn a_tape_repeats_itself_and_its_first_words_are_those_of_its_seed() {
        let seed = Seed::root(5);
        let mut tape = Tape::new(seed);
        let first = draw(&mut tape, 20);
        let mut stream = seed.stream();
        assert_eq!(first, (0..20).map(|_| stream.random()).collect::<Vec<f64>>());
        assert_eq!(tape.words().len(), 20);
        assert_eq!(draw(&mut tape, 20), first);
        // More words than before.
        let more = draw(&mut tape, 30);
        assert_eq!(more[..20], first);
        assert_eq!(draw(&mut tape, 30), more);
    }

    #[test]
    fn a_redrawn_tape_keeps_its_first_words_and_a_varied_one_moves_them_a_little() {
        let mut tape = Tape::new(Seed::root(6));
        let first = draw(&mut tape, 10);
        let redrawn = draw(&mut tape.redrawn(4, Seed::root(7)), 10);
        assert_eq!(redrawn[..4], first[..4]);
        assert!(redrawn[4..].iter().zip(&first[4..]).all(|(a, b)| a != b));
        let varied = draw(&mut tape.varied(Seed::root(8), |number| if number == 3 { 1.0 } else { 0.01 }), 10);
        for (number, (before, after)) in first.iter().zip(varied).enumerate() {
            assert!((after - before).abs() < 0.02 || number == 3, "{number}: {before} to {after}");
        }
    }

    #[test]
    fn a_walk_over_tapes_keeps_the_uniform_law() {
        let (steps, mut tape) = (20_000, Tape::new(Seed::root(11)));
        let (mut sum, mut squares, mut low) = (0.0, 0.0, 0);
        for step in 0..steps {
            let drawn = draw(&mut tape, 1)[0];
            (sum, squares) = (sum + drawn, squares + drawn * drawn);
            low += u32::from(drawn < 0.01);
            tape = tape.varied(Seed::root(12).index(step), |_| 0.9);
        }
        let (mean, square) = (sum / steps as f64, squares / steps as f64);
        assert!((mean - 0.5).abs() < 0.01 && (square - 1.0 / 3.0).abs() < 0.01, "{mean} {square}");
        assert!((f64::from(low) / steps as f64 - 0.01).abs() < 0.003, "{low}");
    }

    #[test]
    fn a_stream_can_begin_within_the_tape() {
        let mut tape = Tape::new(Seed::root(9));
        let first = draw(&mut tape, 10);
        let mut stream = tape.redrawn(10, Seed::root(1)).stream(4);
        assert_eq!((4..10).map(|_| stream.random()).collect::<Vec<f64>>(), first[4..]);
    }
}
