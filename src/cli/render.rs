use std::path::PathBuf;

use super::repeat::{self, Repeated};
use super::repeat_args::RenderOptions;
use super::{ExitCode, front};
use crate::report;

/// `falsify render`
pub fn render(options: &RenderOptions) -> ExitCode {
    let name = options.which.name;
    let repeated = repeat::find(&options.which)
        .and_then(|report| repeat::open(report, &options.which.repeat))
        .and_then(|source| source.repeat(name));
    let repeated = match repeated {
        Ok(repeated) => repeated,
        Err(code) => return code,
    };
    let Repeated { scenario, trace, verdict, title, .. } = &repeated;
    let draw = if options.animate { report::animation } else { report::strip };
    let page = draw(scenario, trace, verdict.as_ref(), &headline(&repeated), title);
    let path = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}-{}.svg", name.run, name.number)));
    if let Err(error) = report::write_file(&path, page.as_bytes()) {
        front::fail(&error.to_string());
        return ExitCode::WriteFailed;
    }
    front::say(&path.display().to_string());
    if repeated.differences.is_empty() {
        return ExitCode::Done;
    }
    front::fail(&format!("{name} came out differently than in its report; `falsify replay {name}` says where"));
    ExitCode::Differs
}

/// What is to be seen, in a line.
fn headline(repeated: &Repeated) -> String {
    let what = match (repeated.outcome.impact_speed(), &repeated.verdict) {
        (Some(speed), Some(verdict)) => {
            format!("hit at {speed:.1} m/s, {}", verdict.label.name().replace('_', " "))
        }
        _ => format!("no hit, least gap {:.2} m", repeated.outcome.least_gap),
    };
    format!("{}: {what}", repeated.name)
}
