//! Traces of `GroundTruth` or `SensorView` messages, as they are written by us and by others.

use std::collections::BTreeMap;

use base::messages;
use mcap::sans_io::LinearReaderOptions;
use prost::Message;

use super::messages::{Base, GroundTruth, Identifier, MovingObject};
use road::geometry::{OrientedBox, Pose, Vector};
use verdict::{RecordedActor, RecordedScene};

messages! {
    /// A view of a sensor; only what a simulator knows is read.
    SensorView {
        ground_truth: Option<GroundTruth> = 7 (message, optional),
    }
    /// The objects of a `GroundTruth`, which are counted before memory is taken for them.
    Counted {
        standing: Vec<Unread> = 4 (message, repeated),
        moving: Vec<Unread> = 5 (message, repeated),
    }
    CountedView {
        ground_truth: Option<Counted> = 7 (message, optional),
    }
    Unread {}
}

/// A file that holds no trace of ground truth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TraceError {
    #[error("it is a damaged MCAP file: {0}")]
    Mcap(String),
    #[error("there is no message of `osi3.GroundTruth` or `osi3.SensorView` in it; there is {0}")]
    Empty(String),
    #[error("message {number} is no ground truth: {reason}")]
    Message { number: usize, reason: String },
    #[error("message {number} ends after {found} of {wanted} bytes: the file is cut")]
    Cut { number: usize, found: usize, wanted: usize },
    #[error("{0}; cut the recording")]
    Large(String),
    #[error("message {number}: the object {object} has no {what}")]
    Missing { number: usize, object: u64, what: &'static str },
    #[error(
        "message {number} is {found} s after the one before, and the usual step is {step} s; give messages at a constant step (within a half of it)"
    )]
    Uneven { number: usize, found: f64, step: f64 },
    #[error("there are fewer than two messages")]
    Short,
}

/// Numbers of enumerations: a vehicle and a pedestrian; vehicles that are no cars: bicycle, wheelchair, scooter standing and sitting.
const VEHICLE: i32 = 2;
const PEDESTRIAN: i32 = 3;
const NO_CARS: [i32; 4] = [11, 15, 17, 18];
/// Objects that are lower do not hide a pedestrian (m).
const LOW: f64 = 1.2;

/// The most bytes of a message, and of all chunks before they were compressed; the most objects of a message, messages, and states of actors.
const MAX_MESSAGE: usize = 16 << 20;
const MAX_CHUNKS: u64 = 4 << 30;
const MAX_OBJECTS: usize = 100_000;
const MAX_MESSAGES: usize = verdict::Recording::MAX_INSTANTS;
const MAX_STATES: usize = 5_000_000;

/// Reads a trace: an MCAP file, or messages with their lengths before them.
///
/// # Errors
/// The file is cut, is larger than memory should hold, has no such messages, or they have no constant step.
pub fn read(bytes: &[u8]) -> Result<RecordedScene, TraceError> {
    let mut reader = Reader::default();
    if bytes.starts_with(b"\x89MCAP") {
        reader.read_mcap(bytes)?;
    } else {
        reader.read_lengths(bytes)?;
    }
    reader.scene()
}

/// Whether the first `size` bytes of a chunk are whole records, each a byte and its length before it.
fn is_whole(data: &[u8], size: usize) -> bool {
    let Some(mut rest) = data.get(..size) else { return false };
    while let Some((head, after)) = rest.split_first_chunk::<9>() {
        let length = u64::from_le_bytes(*head.last_chunk().unwrap_or(&[0; 8]));
        let Some(next) = usize::try_from(length).ok().and_then(|length| after.get(length..)) else { return false };
        rest = next;
    }
    rest.is_empty()
}

/// What was read up to now.
#[derive(Default)]
struct Reader {
    /// The times of the messages (s).
    times: Vec<f64>,
    /// The parts of each object's track.
    tracks: BTreeMap<u64, Vec<RecordedActor>>,
    obstacles: BTreeMap<u64, OrientedBox>,
    host: Option<u64>,
    /// The number of states of all tracks.
    states: usize,
}

impl Reader {
    fn read_mcap(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        let failed = |error: mcap::McapError| TraceError::Mcap(error.to_string());
        let mut chunks = 0_u64;
        for record in mcap::read::LinearReader::new(bytes).map_err(failed)? {
            if let mcap::records::Record::Chunk { header, data } = record.map_err(failed)? {
                chunks = chunks.saturating_add(header.uncompressed_size);
                let is_open = header.compression.is_empty();
                if is_open && !usize::try_from(header.compressed_size).is_ok_and(|size| is_whole(&data, size)) {
                    return Err(TraceError::Mcap("a chunk ends within a record".to_owned()));
                }
            }
        }
        if chunks > MAX_CHUNKS {
            return Err(TraceError::Large(format!("its chunks have {chunks} bytes; at most {MAX_CHUNKS} are read")));
        }
        let mut others = BTreeMap::<String, usize>::new();
        let options = LinearReaderOptions::default().with_record_length_limit(MAX_MESSAGE);
        for message in mcap::io::MessageReader::new_with_options(bytes, options) {
            let message = message.map_err(failed)?;
            Self::check_objects(&message.data, self.times.len() + 1)?;
            let schema = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
            let read = match schema {
                "osi3.GroundTruth" => GroundTruth::decode(&*message.data).map(Some),
                "osi3.SensorView" => SensorView::decode(&*message.data).map(|view| view.ground_truth),
                _ => {
                    *others.entry(schema.to_owned()).or_default() += 1;
                    continue;
                }
            };
            let number = self.times.len() + 1;
            let read = read.map_err(|error| TraceError::Message { number, reason: error.to_string() })?;
            read.map_or(Ok(()), |truth| self.add(&truth))?;
        }
        if self.times.is_empty() {
            let names: Vec<String> = others.into_iter().map(|(name, count)| format!("{count} of `{name}`")).collect();
            return Err(TraceError::Empty(if names.is_empty() { "none".to_owned() } else { names.join(", ") }));
        }
        Ok(())
    }

    /// # Errors
    /// The message has too many objects, as a ground truth or as a view.
    fn check_objects(data: &[u8], number: usize) -> Result<(), TraceError> {
        let view = CountedView::decode(data).ok().and_then(|view| view.ground_truth);
        let counted = [Counted::decode(data).ok(), view].into_iter().flatten();
        let most = counted.map(|truth| truth.standing.len() + truth.moving.len()).max().unwrap_or(0);
        match most > MAX_OBJECTS {
            true => {
                Err(TraceError::Large(format!("message {number} has {most} objects; at most {MAX_OBJECTS} are read")))
            }
            false => Ok(()),
        }
    }

    /// Reads messages with their lengths before them, as four bytes, the lowest first.
    fn read_lengths(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        let mut rest = bytes;
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            let (number, wanted) = (self.times.len() + 1, u32::from_le_bytes(*length) as usize);
            let Some((data, next)) = after.split_at_checked(wanted) else {
                return Err(TraceError::Cut { number, found: after.len(), wanted });
            };
            if wanted > MAX_MESSAGE {
                let most = format!("message {number} has {wanted} bytes; at most {MAX_MESSAGE} are read");
                return Err(TraceError::Large(most));
            }
            Self::check_objects(data, number)?;
            let refused = |error: prost::DecodeError| TraceError::Message { number, reason: error.to_string() };
            let is_truth = |truth: &GroundTruth| truth.timestamp.is_some() && !truth.moving_objects.is_empty();
            let truth = match GroundTruth::decode(data) {
                Ok(truth) if is_truth(&truth) => truth,
                read => match SensorView::decode(data).ok().and_then(|view| view.ground_truth) {
                    Some(truth) => truth,
                    None => read.map_err(refused)?,
                },
            };
            self.add(&truth)?;
            rest = next;
        }
        // Fewer than the four bytes of a length.
        if !rest.is_empty() {
            return Err(TraceError::Cut { number: self.times.len() + 1, found: rest.len(), wanted: 4 });
        }
        Ok(())
    }

    fn add(&mut self, truth: &GroundTruth) -> Result<(), TraceError> {
        let instant = self.times.len();
        self.states += truth.moving_objects.len();
        if instant == MAX_MESSAGES || self.states > MAX_STATES {
            let most = format!("it has more than {MAX_MESSAGES} messages or {MAX_STATES} states of objects");
            return Err(TraceError::Large(most));
        }
        let stamp = truth.timestamp.clone().unwrap_or_default();
        self.times.push(stamp.seconds.unwrap_or(0) as f64 + f64::from(stamp.nanos.unwrap_or(0)) * 1e-9);
        self.host = self.host.or(truth.host_vehicle.as_ref().map(|id| value(Some(id))));
        for object in &truth.stationary_objects {
            let found = object.base.as_ref().and_then(placed).filter(|(.., height)| *height >= LOW);
            if let Some((pose, (length, width), _)) = found {
                self.obstacles.insert(value(object.id.as_ref()), OrientedBox::new(pose, length / 2.0, width / 2.0));
            }
        }
        truth.moving_objects.iter().try_for_each(|object| self.add_moving(instant, object))
    }

    fn add_moving(&mut self, instant: usize, object: &MovingObject) -> Result<(), TraceError> {
        let is_pedestrian = object.kind == Some(PEDESTRIAN);
        let class = object.classification.as_ref().and_then(|class| class.kind);
        let is_car = object.kind == Some(VEHICLE) && class.is_none_or(|kind| !NO_CARS.contains(&kind));
        if !is_pedestrian && !is_car {
            return Ok(());
        }
        let id = value(object.id.as_ref());
        let missing = |what| TraceError::Missing { number: instant + 1, object: id, what };
        let base = object.base.as_ref().ok_or_else(|| missing("base"))?;
        let (pose, size, _) = placed(base).ok_or_else(|| missing("position, heading and size in numbers"))?;
        let velocity = base.velocity.as_ref().and_then(|velocity| Some(Vector::new(velocity.x?, velocity.y?)));
        let parts = self.tracks.entry(id).or_default();
        // Who was away for a time is another actor with the same name.
        let is_next = |part: &&mut RecordedActor| part.first + part.states.len() == instant;
        match parts.last_mut().filter(is_next) {
            Some(part) => part.states.push((pose, velocity)),
            None => parts.push(RecordedActor {
                name: id.to_string(),
                is_pedestrian,
                size: Some(size).filter(|(length, width)| *length > 0.0 && *width > 0.0),
                first: instant,
                states: vec![(pose, velocity)],
            }),
        }
        Ok(())
    }

    /// The usual step between the messages (s).
    fn step(&self) -> Result<f64, TraceError> {
        let times = &self.times;
        let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let usual = *sorted.get(steps.len() / 2).ok_or(TraceError::Short)?;
        let mean = (times[steps.len()] - times[0]) / steps.len() as f64;
        let is_late = |(place, time): (usize, &f64)| {
            let off = (time - times[0] - place as f64 * mean).abs();
            off.is_nan() || off > mean.abs() / 2.0
        };
        if !times.iter().enumerate().any(is_late) {
            return Ok(mean);
        }
        let far = |place: &usize| (steps[*place] - usual).abs();
        let worst = (0..steps.len()).max_by(|one, other| far(one).total_cmp(&far(other))).unwrap_or(0);
        Err(TraceError::Uneven { number: worst + 2, found: steps[worst], step: usual })
    }

    fn scene(self) -> Result<RecordedScene, TraceError> {
        let dt = self.step()?;
        let actors: Vec<RecordedActor> = self.tracks.into_values().flatten().collect();
        let host = self.host.map(|id| id.to_string());
        let host = host.filter(|name| actors.iter().any(|actor| !actor.is_pedestrian && actor.name == *name));
        Ok(RecordedScene { dt, actors, host, obstacles: self.obstacles.into_values().collect() })
    }
}

fn value(id: Option<&Identifier>) -> u64 {
    id.and_then(|id| id.value).unwrap_or(0)
}

/// The pose of the middle, length and width (m), and height (m) of an object.
fn placed(base: &Base) -> Option<(Pose, (f64, f64), f64)> {
    let position = base.position.as_ref()?;
    let (size, turned) =
        (base.dimension.clone().unwrap_or_default(), base.orientation.as_ref().and_then(|turned| turned.z));
    let length = |of: Option<f64>| of.unwrap_or(0.0);
    let pose = Pose::new(position.x?, position.y?, turned.unwrap_or(0.0));
    let numbers = [pose.x, pose.y, pose.yaw, length(size.x), length(size.y), length(size.z)];
    numbers.iter().all(|number| number.is_finite()).then_some((pose, (length(size.x), length(size.y)), length(size.z)))
}
