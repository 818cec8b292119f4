//! The program `falsify`.

fn main() -> std::process::ExitCode {
    falsify::command_line(falsify::language::Catalog::builtin, std::env::args_os())
}
