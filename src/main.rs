//! The program `falsify`.

fn main() -> std::process::ExitCode {
    falsify::internal::cli::main().into()
}
