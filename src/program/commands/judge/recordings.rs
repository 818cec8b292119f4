use std::path::Path;

use crate::session::{Input, Session};
use episode::Scenario;
use lang::reason;
use results::report::{JudgedMeeting, JudgedRecording, Unjudged};
use road::geometry::Obstacles;
use verdict::{Encountered, Meeting, NamedMeeting, Recording, RecordingError, Sizes, Units};

/// The paper's car and pedestrian, whose sizes and grip a recording has when nothing else is stated.
const PAPER: &str = "\
edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import \"std/towns.scn\"
campaign recording {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  drivers: [blind]  pedestrians: [random]  episodes: 1 }
}
";
/// Its name among the files of a session.
const PAPER_FILE: &str = "recording.scn";

/// The encounters of a file.
pub struct Recordings {
    meetings: Vec<NamedMeeting>,
    dt: f64,
}

impl Recordings {
    /// Reads a file; of a scene the pairs that come near each other are encounters.
    ///
    /// # Errors
    /// Why it cannot be judged.
    pub fn read(file: &Path, near: f64, car: Option<&str>, units: &Units) -> Result<Self, String> {
        let ends = |end: &str| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(end));
        if !ends("mcap") && !ends("osi") {
            let text = base::files::text(file).map_err(|error| reason(&error))?;
            let recording =
                Recording::from_csv(&text, units).map_err(|error| with_option(&error.to_string(), &OPTIONS))?;
            let dt = recording.dt();
            let (car, pedestrian) = ("ego".to_owned(), "pedestrian".to_owned());
            let (sizes, obstacles) = (Sizes::default(), Obstacles::new(&[]).into());
            let meeting = Meeting { first: 0, recording, sizes, obstacles };
            return Ok(Self { meetings: vec![(car, pedestrian, Ok(meeting))], dt });
        }
        let bytes = base::files::bytes(file).map_err(|error| reason(&error))?;
        let scene = export::read_trace(&bytes).map_err(|error| error.to_string())?;
        if let Some(name) =
            car.filter(|name| !scene.actors.iter().any(|actor| !actor.is_pedestrian && actor.name == **name))
        {
            let known = scene.actors.iter().filter(|actor| !actor.is_pedestrian).take(20).map(|actor| &*actor.name);
            return Err(format!("there is no car `{name}`; there is {}", known.collect::<Vec<_>>().join(", ")));
        }
        Ok(Self { meetings: scene.meetings(near, car, units.without_velocity), dt: scene.dt })
    }

    /// Judges each, with these sizes in the place of the recorded ones.
    ///
    /// # Errors
    /// A stated size is out of its range, or no pair can be judged.
    pub fn judged(self, stated: Sizes) -> Result<JudgedRecording, String> {
        let paper = paper().map_err(|error| error.to_string())?;
        stated.apply(&mut paper.clone()).map_err(|error| error.to_string())?;
        let judged = |meeting: Meeting| -> Result<(usize, Encountered), RecordingError> {
            let mut scenario = paper.clone();
            stated.or(meeting.sizes).apply(&mut scenario)?;
            Ok((meeting.first, meeting.recording.judged(&scenario, meeting.obstacles)))
        };
        let mut all = JudgedRecording::default();
        for (car, pedestrian, meeting) in self.meetings {
            match meeting.and_then(judged) {
                Ok((first, found)) => {
                    let (answers, sensitivity, begins) = (found.answers(), found.sensitivity(), first as f64 * self.dt);
                    all.encounters.push(JudgedMeeting { car, pedestrian, begins, found, answers, sensitivity });
                }
                Err(error) => {
                    all.unjudged.push(Unjudged { car, pedestrian, reason: with_option(&error.to_string(), &[]) });
                }
            }
        }
        JudgedMeeting::sort(&mut all.encounters);
        match all.unjudged.first() {
            Some(first) if all.encounters.is_empty() => Err(first.to_string()),
            _ => Ok(all),
        }
    }
}

/// The scenario with the paper's car and pedestrian.
fn paper() -> Result<Scenario, crate::session::Error> {
    let session = Session::default().with_reader(|path: &Path| match path.to_str() {
        Some(PAPER_FILE) => Ok(PAPER.to_string()),
        _ => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
    });
    let checked = session.check(&Input::file(PAPER_FILE))?;
    Ok(Scenario::clone(&checked.plan()?.campaigns[0].nth::<compile::Evaluation>(0).scenario))
}

/// The options that say what a table looks like, for the reasons that name it. A trace has the units of its standard.
const OPTIONS: [(&str, &str); 7] = [
    ("look like milliseconds", "--time-unit ms"),
    ("look like microseconds", "--time-unit us"),
    ("look like nanoseconds", "--time-unit ns"),
    ("look like km/h", "--speed-unit km/h"),
    ("look like mph", "--speed-unit mph"),
    ("look like radians", "--heading-unit rad"),
    ("look like compass bearings", "--heading-unit compass"),
];

/// A reason, with the one of these options that helps, or that which leaves the velocity of pedestrians out.
fn with_option(reason: &str, options: &[(&str, &str)]) -> String {
    let body = reason.contains("leave out speed and heading").then_some("--no-velocity");
    let option = options.iter().find(|(words, _)| reason.contains(words)).map(|(_, option)| *option);
    option.or(body).map_or_else(|| reason.to_owned(), |option| format!("{reason} (`{option}`)"))
}
