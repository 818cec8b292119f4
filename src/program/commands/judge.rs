use clap::Args;
use serde_json::json;

use crate::cli::console;
use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::session::{self, Encountered, Reference};

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify judge trace.csv                    would a careful driver have avoided the first touch?
  falsify judge trace.csv --length 4.2 --width 1.8 --radius 0.25 --json
  falsify replay 1a2b3c4d:17 --ticks way.csv && falsify judge way.csv
                                             an episode of ours, as if no building stood there

The columns, in any order, others are ignored:
  time_s                                     time, with a constant step of 0.001 s to 0.5 s
  ego_x_m, ego_y_m                           middle of the car's box
  ego_yaw_deg, ego_speed_mps                 its heading, from x to y, and its speed along it
  pedestrian_x_m, pedestrian_y_m             middle of the pedestrian
  pedestrian_yaw_deg, pedestrian_speed_mps   direction and speed of its motion; without both they come from the positions

The frame is right-handed. Of recordings from CARLA change the signs of y and of the heading.

Exit codes: 0 it was judged   2 the file cannot be read, or is no recording";

/// Options of `falsify judge`.
#[derive(Debug, Args)]
pub struct JudgeArgs {
    /// The recording.
    #[command(flatten)]
    pub recording: session::JudgeOptions,
    /// Print one JSON object, for programs.
    #[arg(long)]
    pub json: bool,
}

/// `falsify judge`
pub fn judge(options: &JudgeArgs) -> Ended {
    let found = session(false).judge(&options.recording).map_err(failed)?;
    if options.json {
        console::say(&as_json(&found).to_string());
    } else {
        tell(&found);
    }
    Ok(ExitCode::Done)
}

/// Prints the result for people.
fn tell(found: &Encountered) {
    let near = &found.near_miss;
    let (Some(touch), Some(verdict)) = (found.touch, &found.verdict) else {
        console::say(&format!("no touch; the least distance is {:.2} m", found.least_gap));
        if let Some(ttc) = near.min_ttc {
            console::say(&format!("the least time to collision is {ttc:.2} s"));
        }
        if let Some(pet) = near.pet {
            console::say(&format!("the post-encroachment time is {pet:.2} s"));
        }
        return;
    };
    console::say(&format!("touch after {touch:.2} s, the car drives {:.2} m/s", verdict.impact_speed));
    console::say(&format!("verdict: {}", verdict.word()));
    let moved = if verdict.foreseeable { "moved as people do" } else { "did not move as people do" };
    let counts = if verdict.is_fault() { "counts" } else { "does not count" };
    console::say(&format!("the pedestrian {moved}: the touch {counts} against the driver"));
    console::say(&format!("the danger started {:.2} s before the touch", verdict.warning));
    for reference in Reference::ALL {
        let result = if verdict.trial(reference).is_avoided() { "avoids it" } else { "does not avoid it" };
        console::say(&format!("  {:<14}{result}", reference.name()));
    }
}

/// Makes an object of the result, with the names of the table of episodes; what does not apply is null.
fn as_json(found: &Encountered) -> serde_json::Value {
    let verdict = found.verdict.as_ref();
    let avoided = verdict.map(|verdict| {
        let of = |reference: Reference| (reference.name(), json!(verdict.trial(reference).is_avoided()));
        Reference::ALL.map(of).into_iter().collect::<std::collections::BTreeMap<_, _>>()
    });
    json!({
        "touch_s": found.touch,
        "impact_speed_mps": verdict.map(|verdict| verdict.impact_speed),
        "verdict": verdict.map(|verdict| verdict.label.name()),
        "foreseeable": verdict.map(|verdict| verdict.foreseeable),
        "fault": verdict.map(crate::session::Verdict::is_fault),
        "warning_s": verdict.map(|verdict| verdict.warning),
        "avoided_by": avoided,
        "least_gap_m": found.least_gap,
        "min_ttc_s": found.near_miss.min_ttc,
        "pet_s": found.near_miss.pet,
    })
}
