//! The program `falsify`.

fn main() -> std::process::ExitCode {
    falsify::cli::main().into()
}
