use std::path::Path;

use crate::session::{Input, Session};
use episode::Scenario;
use lang::reason;
use results::report::JudgedMeeting;
use road::geometry::Obstacles;
use verdict::{Meeting, Recording, Sizes, Units};

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
    meetings: Vec<Meeting>,
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
            let recording = Recording::from_csv_in(&text, units).map_err(|error| error.to_string())?;
            let dt = recording.dt();
            let (car, pedestrian) = ("ego".to_owned(), "pedestrian".to_owned());
            let (sizes, obstacles) = (Sizes::default(), Obstacles::new(&[]).into());
            return Ok(Self { meetings: vec![Meeting { car, pedestrian, first: 0, recording, sizes, obstacles }], dt });
        }
        let bytes = base::files::bytes(file).map_err(|error| reason(&error))?;
        let scene = export::read_trace(&bytes).map_err(|error| error.to_string())?;
        if let Some(name) =
            car.filter(|name| !scene.actors.iter().any(|actor| !actor.is_pedestrian && actor.name == **name))
        {
            let known = scene.actors.iter().filter(|actor| !actor.is_pedestrian).take(20).map(|actor| &*actor.name);
            return Err(format!("there is no car `{name}`; there is {}", known.collect::<Vec<_>>().join(", ")));
        }
        let meetings = scene.meetings(near, car).into_iter().map(|(car, pedestrian, meeting)| {
            meeting.map_err(|error| format!("the car {car} and the pedestrian {pedestrian}: {error}"))
        });
        Ok(Self { meetings: meetings.collect::<Result<_, _>>()?, dt: scene.dt })
    }

    /// Judges each, with these sizes in the place of the recorded ones.
    ///
    /// # Errors
    /// A size is out of its range.
    pub fn judged(self, stated: Sizes) -> Result<Vec<JudgedMeeting>, String> {
        let paper = paper().map_err(|error| error.to_string())?;
        let judged = |meeting: Meeting| {
            let mut scenario = paper.clone();
            stated.or(meeting.sizes).apply(&mut scenario).map_err(|error| error.to_string())?;
            let found = meeting.recording.judged(&scenario, meeting.obstacles);
            let (answers, sensitivity) = (found.answers(), found.sensitivity());
            let begins = meeting.first as f64 * self.dt;
            Ok(JudgedMeeting { car: meeting.car, pedestrian: meeting.pedestrian, begins, found, answers, sensitivity })
        };
        self.meetings.into_iter().map(judged).collect()
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
