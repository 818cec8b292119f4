use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::cli::console;
use crate::cli::failure::{misused, unwritten};
use crate::exit_code::{Ended, ExitCode};
use lang::reason;

pub const EXAMPLES: &str = "\
Examples:
  falsify new                                write scenario.scn: an adult crosses a street
  falsify new child.scn --template child-behind-parked-cars
  falsify new --template own-driver          also writes my_av.py, a driver in Python
  falsify new --list                         list the templates
  falsify new night.scn && falsify run --smoke night.scn";

/// Options of `falsify new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The file; one that exists is never replaced.
    #[arg(default_value = "scenario.scn", value_name = "PATH")]
    pub path: PathBuf,
    /// The experiment to start from.
    #[arg(long, value_enum, default_value_t = Template::Crossing, value_name = "NAME")]
    pub template: Template,
    /// List the templates.
    #[arg(long)]
    pub list: bool,
}

/// A scenario to start from. Each has a pedestrian with human limits and a reward for collisions that are faults to the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// An adult crosses a street in front of a car that drives; a search for faults of two drivers in two towns.
    Crossing,
    /// A child runs out between parked cars, which hide it.
    ChildBehindParkedCars,
    /// A parked van hides a child; which failures need the van?
    VanHidesChild,
    /// A car follows so closely that hard braking is dangerous, too.
    FollowerTooClose,
    /// A group of which two walk apart.
    GroupThatSplits,
    /// Your driver as a program, with an example in Python.
    OwnDriver,
    /// The pedestrian tests of Euro NCAP for your drivers, and a search beyond them.
    Protocol,
    /// The experiment of the paper "Suicidal Pedestrian", and the same with a pedestrian with human limits.
    Paper,
}

impl Template {
    /// The text of the scenario.
    const fn text(self) -> &'static str {
        match self {
            Self::Crossing => include_str!("templates/crossing.scn"),
            Self::ChildBehindParkedCars => include_str!("templates/child-behind-parked-cars.scn"),
            Self::VanHidesChild => include_str!("templates/van-hides-child.scn"),
            Self::FollowerTooClose => include_str!("templates/follower-too-close.scn"),
            Self::GroupThatSplits => include_str!("templates/group-that-splits.scn"),
            Self::OwnDriver => include_str!("templates/own-driver.scn"),
            Self::Protocol => include_str!("templates/protocol.scn"),
            Self::Paper => include_str!("templates/paper.scn"),
        }
    }

    /// A file that the scenario needs beside it: its name and its text.
    const fn companion(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::OwnDriver => Some(("my_av.py", include_str!("templates/my_av.py"))),
            _ => None,
        }
    }

    /// The option that `falsify run` needs for the scenario, with a blank after it.
    const fn option(self) -> &'static str {
        match self {
            Self::OwnDriver => "--allow-external ",
            _ => "",
        }
    }
}

pub fn new(options: &NewArgs) -> Ended {
    let NewArgs { path, template, list } = options;
    if *list {
        for value in Template::value_variants().iter().filter_map(Template::to_possible_value) {
            let about = value.get_help().map(ToString::to_string).unwrap_or_default();
            console::say(&format!("{:27}{about}", value.get_name()));
        }
        return Ok(ExitCode::Done);
    }
    write_new(path, template.text())?;
    console::say(&format!("{} is written", path.display()));
    if let Some((name, text)) = template.companion() {
        let beside = path.with_file_name(name);
        // A driver of the user keeps its place; the scenario then runs with it.
        if beside.exists() {
            console::warn(&format!("`{}` exists already and was left alone; the scenario uses it", beside.display()));
        } else {
            write_new(&beside, text)?;
            console::say(&format!("{} is written", beside.display()));
        }
    }
    console::say(&format!("next: falsify run {}{}", template.option(), path.display()));
    Ok(ExitCode::Done)
}

/// Writes a file that must not exist yet.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn write_new(path: &Path, text: &str) -> Result<(), ExitCode> {
    let written = File::create_new(path).and_then(|mut file| {
        // A part of a file would be in the way of the next attempt.
        file.write_all(text.as_bytes()).inspect_err(|_| drop(std::fs::remove_file(path)))
    });
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            misused(format!("`{}` exists already and was left alone; name another file", path.display()))
        }
        ErrorKind::NotFound => {
            let folder = path.parent().unwrap_or(Path::new(".")).display();
            misused(format!("cannot write `{}`: there is no folder `{folder}`; make it first", path.display()))
        }
        _ => unwritten(format!("cannot write `{}`: {}", path.display(), reason(&error))),
    })
}
