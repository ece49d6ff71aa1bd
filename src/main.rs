//! The `murrine` program: see [`murrine::cli`].

fn main() -> std::process::ExitCode {
    murrine::cli::main()
}
