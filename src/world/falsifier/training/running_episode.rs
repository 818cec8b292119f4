use crate::sim::WalkCommand;

/// A running episode up to now, with all data to repeat it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RunningEpisode {
    /// The number of the next episode; 0 when none has started.
    pub(super) next_episode: u64,
    /// The commands up to now.
    pub(super) decisions: Vec<WalkCommand>,
    /// The hash of its start and of its states, which a repetition must reach.
    pub(super) digest: u64,
}

impl RunningEpisode {
    /// Encodes it as 64-bit words, least significant byte first: number, hash, heading and speed of each command.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let commands = self.decisions.iter().flat_map(|command| [command.heading, command.speed]);
        let words = [self.next_episode, self.digest].into_iter().chain(commands.map(f64::to_bits));
        words.flat_map(u64::to_le_bytes).collect()
    }

    /// Decodes it; `None` if the bytes have another form.
    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, rest) = bytes.as_chunks::<8>();
        let [next_episode, digest, commands @ ..] = words else { return None };
        let (commands, odd) = commands.as_chunks::<2>();
        if !rest.is_empty() || !odd.is_empty() {
            return None;
        }
        let number = |word: &[u8; 8]| Some(f64::from_le_bytes(*word)).filter(|number| number.is_finite());
        let decision =
            |[heading, speed]: &[[u8; 8]; 2]| Some(WalkCommand { heading: number(heading)?, speed: number(speed)? });
        Some(Self {
            next_episode: u64::from_le_bytes(*next_episode),
            decisions: commands.iter().map(decision).collect::<Option<_>>()?,
            digest: u64::from_le_bytes(*digest),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_running_episode_returns_bit_for_bit_and_damage_is_noticed() {
        let decisions =
            vec![WalkCommand { heading: -0.1, speed: 3.5 }, WalkCommand { heading: f64::MIN_POSITIVE, speed: -0.0 }];
        let running = RunningEpisode { next_episode: 1 << 60 | 1, decisions, digest: u64::MAX };
        let bytes = running.to_bytes();
        assert_eq!(RunningEpisode::from_bytes(&bytes), Some(running.clone()));
        assert_eq!(RunningEpisode::from_bytes(&bytes).unwrap().to_bytes(), bytes);
        for end in (0..bytes.len()).filter(|end| ![16, 32].contains(end)) {
            assert_eq!(RunningEpisode::from_bytes(&bytes[..end]), None, "{end}");
        }
        let mut infinite = running;
        infinite.decisions[1].heading = f64::INFINITY;
        assert_eq!(RunningEpisode::from_bytes(&infinite.to_bytes()), None);
    }
}
