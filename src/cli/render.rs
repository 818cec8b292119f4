use std::path::PathBuf;

use clap::Args;

use super::episode::NameOptions;
use super::exit_code::ExitCode;
use super::input::session;
use super::{console, failure};
use crate::session::{Animation, Export, ReplayOptions, Session, Strip};

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify render 1a2b3c4d:17                 1a2b3c4d-17.svg: six frames, and the speeds of both
  falsify render 1a2b3c4d:17 --animate -o hit.svg
                                             an animation; open it in a browser
  falsify failures --names --top 5 | falsify render -
                                             the five worst failures of reports/

Exit codes: as those of `falsify replay`";

/// Options of `falsify render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    /// The episodes.
    #[command(flatten)]
    pub which: NameOptions,
    /// The picture of one episode; by default RUN-EPISODE.svg in this folder.
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Draw an animation instead of six frames.
    #[arg(long)]
    pub animate: bool,
}

/// `falsify render`
pub fn render(options: &RenderOptions) -> ExitCode {
    let episodes = match options.which.replays() {
        Ok(episodes) if episodes.len() > 1 && options.out.is_some() => {
            console::fail("--out names one picture, so it takes one episode");
            return ExitCode::Usage;
        }
        Ok(episodes) => episodes,
        Err(code) => return code,
    };
    let session = session(options.which.repeat.allow_external);
    let codes = episodes.iter().map(|episode| render_one(&session, episode, options));
    codes.fold(ExitCode::Done, |ended, code| if ended == ExitCode::Done { code } else { ended })
}

fn render_one(session: &Session, which: &ReplayOptions, options: &RenderOptions) -> ExitCode {
    let name = which.name;
    let path = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}-{}.svg", name.run, name.number)));
    let writer: &dyn Export =
        if options.animate { &Animation { path: path.clone() } } else { &Strip { path: path.clone() } };
    let replay = match session.export(which, writer) {
        Ok(replay) => replay,
        Err(error) => return failure::failed(&error),
    };
    console::say(&path.display().to_string());
    if replay.episode.differences.is_empty() {
        return ExitCode::Done;
    }
    console::fail(&format!("{name} differs from its report; `falsify replay {name}` shows where"));
    ExitCode::Differs
}
