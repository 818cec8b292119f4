//! The program `falsify`.

fn main() -> std::process::ExitCode {
    program::cli::main().into()
}
