//! The binary: arguments in, one call, an exit code.

fn main() -> std::process::ExitCode {
    morsemill::cli::main()
}
