use super::{ExitCode, args::CheckOptions, front};

/// `falsify check`
pub fn check(options: &CheckOptions) -> ExitCode {
    match front::compile_files(&options.files) {
        Ok((plan, sources)) => {
            let (files, campaigns) = (sources.iter().count(), plan.campaigns.len());
            let plural = |n: usize| if n == 1 { "" } else { "s" };
            anstream::println!(
                "{files} file{} and {campaigns} campaign{} checked: no errors",
                plural(files),
                plural(campaigns)
            );
            ExitCode::Done
        }
        Err(code) => code,
    }
}
