use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand::{Rng, SeedableRng, TryRng};
use rand_chacha::ChaCha8Rng;

/// The generator of every stream: ChaCha with eight rounds, the same numbers on every machine.
///
/// A stream of a [`Tape`](super::Tape) draws the words of the tape first.
#[derive(Debug, Clone)]
pub struct Stream {
    source: ChaCha8Rng,
    played: Option<Box<Played>>,
}

/// The words of a tape that a stream draws before its own.
#[derive(Debug, Clone)]
pub(super) struct Played {
    pub words: Arc<[u64]>,
    /// Words that were drawn, those of the stream itself included. The tape's owner reads it.
    pub drawn: Arc<AtomicUsize>,
    /// The number of the next word.
    pub next: usize,
}

impl Stream {
    /// The stream of a seed (32 bytes) after a number of 32-bit words.
    pub fn at(seed: [u8; 32], word: u128) -> Self {
        let mut source = ChaCha8Rng::from_seed(seed);
        source.set_word_pos(word);
        Self { source, played: None }
    }

    /// The seed from which it started.
    pub fn seed(&self) -> [u8; 32] {
        self.source.get_seed()
    }

    /// The number of 32-bit words that were drawn from it.
    pub fn word(&self) -> u128 {
        self.source.get_word_pos()
    }

    pub(super) fn playing(self, played: Played) -> Self {
        Self { played: Some(Box::new(played)), ..self }
    }
}

impl Played {
    /// The next word of the tape; none after its end.
    fn draw(&mut self) -> Option<u64> {
        let word = self.words.get(self.next).copied();
        self.next += 1;
        self.drawn.store(self.next, Ordering::Relaxed);
        word
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        // On a tape each draw takes a whole word, of which the upper half says most.
        match &self.played {
            None => Ok(self.source.next_u32()),
            Some(_) => self.try_next_u64().map(|word| (word >> 32) as u32),
        }
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let played = self.played.as_mut().and_then(|played| played.draw());
        Ok(played.unwrap_or_else(|| self.source.next_u64()))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        if self.played.is_none() {
            self.source.fill_bytes(bytes);
            return Ok(());
        }
        for part in bytes.chunks_mut(8) {
            let Ok(word) = self.try_next_u64();
            part.copy_from_slice(&word.to_le_bytes()[..part.len()]);
        }
        Ok(())
    }
}
