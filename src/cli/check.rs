use super::{ExitCode, args::CheckOptions, front};

/// `falsify check`
pub fn check(options: &CheckOptions) -> ExitCode {
    match front::compile_files(&options.files, &options.given) {
        Ok((plan, files)) => {
            let (files, campaigns) = (files.len(), plan.campaigns.len());
            let plural = |n: usize| if n == 1 { "" } else { "s" };
            front::say(&format!(
                "{files} file{} and {campaigns} campaign{} checked: no errors",
                plural(files),
                plural(campaigns)
            ));
            ExitCode::Done
        }
        Err(code) => code,
    }
}
