//! Start; nothing else.

fn main() -> std::process::ExitCode {
    burnish::cli::main()
}
