use std::convert::Infallible;

use rand::{Rng, SeedableRng, TryRng};
use rand_chacha::ChaCha8Rng;

/// The generator of every stream: ChaCha with eight rounds, the same numbers on every machine.
#[derive(Debug, Clone)]
pub struct Stream {
    source: ChaCha8Rng,
    /// Whether a draw of 32 bits takes the upper half of 64.
    is_wide: bool,
}

impl Stream {
    /// The stream of a seed (32 bytes) after a number of 32-bit words.
    pub fn at(seed: [u8; 32], word: u128) -> Self {
        let mut source = ChaCha8Rng::from_seed(seed);
        source.set_word_pos(word);
        Self { source, is_wide: false }
    }

    /// The seed from which it started.
    pub fn seed(&self) -> [u8; 32] {
        self.source.get_seed()
    }

    /// The number of 32-bit words that were drawn from it.
    pub fn word(&self) -> u128 {
        self.source.get_word_pos()
    }

    pub(super) fn widened(self) -> Self {
        Self { is_wide: true, ..self }
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(if self.is_wide { (self.source.next_u64() >> 32) as u32 } else { self.source.next_u32() })
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.source.next_u64())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.source.fill_bytes(bytes);
        Ok(())
    }
}
