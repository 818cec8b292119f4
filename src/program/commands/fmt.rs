use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::console;
use crate::cli::failure::{misused, unwritten};
use crate::exit_code::{Ended, ExitCode};
use base::diagnostic::Sources;
use base::files;

pub const EXAMPLES: &str = "\
Examples:
  falsify fmt my.scn                         lay the file out anew
  falsify fmt --check scenarios/*.scn        only say which files are not laid out; exit code 3 if any is not
  falsify fmt --stdin < my.scn               for editors: from the input to the output";

/// Options of `falsify fmt`.
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// Scenario files.
    #[arg(required_unless_present = "stdin", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Change nothing; name the files that would change.
    #[arg(long)]
    pub check: bool,
    /// Read from the input and write to the output.
    #[arg(long, conflicts_with = "files")]
    pub stdin: bool,
}

pub fn fmt(options: &FmtArgs) -> Ended {
    if options.stdin {
        return input(options.check);
    }
    let codes = options.files.iter().map(|path| file(path, options.check).unwrap_or_else(|code| code));
    // The last file that is not laid out decides.
    Ok(codes.fold(ExitCode::Done, |worst, code| code.or(worst)))
}

fn file(path: &Path, check: bool) -> Ended {
    let text = base::files::text(path);
    let text = text.map_err(|error| misused(format!("cannot read `{}`: {}", path.display(), lang::reason(&error))))?;
    let laid_out = lay_out(path, &text)?;
    if laid_out == text {
        return Ok(ExitCode::Done);
    }
    if check {
        console::say(&path.display().to_string());
        return Err(ExitCode::Scenario);
    }
    let written = write(path, &text, &laid_out);
    written.map_err(|error| unwritten(format!("cannot write `{}`: {error}", path.display())))?;
    Ok(ExitCode::Done)
}

fn input(check: bool) -> Ended {
    let text = files::text_of(std::io::stdin());
    let text = text.map_err(|error| misused(format!("cannot read the input: {}", lang::reason(&error))))?;
    let laid_out = lay_out(Path::new("<input>"), &text)?;
    if check {
        return if laid_out == text { Ok(ExitCode::Done) } else { Err(ExitCode::Scenario) };
    }
    std::io::stdout().write_all(laid_out.as_bytes()).map_err(|_| ExitCode::WriteFailed)?;
    Ok(ExitCode::Done)
}

/// Formats a text. For a text with errors it shows the errors and changes nothing.
fn lay_out(path: &Path, text: &str) -> Result<String, ExitCode> {
    let mut sources = Sources::default();
    let source = sources.add(path, text.strip_prefix('\u{feff}').unwrap_or(text));
    lang::format(source, text).map_err(|said| {
        console::show(&said, &sources);
        console::fail(&format!("`{}` cannot be read and was left alone", path.display()));
        ExitCode::Scenario
    })
}

/// Replaces a file that has the text `before`, in one step, so that a failure loses nothing.
///
/// # Errors
/// The file cannot be written, or has another text by now.
pub(super) fn write(path: &Path, before: &str, text: &str) -> std::io::Result<()> {
    // A link is followed to the file itself.
    let path = std::fs::canonicalize(path)?;
    let metadata = std::fs::metadata(&path)?;
    // An administrator could replace it all the same.
    if metadata.permissions().readonly() {
        return Err(std::io::ErrorKind::PermissionDenied.into());
    }
    let mut file = results::report::staging_file(path.parent().unwrap_or(Path::new(".")))?;
    file.write_all(text.as_bytes())?;
    file.as_file().set_permissions(metadata.permissions())?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Only an administrator can keep the owner of another user's file.
        let _ = fchown(file.as_file(), Some(metadata.uid()), Some(metadata.gid()));
    }
    file.as_file().sync_all()?;
    if std::fs::read(&path)? != before.as_bytes() {
        return Err(std::io::Error::other("it was saved meanwhile; run the command again"));
    }
    file.persist(&path)?;
    Ok(())
}
