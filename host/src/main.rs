//! The motorlens program.

fn main() -> std::process::ExitCode {
    motorlens::cli::main()
}
