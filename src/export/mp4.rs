//! MP4: a film, encoded by the program `ffmpeg`.

use std::io::Write;
use std::process::{Command, Stdio};

use super::film::{Film, SIZE};
use super::{Episode, ExportError, ExportFile, Exporter, Variant};

/// The exporter of MP4.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mp4;

const NAME: &str = "mp4";
const PROGRAM: &str = "ffmpeg";
/// Frames in a second of the file.
const RATE: f64 = 20.0;

impl Exporter for Mp4 {
    fn name(&self) -> &'static str {
        NAME
    }

    fn about(&self) -> &'static str {
        "a video from above; needs the program ffmpeg"
    }

    fn approximates(&self) -> &'static str {
        "as gif; other versions of ffmpeg give other bytes"
    }

    fn export(&self, episode: &Episode, _: Variant) -> Result<Vec<ExportFile>, ExportError> {
        let bytes = encode(&Film::new(episode))?;
        Ok(vec![ExportFile { name: format!("{}.mp4", episode.stem()), bytes }])
    }
}

fn failed(problem: String) -> ExportError {
    ExportError::Program { format: NAME, program: PROGRAM, problem }
}

fn encode(film: &Film) -> Result<Vec<u8>, ExportError> {
    let [width, height] = SIZE;
    // A file whose index precedes its pictures needs no seeking, so the program writes it to its output.
    let mut child = Command::new(PROGRAM)
        .args(["-hide_banner", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"])
        .args(["-video_size", &format!("{width}x{height}"), "-framerate", &RATE.to_string(), "-i", "-"])
        .args(["-pix_fmt", "yuv420p", "-movflags", "frag_keyframe+empty_moov", "-bitexact", "-f", "mp4", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| failed(format!("cannot be started ({error}): install it, or export as gif")))?;
    let mut input = child.stdin.take().expect("piped");
    let output = std::thread::scope(|scope| {
        scope.spawn(move || {
            // When the program ends early, its exit code and its messages are the error.
            let _ = write_frames(film, &mut input);
        });
        child.wait_with_output()
    });
    let output = output.map_err(|error| failed(format!("gives no result: {error}")))?;
    if !output.status.success() || output.stdout.is_empty() {
        let said = String::from_utf8_lossy(&output.stderr);
        let said = said.lines().next_back().unwrap_or("no message");
        return Err(failed(format!("fails ({}): {said}", output.status)));
    }
    Ok(output.stdout)
}

/// Writes the pictures at a fixed rate.
fn write_frames(film: &Film, input: &mut impl Write) -> std::io::Result<()> {
    let count = (film.time(film.len()) * RATE).round() as usize;
    let (mut number, mut frame) = (0, film.frame(0));
    for picture in 0..count {
        let time = picture as f64 / RATE;
        let last = number;
        while number + 1 < film.len() && film.time(number + 1) <= time + 1e-9 {
            number += 1;
        }
        if number != last {
            frame = film.frame(number);
        }
        input.write_all(frame.pixels.as_flattened())?;
    }
    Ok(())
}
