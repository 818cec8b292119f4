use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand::Rng;

use super::stream::Played;
use super::{Seed, Stream};

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

impl Tape {
    /// Fresh words.
    pub fn new(seed: Seed) -> Self {
        Self { words: Vec::new(), rest: seed, drawn: Arc::default() }
    }

    /// A stream that draws the words from number `from` on. The tape notes how many it draws; only the stream that was made last counts.
    pub fn stream(&mut self, from: usize) -> Stream {
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

    /// The words that were drawn, each shifted by `shift` of its range (on a circle, so that the uniform law stays), and fresh ones beyond. The bits that
    /// no number in [0, 1) reads stay.
    pub fn shifted(&self, seed: Seed, mut shift: impl FnMut(usize) -> f64) -> Self {
        let mut tape = self.redrawn(self.drawn(), seed);
        for (number, word) in tape.words.iter_mut().enumerate() {
            *word = word.wrapping_add(turned(shift(number)) & !KEPT);
        }
        tape
    }

    /// A tape of given words, then fresh ones.
    pub fn of(words: Vec<u64>, seed: Seed) -> Self {
        Self { words, rest: seed, drawn: Arc::default() }
    }
}

/// A share of the range of a word, positive or negative, as a word.
fn turned(share: f64) -> u64 {
    let share = share - share.floor();
    // 2⁵³ steps, as a number in [0, 1) has.
    ((share * (1u64 << 53) as f64) as u64) << 11
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
    fn a_redrawn_tape_keeps_its_first_words_and_a_shifted_one_moves_them_a_little() {
        let mut tape = Tape::new(Seed::root(6));
        let first = draw(&mut tape, 10);
        let redrawn = draw(&mut tape.redrawn(4, Seed::root(7)), 10);
        assert_eq!(redrawn[..4], first[..4]);
        assert!(redrawn[4..].iter().zip(&first[4..]).all(|(a, b)| a != b));
        let shifted = draw(&mut tape.shifted(Seed::root(8), |number| if number == 3 { -0.25 } else { 0.001 }), 10);
        for (number, (before, after)) in first.iter().zip(shifted).enumerate() {
            let wanted: f64 = before + if number == 3 { 0.75 } else { 0.001 };
            assert!((after - (wanted - wanted.floor())).abs() < 1e-12, "{number}: {before} to {after}");
        }
    }

    #[test]
    fn a_stream_can_begin_within_the_tape() {
        let mut tape = Tape::new(Seed::root(9));
        let first = draw(&mut tape, 10);
        let mut stream = tape.redrawn(10, Seed::root(1)).stream(4);
        assert_eq!((4..10).map(|_| stream.random()).collect::<Vec<f64>>(), first[4..]);
    }
}
