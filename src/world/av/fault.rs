/// Why a driver, a controller or a world failed as a program. An episode in which this happens counts neither as passed nor as failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Its process could not be started.
    #[error("could not be started")]
    NotStarted,
    /// Its greeting did not follow the protocol, or was of an unsupported version.
    #[error("greeted wrongly: {0}")]
    Greeting(&'static str),
    /// It did not answer in time.
    #[error("did not answer within {limit_ms} ms")]
    Late {
        /// The time it had (ms).
        limit_ms: u32,
    },
    /// It did not greet, load a town or begin an episode in time.
    #[error("did not answer within {limit_ms} ms, its `start_timeout`")]
    LateStart {
        /// The time it had (ms).
        limit_ms: u32,
    },
    /// It ended, or closed its output.
    #[error("ended before it answered{0}")]
    Ended(Exit),
    /// It ended during other episodes, of which this was one.
    #[error("was restarted during the episode")]
    Restarted,
    /// The user asked to stop while it was waited for. Its episode is not over: nothing is concluded from it.
    #[error("was not waited for, since the user asked to stop")]
    Stopped,
    /// It gave an answer that makes no sense.
    #[error("gave a wrong answer: {0}")]
    Answer(&'static str),
    /// A world has moved a pedestrian to another place than it was told.
    #[error("moved a pedestrian to {millimetres} mm from where it was told")]
    Moved {
        /// The distance between the two places (mm).
        millimetres: u32,
    },
    /// A world moves pedestrians later than it was told.
    #[error("puts pedestrians where they were to be {ticks} {} earlier", if *ticks == 1 { "tick" } else { "ticks" })]
    Delayed {
        /// How much later.
        ticks: u32,
    },
    /// A world begins an episode with the car elsewhere, or with another speed.
    #[error(
        "began with the car {:.2} m from where it was told, turned by {degrees}°, {:+.1} m/s faster: another frame, another unit, or a car that has not settled",
        f64::from(*millimetres) / 1000.0, f64::from(*faster) / 10.0
    )]
    Placed {
        /// The distance (mm), and the angle (°).
        millimetres: u32,
        degrees: i32,
        /// Its speed less the one that it was told (0.1 m/s).
        faster: i32,
    },
    /// A world has moved the car to another place than its speed and its heading lead to in a tick.
    #[error(
        "put the car {millimetres} mm from where its `speed` and `yaw` lead in a tick: it jumps, or one of them or the length of its step is wrong"
    )]
    Jumped {
        /// The distance between the two places (mm).
        millimetres: u32,
    },
    /// The way of a car of a world is not the one that its speeds make.
    #[error(
        "moved the car {} m in an episode, and its `speed` makes {} m: that is not in m/s, or a step not a tick",
        f64::from(*way) / 10.0, f64::from(*by_speed) / 10.0
    )]
    Way {
        /// Its way (0.1 m).
        way: u32,
        /// The one that its speeds make (0.1 m).
        by_speed: u32,
    },
    /// A car of a world moves beside its heading.
    #[error("moves the car {degrees}° beside its `yaw`, which is its heading in rad, counter-clockwise from x")]
    Beside {
        /// The angle between motion and heading (°).
        degrees: u32,
    },
    /// A car of a world speeds up or brakes otherwise than its control says.
    #[error(
        "changed the speed of the car by {:+.1} m/s in about 2 s, and its control by {:+.1} m/s: carry out `acceleration`, or `throttle` and `brake`, in the tick that they come with",
        f64::from(*done) / 10.0, f64::from(*told) / 10.0
    )]
    Pedals {
        /// What its control allows that is nearest to what it did, and what it did (0.1 m/s).
        told: i32,
        done: i32,
    },
    /// A car of a world brakes otherwise than its brake says.
    #[error(
        "slowed the car by {:.1} m/s while its brake was on, and its brake by {:.1} m/s: carry out `acceleration` or `brake` in the tick that it comes with, or state `pedal_delay`",
        f64::from(*done) / 10.0, f64::from(*told) / 10.0
    )]
    Brake {
        /// The same of an episode.
        told: i32,
        done: i32,
    },
    /// A car of a world turns otherwise than its control says.
    #[error(
        "turned the car by {done}° in about 2 s, and its control by {told}°, positive to the left: carry out `wheel_angle`, in rad, or `steer`, in the tick that they come with"
    )]
    Wheel {
        /// The same in °.
        told: i32,
        done: i32,
    },
    /// A world has lanes elsewhere than the town has.
    #[error("has lanes up to {millimetres} mm from those of the town")]
    Lanes {
        /// The distance of a lane from that of the town (mm).
        millimetres: u32,
    },
    /// The map of the town cannot be written for a world.
    #[error("gets no map of the town")]
    NoMap,
    /// A world ended an episode before it was over.
    #[error("ended the episode before it was over")]
    EndedEarly,
    /// A key of a message of it has a value of a wrong type.
    #[error("{}: `{key}` is {found}; give {wanted}", if *greeting { "greeted wrongly" } else { "gave a wrong answer" })]
    WrongType {
        /// Whether the message is its greeting.
        greeting: bool,
        key: &'static str,
        /// The type that it gave.
        found: &'static str,
        /// The type that is needed.
        wanted: &'static str,
    },
    /// A message of it is not JSON.
    #[error("{}: not JSON: `{text}`", if *greeting { "greeted wrongly" } else { "gave a wrong answer" })]
    NotJson {
        /// Whether the message is its greeting.
        greeting: bool,
        /// Its beginning.
        text: Word,
    },
    /// An action of it has a key that no action has.
    #[error("gave a wrong answer: an action with the key `{key}`; known are {known}")]
    UnknownKey {
        key: Word,
        /// The keys of an action.
        known: &'static str,
    },
    /// A number in a message of it is beyond the range of `f64`.
    #[error("{}: `{key}` is {number}, and the largest number is about 1.8e308", if *greeting { "greeted wrongly" } else { "gave a wrong answer" })]
    TooLarge {
        /// Whether the message is its greeting.
        greeting: bool,
        key: Word,
        number: Word,
    },
}

impl Fault {
    /// The same fault while a program starts.
    pub fn at_start(self) -> Self {
        match self {
            Self::Late { limit_ms } => Self::LateStart { limit_ms },
            other => other,
        }
    }
}

/// The beginning of a text of a program, 24 bytes at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word([u8; 24]);

impl Word {
    /// Stands for what follows.
    const MORE: u8 = 1;

    /// The beginning of a text; bytes that are no printable ASCII become `?`.
    pub fn new(text: &[u8]) -> Self {
        let byte = |place: usize| match text.get(place) {
            Some(_) if place == 23 && text.len() > 24 => Self::MORE,
            Some(byte) if byte.is_ascii_graphic() || *byte == b' ' => *byte,
            Some(_) => b'?',
            None => 0,
        };
        Self(std::array::from_fn(byte))
    }
}

impl std::fmt::Display for Word {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&String::from_utf8_lossy(&self.0).trim_end_matches('\0').replace(char::from(Self::MORE), "…"))
    }
}

/// How a program ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// It runs on, or nothing is known.
    Unknown,
    /// With an exit code.
    Code(i32),
    /// By a signal of this name.
    Signal(&'static str),
}

impl std::fmt::Display for Exit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown => Ok(()),
            Self::Code(code) => write!(f, " with exit code {code}"),
            Self::Signal(signal) => write!(f, " with signal {signal}"),
        }
    }
}
